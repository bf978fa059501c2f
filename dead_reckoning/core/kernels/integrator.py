"""Integrate columns of linear acceleration: the loop of `Integrator` with two or three axes."""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.acceleration_error import gravity_variance
from dead_reckoning.core.checks import is_measurable
from dead_reckoning.core.integrator import scaled
from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.bias_growth import Growth, covariance, grow, stop, stop_along
from dead_reckoning.core.kernels.columns import (
    Array,
    ImuColumns,
    Stamps,
    is_unknown,
    matrix,
    measured,
    put,
    put_matrix,
    put_quaternion,
    put_vector,
    quaternion,
    triple,
    usable,
    vector,
)
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import (
    NO_ROTATION,
    matrix_from_quaternion,
    rotate,
    rotate_back,
    unit,
)
from dead_reckoning.core.samples import NANOSECONDS, NOT_MEASURED, ZERO, Matrix

Flags = NDArray[np.bool_]

NEWEST, COUNT, AGE = range(3)
"""What the elements of `Motion.ring` are."""


class Rules(NamedTuple):
    """Settings of an `Integrator`, as the kernel takes them; names are those of the settings.

    ``moves``, shape (3,), says along which axes of the sensor the body moves, ``ends`` whether the
    movement-end check is on, and ``each`` whether it goes axis by axis.
    """

    euler: bool
    ends: bool
    each: bool
    moves: Flags
    window_minimum: float
    window_maximum: float
    movement_end_deviation: float
    max_gap: float
    stationary_deviation: float
    scale_deviation: float
    attitude_fallback: Matrix
    noise_fallback: Matrix
    rate_fallback: Matrix


class Motion(NamedTuple):
    """State of an `Integrator` between two samples.

    ``position``, ``velocity``, ``acceleration``   shapes (3,), world.
    ``offset``       shape (3,) [m/s²], frame of the sensor.
    ``stationary``   shape (1,): whether the body rests.
    ``quiet``        shape (3,): samples in a row that look like rest.
    ``recent``       shape (movement_end_samples, 3): accelerations of the last samples, a ring.
    ``ring``         shape (3,): where its newest is, how many it holds, and how many samples came
                     since its sums were made anew.
    ``sums``, ``squares``   shapes (3,): sums over the ring.
    """

    position: Array
    velocity: Array
    acceleration: Array
    offset: Array
    stationary: Flags
    quiet: Stamps
    recent: Array
    ring: Stamps
    sums: Array
    squares: Array


class StateColumns(NamedTuple):
    """Columns of a `StateBlock`."""

    position: Array
    velocity: Array
    attitude: Array
    position_covariance: Array
    velocity_covariance: Array
    attitude_covariance: Array
    angular_velocity: Array
    angular_velocity_covariance: Array
    stationary: Flags


@compiled
def integrate(
    imu: ImuColumns,
    acceleration: Array,
    acceleration_covariance: Array,
    begin: int,
    last_ns: int,
    rules: Rules,
    motion: Motion,
    growth: Growth,
    out: StateColumns,
) -> int:
    """Integrate from a row on; return the end of what is regular.

    Irregular is what `Integrator.update` refuses, a restart and a gap.  Row 0 of ``out`` is row
    ``begin`` of what comes in.
    """
    accel_s, kept_s, kept_w = np.zeros(3), np.zeros(3), np.zeros(3)
    scale_variance = rules.scale_deviation * rules.scale_deviation
    overlooked = rules.stationary_deviation * rules.stationary_deviation
    for i in range(begin, len(imu.stamp_ns)):
        dt = (imu.stamp_ns[i] - last_ns) / NANOSECONDS
        accel_w, vertical = vector(acceleration, i), acceleration_covariance[i, 8]
        if not (
            imu.stamp_ns[i] > last_ns
            and dt <= rules.max_gap
            and is_measurable(accel_w)
            and isfinite(vertical)
            and measured(imu.orientation_covariance, i)
            and usable(imu, i)
        ):
            return i
        orientation = unit(quaternion(imu.orientation, i))
        if orientation == NO_ROTATION:
            return i
        last_ns = imu.stamp_ns[i]
        rot_ws = matrix_from_quaternion(orientation)
        put(accel_s, rotate_back(rot_ws, accel_w))
        _look(accel_s, kept_s, motion.offset, rules.moves, *_window(rules))
        _add_to_movement_end(
            accel_s,
            motion.quiet,
            motion.recent,
            motion.ring,
            motion.sums,
            motion.squares,
            rules.movement_end_deviation**2,
            *_window(rules),
        )
        put(kept_w, rotate(rot_ws, triple(kept_s)))
        attitude = matrix(imu.orientation_covariance, i)
        if is_unknown(attitude):
            attitude = rules.attitude_fallback
        if not motion.stationary[0] or triple(kept_s) != ZERO:
            _step(dt, motion.position, motion.velocity, motion.acceleration, kept_w, rules.euler)
            noise = matrix(imu.force_covariance, i)
            elsewhere = noise[0] < 0.0
            if is_unknown(noise) or elsewhere:
                noise = rules.noise_fallback
            gravity = 0.0
            if not elsewhere:
                gravity = gravity_variance(accel_w, vertical, rot_ws, attitude, noise)
            x, y, z = accel_w
            grow(growth, dt, rot_ws, (x, y, z + GRAVITY), attitude, noise, gravity)
        put(motion.acceleration, triple(kept_w))
        motion.stationary[0] = rules.ends and _check_movement_end(
            motion, growth, rules.moves, rules.each, kept_s, rot_ws
        )
        row, position, velocity = i - begin, triple(motion.position), triple(motion.velocity)
        put_vector(out.position, row, position)
        put_vector(out.velocity, row, velocity)
        put_quaternion(out.attitude, row, orientation)
        known = covariance(growth.position, growth, growth.white[0])
        put_matrix(out.position_covariance, row, scaled(known, position, scale_variance))
        more = overlooked if motion.stationary[0] else 0.0
        known = covariance(growth.velocity, growth, growth.white[2] + more)
        put_matrix(out.velocity_covariance, row, scaled(known, velocity, scale_variance))
        put_matrix(out.attitude_covariance, row, attitude)
        rate, noise = ZERO, NOT_MEASURED
        if measured(imu.rate_covariance, i):
            rate, noise = vector(imu.rate, i), matrix(imu.rate_covariance, i)
            if is_unknown(noise):
                noise = rules.rate_fallback
        put_vector(out.angular_velocity, row, rate)
        put_matrix(out.angular_velocity_covariance, row, noise)
        out.stationary[row] = motion.stationary[0]
    return len(imu.stamp_ns)


