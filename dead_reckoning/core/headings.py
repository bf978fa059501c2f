"""Remember which way a device pointed, for what is known only later."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass

from dead_reckoning.core.checks import LARGEST_VARIANCE
from dead_reckoning.core.rotation import normalized
from dead_reckoning.core.samples import NANOSECONDS, UNKNOWN, ImuSample, Matrix, Quaternion
from dead_reckoning.core.stamps import RESTART_NS

SPACING_NS = NANOSECONDS // 50
KEPT = 6200
"""Headings of two minutes, for which a rhythm may hold steps back, and of the wait besides."""

SPARE = 1000
"""How many more there may be, as to forget them one by one would move all others each time."""

LONG_AGO_NS = -(2**62)
MINIMUM_LEVEL = 0.1
"""Sine of the angle to the vertical from which on the x axis points somewhere."""


@dataclass(frozen=True, slots=True, eq=False)
class Heading:
    """Where the x axis points, anticlockwise from east.

    ``x``, ``y``
        cosine and sine of the heading.
    ``variance``
        of the heading [rad²].
    """

    stamp_ns: int
    x: float
    y: float
    variance: float


class HeadingHistory:
    """Keep the headings of the last two minutes, fifty a second at most.

    A heading that comes late finds its place; one that is older than the newest by 1 s or more
    starts a new history.
    """

    def __init__(self, deviation: float) -> None:
        """``deviation`` [rad]: of orientations that come without a covariance."""
        self._variance = deviation * deviation
        self.reset()

    def reset(self) -> None:
        """Forget all headings."""
        self._stamps: list[int] = []
        self._headings: list[Heading] = []

    def add(self, imu: ImuSample) -> None:
        """Take the heading of a sample, if it has an orientation whose x axis is not upright.

        Raises `NotFiniteError` for an orientation that is no rotation.
        """
        if imu.orientation is not None:
            self.take(imu.stamp_ns, imu.orientation, imu.orientation_covariance)

    def take(self, stamp_ns: int, orientation: Quaternion, covariance: Matrix) -> None:
        """Take the heading of an orientation; see `ImuSample` for both, and `add`."""
        stamps = self._stamps
        if stamps and stamp_ns <= stamps[-1] - RESTART_NS:
            self.reset()
            stamps = self._stamps
        at = bisect_left(stamps, stamp_ns)
        if at and stamp_ns - stamps[at - 1] < SPACING_NS:
            return
        if at < len(stamps) and stamps[at] - stamp_ns < SPACING_NS:
            return
        qx, qy, qz, qw = normalized(orientation)
        east, north = 1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qw * qz + qx * qy)
        level = (east * east + north * north) ** 0.5
        if level < MINIMUM_LEVEL:
            return
        variance = self._variance if covariance == UNKNOWN else covariance[8]
        if not 0.0 <= variance <= LARGEST_VARIANCE:  # NaN too
            variance = self._variance
        self._insert(at, Heading(stamp_ns, east / level, north / level, variance))

    @property
    def newest_ns(self) -> int:
        """Stamp of the newest heading; without one, before all others."""
        return self._stamps[-1] if self._stamps else LONG_AGO_NS

    def append(self, heading: Heading) -> None:
        """Take a heading that is newer than the others, and far enough from them."""
        self._insert(len(self._stamps), heading)

    def _insert(self, at: int, heading: Heading) -> None:
        self._stamps.insert(at, heading.stamp_ns)
        self._headings.insert(at, heading)
        if len(self._stamps) > KEPT + SPARE:
            del self._stamps[:SPARE], self._headings[:SPARE]

    def at(self, stamp_ns: int, within_ns: int) -> Heading | None:
        """Return the heading nearest to a stamp, or None if none is within that time [ns]."""
        at = bisect_left(self._stamps, stamp_ns)
        near = self._headings[max(0, at - 1) : at + 1]
        if not near:
            return None
        nearest = min(near, key=lambda heading: abs(heading.stamp_ns - stamp_ns))
        return nearest if abs(nearest.stamp_ns - stamp_ns) <= within_ns else None
