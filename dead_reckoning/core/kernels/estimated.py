"""Estimate the attitude along columns, and remove gravity: the loop of `EstimatedAttitude`."""

from __future__ import annotations

from math import exp, sqrt
from typing import NamedTuple

from dead_reckoning.core.attitude.estimated import FREE_FALL
from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import (
    Array,
    ImuColumns,
    is_unknown,
    matrix,
    measured,
    put,
    put_matrix,
    put_quaternion,
    put_vector,
    triple,
    usable,
    vector,
)
from dead_reckoning.core.kernels.gravity import LevelledColumns, level_row, noise_of
from dead_reckoning.core.rest import MINIMUM_SAMPLES
from dead_reckoning.core.rotation import (
    composed,
    matrix_from_quaternion,
    quaternion_from_turn,
    rotate,
    unit,
)
from dead_reckoning.core.samples import NANOSECONDS, Matrix, Quaternion, Vector

WEAKEST = 0.01
"""Smoothed gravity [m/s²] below which the stream has to see to it that there is a vertical."""

GRAVITY, MOTION, LOST, SHAKEN, YAW, YAW_BIAS, BIAS = range(7)
"""What the elements of `Estimate.figures` are: smoothed gravity, the variances of
`EstimatedAttitude` by their names, and that of the bias."""


class Estimate(NamedTuple):
    """State of an `EstimatedAttitude`.

    ``attitude``   shape (4,): takes the sensor into the world.
    ``rate``       shape (3,) [rad/s]: that of the last sample.
    ``force``      shape (3,) [m/s²]: smoothed, world.
    ``turned``     shape (3,) [rad]: by the gyro and not yet corrected, world.
    ``figures``    shape (7,).
    """

    attitude: Array
    rate: Array
    force: Array
    turned: Array
    figures: Array


class EstimateRules(NamedTuple):
    """What does not change from sample to sample, by the names of `EstimatedAttitude`.

    ``window_ns``, ``window_count``, ``duration_ns`` say when the window that looks for rest began,
    how many samples it holds, and how long it is: what fills it is for the stream.
    """

    bias: Vector
    tilt_time: float
    max_gap: float
    walk_variance: float
    scale_deviation: float
    level_variance: float
    compass_variance: float
    rate_fallback: Matrix
    noise_fallback: Matrix
    window_ns: int
    window_count: int
    duration_ns: int


@compiled
def level_estimated(
    imu: ImuColumns,
    begin: int,
    last_ns: int,
    rules: EstimateRules,
    state: Estimate,
    gravity: tuple[float, float],
    rate: Array,
    rate_covariance: Array,
    out: LevelledColumns,
) -> int:
    """Turn with the gyro, level, and remove gravity; return the end of what is regular.

    ``rate`` and its covariance come out without the bias.  Row 0 of what comes out is row
    ``begin`` of ``imu``.
    """
    figures, count = state.figures, rules.window_count
    for i in range(begin, len(imu.stamp_ns)):
        stamp_ns = imu.stamp_ns[i]
        dt = (stamp_ns - last_ns) / NANOSECONDS
        count += 1
        if not (
            stamp_ns > last_ns
            and dt <= rules.max_gap
            and (stamp_ns - rules.window_ns < rules.duration_ns or count < MINIMUM_SAMPLES)
            and measured(imu.force_covariance, i)
            and measured(imu.rate_covariance, i)
            and usable(imu, i)
            and figures[GRAVITY] > WEAKEST
        ):
            return i
        last_ns = stamp_ns
        force_s, rate_s = vector(imu.force, i), vector(imu.rate, i)
        rate_noise = matrix(imu.rate_covariance, i)
        if is_unknown(rate_noise):
            rate_noise = rules.rate_fallback
        figures[BIAS] += rules.walk_variance * dt
        attitude = _turn(state, rules.bias, rules.tilt_time, dt, rate_s)
        attitude = _follow_gravity(state, attitude, exp(-dt / rules.tilt_time), force_s)
        _spread(
            figures, dt, (rate_noise[0] + rate_noise[4] + rate_noise[8]) / 3.0, rules.tilt_time
        )
        x, y, z = triple(state.turned)
        scale = rules.scale_deviation
        tilt = rules.level_variance + figures[MOTION] / figures[GRAVITY] ** 2 + figures[LOST]
        tilt += figures[SHAKEN] + 4.0 * rules.tilt_time**2 * figures[BIAS]
        tilt += (scale * x) ** 2 + (scale * y) ** 2
        yaw = figures[YAW] + rules.compass_variance + (scale * z) ** 2
        known = (tilt, 0.0, 0.0, 0.0, tilt, 0.0, 0.0, 0.0, yaw)
        row, noise = i - begin, noise_of(imu, i, rules.noise_fallback)
        level_row(out, row, matrix_from_quaternion(attitude), force_s, known, noise, gravity)
        put_matrix(out.force_covariance, row, noise)
        put_quaternion(out.orientation, row, attitude)
        put_matrix(out.orientation_covariance, row, known)
        bx, by, bz = rules.bias
        x, y, z = rate_s[0] - bx, rate_s[1] - by, rate_s[2] - bz
        put_vector(rate, row, (x, y, z))
        xx, xy, xz, _, yy, yz, _, _, zz = rate_noise
        bias = figures[BIAS]
        xx, yy, zz = xx + bias + (scale * x) ** 2, yy + bias + (scale * y) ** 2, zz + bias
        zz += (scale * z) ** 2
        put_matrix(rate_covariance, row, (xx, xy, xz, xy, yy, yz, xz, yz, zz))
        state.attitude[0], state.attitude[1], state.attitude[2], state.attitude[3] = attitude
    return len(imu.stamp_ns)


