"""Take headings from columns of orientations: the loop of `HeadingHistory`."""

from __future__ import annotations

from typing import NamedTuple

from dead_reckoning.core.checks import LARGEST_VARIANCE
from dead_reckoning.core.headings import MINIMUM_LEVEL, SPACING_NS
from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import (
    Array,
    ImuColumns,
    Stamps,
    is_unknown,
    matrix,
    measured,
    quaternion,
)
from dead_reckoning.core.rotation import NO_ROTATION, unit


class HeadingColumns(NamedTuple):
    """What comes out: the row it is from, cosine and sine of the heading, and its variance."""

    row: Stamps
    x: Array
    y: Array
    variance: Array


@compiled
def find_headings(
    imu: ImuColumns,
    begin: int,
    last_ns: int,
    fallback: float,
    required: bool,
    out: HeadingColumns,
) -> tuple[int, int]:
    """Look at rows from one on; return the end of what is regular, and how many headings it has.

    ``last_ns`` is the stamp of the newest heading, ``fallback`` the variance of those without one.
    Irregular are stamps out of order, what is no rotation and, where it is ``required``, a row
    without one.
    """
    found = 0
    before_ns = last_ns
    for i in range(begin, len(imu.stamp_ns)):
        stamp_ns = imu.stamp_ns[i]
        if not stamp_ns > before_ns:
            return i, found
        before_ns = stamp_ns
        if not measured(imu.orientation_covariance, i):
            if required:
                return i, found
            continue
        if stamp_ns - last_ns < SPACING_NS:
            continue
        qx, qy, qz, qw = attitude = unit(quaternion(imu.orientation, i))
        if attitude == NO_ROTATION:
            return i, found
        east, north = 1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qw * qz + qx * qy)
        level = (east * east + north * north) ** 0.5
        if level < MINIMUM_LEVEL:
            continue
        covariance = matrix(imu.orientation_covariance, i)
        variance = fallback if is_unknown(covariance) else covariance[8]
        if not 0.0 <= variance <= LARGEST_VARIANCE:
            variance = fallback
        out.row[found] = i
        out.x[found], out.y[found], out.variance[found] = east / level, north / level, variance
        last_ns = stamp_ns
        found += 1
    return len(imu.stamp_ns), found