def _window(rules: Rules) -> tuple[float, float]:
    return rules.window_minimum, rules.window_maximum


def _look(
    accel_s: Array, kept_s: Array, offset: Array, moves: Flags, low: float, high: float
) -> None:
    """Take off the offset, look through the discrimination window: `Integrator._read`."""
    for axis in range(3):
        value = (accel_s[axis] - offset[axis]) if moves[axis] else 0.0
        accel_s[axis] = value
        kept_s[axis] = 0.0 if low <= value <= high else value


def _add_to_movement_end(
    accel_s: Array,
    quiet: Stamps,
    recent: Array,
    ring: Stamps,
    sums: Array,
    squares: Array,
    largest: float,
    low: float,
    high: float,
) -> None:
    """Count the samples in a row that look like rest: `MovementEnd.add`.

    ``largest`` variance that is rest, ``low`` and ``high`` ends of the discrimination window.
    """
    n = len(recent)
    slot = ring[NEWEST] = (ring[NEWEST] + 1) % n
    full = ring[COUNT] == n
    count = ring[COUNT] = n if full else ring[COUNT] + 1
    ring[AGE] += 1
    anew = ring[AGE] >= n
    if anew:
        ring[AGE] = 0
    for axis in range(3):
        value, oldest = accel_s[axis], recent[slot, axis]
        recent[slot, axis] = value
        total, square = sums[axis] + value, squares[axis] + value * value
        if full:
            total, square = total - oldest, square - oldest * oldest
        if anew:
            total = square = 0.0
            for k in range(slot + 1 - count, slot + 1):
                total += recent[k % n, axis]
                square += recent[k % n, axis] * recent[k % n, axis]
        sums[axis], squares[axis] = total, square
        is_quiet = low <= value <= high
        if not is_quiet:
            mean = total / count
            is_quiet = low <= mean <= high and square / count - mean * mean <= largest
        quiet[axis] = quiet[axis] + 1 if is_quiet else 0


def _step(
    dt: float, position: Array, velocity: Array, before: Array, after: Array, euler: bool
) -> None:
    """Integrate accelerations, shapes (3,), over ``dt`` [s]: `Trapezoid` or `Euler`."""
    half = 0.5 * dt
    for axis in range(3):
        v = velocity[axis]
        if euler:
            position[axis] += dt * v
            velocity[axis] = v + dt * before[axis]
        else:
            velocity[axis] = v + half * (before[axis] + after[axis])
            position[axis] += half * (v + velocity[axis])


def _check_movement_end(
    motion: Motion, growth: Growth, moves: Flags, each: bool, kept_s: Array, rot_ws: Matrix
) -> bool:
    """Say whether the body rests: `Integrator._check_movement_end`."""
    moving = outside = inside = 0
    for axis in range(3):
        if moves[axis]:
            if motion.quiet[axis] < len(motion.recent):
                moving += 1
            elif kept_s[axis] == 0.0:
                inside += 1
            else:
                outside += 1
    if moving > 0:
        if inside > 0 and each:
            _stop_along(motion, growth, moves, kept_s, rot_ws)
        return False
    if outside > 0:
        return bool(motion.stationary[0])
    put(motion.velocity, ZERO)
    stop(growth)
    return True


def _stop_along(
    motion: Motion, growth: Growth, moves: Flags, kept_s: Array, rot_ws: Matrix
) -> None:
    """Let the velocity be zero along the axes whose movement has ended: `OpenLoop.stop_along`."""
    velocity_s = np.zeros(3)
    put(velocity_s, rotate_back(rot_ws, triple(motion.velocity)))
    for axis in range(3):
        if moves[axis] and motion.quiet[axis] >= len(motion.recent) and kept_s[axis] == 0.0:
            velocity_s[axis] = 0.0
            along_s = np.zeros(3)
            along_s[axis] = 1.0
            stop_along(growth, rotate(rot_ws, triple(along_s)))
    put(motion.velocity, rotate(rot_ws, triple(velocity_s)))