def _turn(state: Estimate, bias: Vector, tilt_time: float, dt: float, after: Vector) -> Quaternion:
    """Integrate the rate: `EstimatedAttitude._turn`."""
    before, (bx, by, bz) = triple(state.rate), bias
    x0, y0, z0 = before[0] - bx, before[1] - by, before[2] - bz
    x1, y1, z1 = after[0] - bx, after[1] - by, after[2] - bz
    half, coning = 0.5 * dt, dt * dt / 12.0
    turn = (
        half * (x0 + x1) + coning * (y0 * z1 - z0 * y1),
        half * (y0 + y1) + coning * (z0 * x1 - x0 * z1),
        half * (z0 + z1) + coning * (x0 * y1 - y0 * x1),
    )
    q = state.attitude
    attitude = unit(composed((q[0], q[1], q[2], q[3]), quaternion_from_turn(turn)))
    x, y, z = rotate(matrix_from_quaternion(attitude), turn)
    forget = exp(-half / tilt_time)
    tx, ty, tz = triple(state.turned)
    put(state.turned, (forget * tx + x, forget * ty + y, tz + z))
    put(state.rate, after)
    return attitude


def _follow_gravity(
    state: Estimate, attitude: Quaternion, keep: float, force_s: Vector
) -> Quaternion:
    """Turn the world so that the smoothed force points up: `EstimatedAttitude._follow_gravity`."""
    figures = state.figures
    x, y, z = rotate(matrix_from_quaternion(attitude), force_s)
    ax, ay, az = triple(state.force)
    ax, ay, az = x + keep * (ax - x), y + keep * (ay - y), z + keep * (az - z)
    put(state.force, (ax, ay, az))
    gx, gy, gz = ax - keep * ax, ay - keep * ay, az + keep * (figures[GRAVITY] - az)
    if gz > FREE_FALL * figures[GRAVITY]:
        length = sqrt(gx * gx + gy * gy + gz * gz)
        turn = unit((gy, -gx, 0.0, length + gz))
        attitude = unit(composed(turn, attitude))
        put(state.force, rotate(matrix_from_quaternion(turn), (ax, ay, az)))
        figures[GRAVITY] = length
    ax, ay, az = triple(state.force)
    excess = ax * ax + ay * ay
    figures[MOTION] = excess + keep * (figures[MOTION] - excess)
    return attitude


def _spread(figures: Array, dt: float, noise: float, tilt_time: float) -> None:
    """Let grow what is not known: `EstimatedAttitude._spread`."""
    figures[SHAKEN] = 1.25 * tilt_time * noise * dt
    figures[LOST] *= exp(-dt / tilt_time)
    bias = figures[BIAS]
    figures[YAW] += dt * (2.0 * figures[YAW_BIAS] + dt * bias + dt * noise)
    figures[YAW_BIAS] += dt * bias
