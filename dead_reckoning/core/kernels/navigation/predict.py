"""Carry state and covariance to the next sample, or over a gap."""

from __future__ import annotations

from dead_reckoning.core.kernels.columns import Array, matrix, put, triple
from dead_reckoning.core.kernels.navigation.layout import (
    ACCELERATION_NOISE,
    ACCELERATION_WALK,
    ATTITUDE,
    AVERAGING,
    COUNTS,
    FORCE,
    FORCE_BEFORE,
    FORCE_BIAS,
    FORCE_RANGE,
    GAP,
    GAP_SPEED,
    GAP_TURN,
    GRAVITY,
    MOUNTED,
    RATE,
    RATE_BEFORE,
    RATE_BIAS,
    RATE_NOISE,
    RATE_RANGE,
    RATE_REFUSED,
    RATE_SCALE,
    RATE_WALK,
    REFUSED,
    SAMPLING_NOISE,
    SATURATED,
    STEP,
    STILL_COUNT,
    VELOCITY,
    X_FORCE_BIAS,
    X_POSITION,
    X_RATE_BIAS,
    X_VELOCITY,
    Filter,
)
from dead_reckoning.core.kernels.navigation.measurement import (
    attitude_of,
    forget,
    put_attitude,
)
from dead_reckoning.core.kernels.navigation.strapdown import (
    added,
    carry,
    increments,
    integral,
    mirror,
    moved,
    spread,
    transpose,
)
from dead_reckoning.core.rotation import rotate_back
from dead_reckoning.core.samples import Vector


def predict(dt: float, force: Vector, rate: Vector, f: Filter, trace: Array) -> None:
    """Carry state and covariance to the next sample."""
    rules, state, p = f.rules, f.state, f.p
    gravity = rules[GRAVITY]
    f1, f0 = _unbiased(state, FORCE, X_FORCE_BIAS), _unbiased(state, FORCE_BEFORE, X_FORCE_BIAS)
    w1, w0 = _unbiased(state, RATE, X_RATE_BIAS), _unbiased(state, RATE_BEFORE, X_RATE_BIAS)
    f2 = added(force, triple(state[X_FORCE_BIAS : X_FORCE_BIAS + 3]), -1.0)
    w2 = added(rate, triple(state[X_RATE_BIAS : X_RATE_BIAS + 3]), -1.0)
    turn = integral(dt, state[STEP], w2, w1, w0, rules[AVERAGING])
    push = integral(dt, state[STEP], f2, f1, f0, rules[AVERAGING])
    turn, push = increments(dt, turn, push, w1, w2, f1, f2)
    velocity = triple(state[X_VELOCITY : X_VELOCITY + 3])
    way, velocity, attitude, rot_ws = moved(dt, gravity, velocity, attitude_of(state), turn, push)
    for i in range(3):
        state[X_POSITION + i] += way[i]
        state[X_VELOCITY + i] = velocity[i]
    put_attitude(state, attitude)
    carry(p, dt, gravity, rot_ws, way, velocity)
    transpose(p)
    carry(p, dt, gravity, rot_ws, way, velocity)
    x, y, z = added(f2, f1, -1.0)
    hidden = rules[SAMPLING_NOISE] * dt
    of_velocity = rules[ACCELERATION_NOISE] ** 2 * dt + hidden * hidden * (x * x + y * y + z * z)
    x, y, z = w2
    askew = rules[RATE_SCALE] ** 2 * (x * x + y * y + z * z)
    of_rate = (rules[RATE_NOISE] ** 2 + askew) * dt
    clipped = _reaches(force, rules, FORCE_RANGE)
    spun_out = _reaches(rate, rules, RATE_RANGE)
    if clipped or spun_out:
        state[COUNTS + SATURATED] += 1.0
    if clipped:
        of_velocity += (rules[FORCE_RANGE] * dt) ** 2
    if spun_out:
        of_rate += (rules[RATE_RANGE] * dt) ** 2
    spread(p, velocity, of_velocity, of_rate)
    wander(dt, f)
    mirror(p)
    if len(trace):
        trace[0, 0] = dt
        for i in range(9):
            trace[0, 1 + i] = rot_ws[i]
        put(trace[0, 10:13], way)
        put(trace[0, 13:16], velocity)


def wander(dt: float, f: Filter) -> None:
    """Let the biases wander."""
    rules, p = f.rules, f.p
    for i in range(3):
        p[RATE_BIAS + i, RATE_BIAS + i] += rules[RATE_WALK] ** 2 * dt
        p[FORCE_BIAS + i, FORCE_BIAS + i] += rules[ACCELERATION_WALK] ** 2 * dt


def _unbiased(state: Array, begin: int, bias: int) -> Vector:
    """Return three elements of the state less a bias."""
    return (
        state[begin] - state[bias],
        state[begin + 1] - state[bias + 1],
        state[begin + 2] - state[bias + 2],
    )


def _reaches(vector: Vector, rules: Array, full_scale: int) -> bool:
    """Say whether an axis of the sensor reaches its full scale, where that is known."""
    most = 0.999 * rules[full_scale]
    if most == 0.0:
        return False
    x, y, z = rotate_back(matrix(rules[MOUNTED : MOUNTED + 9].reshape((1, 9)), 0), vector)
    return bool(max(abs(x), abs(y), abs(z)) >= most)


def skip(dt: float, f: Filter) -> None:
    """Hold position and attitude over a gap, and forget the velocity."""
    rules, state, p = f.rules, f.state, f.p
    state[COUNTS + GAP] += 1.0
    state[STILL_COUNT] = state[REFUSED] = state[RATE_REFUSED] = 0.0
    for i in range(3):
        state[X_VELOCITY + i] = 0.0
        f.h[VELOCITY + i] = 1.0
    forget(f)
    for i in range(3):
        p[VELOCITY + i, VELOCITY + i] = rules[GAP_SPEED] ** 2
        p[i, i] += (rules[GAP_SPEED] * dt) ** 2
        p[ATTITUDE + i, ATTITUDE + i] += (rules[GAP_TURN] * dt) ** 2
    wander(dt, f)
