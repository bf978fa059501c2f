"""Remove gravity from columns of specific force: the loop of `GravityRemoval`."""

from __future__ import annotations

from typing import NamedTuple

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import (
    Array,
    ImuColumns,
    is_unknown,
    matrix,
    measured,
    put_matrix,
    put_quaternion,
    put_vector,
    quaternion,
    usable,
    vector,
)
from dead_reckoning.core.rotation import (
    NO_ROTATION,
    cross_covariance,
    matrix_from_quaternion,
    rotate,
    rotate_covariance,
    unit,
)
from dead_reckoning.core.samples import Matrix, Quaternion, Vector


class LevelledColumns(NamedTuple):
    """What comes out: columns of a `LevelledBlock` that are not those of the Imu that came."""

    acceleration: Array
    covariance: Array
    force_covariance: Array
    orientation: Array
    orientation_covariance: Array


@compiled
def level_held(
    imu: ImuColumns,
    begin: int,
    last_ns: int,
    attitude: Quaternion,
    tilt: Matrix,
    gravity: tuple[float, float],
    noise_fallback: Matrix,
    out: LevelledColumns,
) -> int:
    """Remove gravity with one attitude for all; return the end of what is regular.

    ``attitude`` and its covariance ``tilt`` are those of `HeldAttitude`, ``gravity`` is its
    magnitude [m/s²] and the variance of that; row 0 of ``out`` is row ``begin`` of ``imu``.
    """
    rot_ws = matrix_from_quaternion(attitude)
    for i in range(begin, len(imu.stamp_ns)):
        stamp_ns = imu.stamp_ns[i]
        if not (stamp_ns > last_ns and measured(imu.force_covariance, i) and usable(imu, i)):
            return i
        noise = noise_of(imu, i, noise_fallback)
        force_s = vector(imu.force, i)
        level_row(out, i - begin, rot_ws, force_s, tilt, noise, gravity)
        put_matrix(out.force_covariance, i - begin, noise)
        put_quaternion(out.orientation, i - begin, attitude)
        put_matrix(out.orientation_covariance, i - begin, tilt)
        last_ns = stamp_ns
    return len(imu.stamp_ns)


@compiled
def level_message(
    imu: ImuColumns,
    begin: int,
    last_ns: int,
    tilt_fallback: Matrix,
    gravity: tuple[float, float],
    noise_fallback: Matrix,
    out: LevelledColumns,
) -> int:
    """Remove gravity with the attitude of each row, as `level_held` does with one for all."""
    for i in range(begin, len(imu.stamp_ns)):
        stamp_ns = imu.stamp_ns[i]
        if not (
            stamp_ns > last_ns
            and measured(imu.force_covariance, i)
            and measured(imu.orientation_covariance, i)
            and usable(imu, i)
        ):
            return i
        attitude = unit(quaternion(imu.orientation, i))
        if attitude == NO_ROTATION:
            return i
        tilt = matrix(imu.orientation_covariance, i)
        if is_unknown(tilt):
            tilt = tilt_fallback
        force_s, noise = vector(imu.force, i), noise_of(imu, i, noise_fallback)
        rot_ws = matrix_from_quaternion(attitude)
        level_row(out, i - begin, rot_ws, force_s, tilt, noise, gravity)
        last_ns = stamp_ns
    return len(imu.stamp_ns)


def noise_of(imu: ImuColumns, i: int, fallback: Matrix) -> Matrix:
    """Return the covariance of the force of a row, or what stands in where it is unknown."""
    noise = matrix(imu.force_covariance, i)
    return fallback if is_unknown(noise) else noise


def level_row(
    out: LevelledColumns,
    row: int,
    rot_ws: Matrix,
    force_s: Vector,
    tilt: Matrix,
    noise: Matrix,
    gravity: tuple[float, float],
) -> None:
    """Write one acceleration and its covariance, by the equations of `GravityRemoval`."""
    x, y, z = force_w = rotate(rot_ws, force_s)
    magnitude, variance = gravity
    put_vector(out.acceleration, row, (x, y, z - magnitude))
    a, b, c, _, e, f, _, _, i = cross_covariance(force_w, tilt)
    p, q, r, _, t, u, _, _, w = rotate_covariance(rot_ws, noise)
    xx, xy, xz, yy, yz, zz = a + p, b + q, c + r, e + t, f + u, i + w + variance
    put_matrix(out.covariance, row, (xx, xy, xz, xy, yy, yz, xz, yz, zz))
