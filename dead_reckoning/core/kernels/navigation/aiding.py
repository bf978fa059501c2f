"""What is known beside rests: yaw and level, and how a held or a driven body moves."""

from __future__ import annotations

from math import floor, sqrt, tau

from dead_reckoning.core.kernels import rare
from dead_reckoning.core.kernels.columns import Array, put, triple
from dead_reckoning.core.kernels.navigation.layout import (
    AID_REFUSED,
    AIDED,
    ATTITUDE,
    AVERAGING,
    AXIS_GATE,
    AXLE,
    BOUND_REFUSED,
    BOUNDED,
    BOUNDED_REFUSED,
    COUNTS,
    FORCE_BIAS,
    GATE,
    GRAVITY,
    HELD,
    HELD_TIME,
    HELD_VELOCITY,
    LEVEL,
    NORTH,
    PLACE,
    RATE_BIAS,
    ROLL_REFUSED,
    ROLLING,
    ROLLING_REFUSED,
    SLIP,
    SLIP_ANGLE,
    SLIP_TIME,
    STEP,
    VECTOR,
    VELOCITY,
    X_FORCE_BIAS,
    X_RATE_BIAS,
    X_VELOCITY,
    Filter,
)
from dead_reckoning.core.kernels.navigation.measurement import (
    attitude_of,
    believed,
    clear,
    forget,
    inject,
    measure,
    nis,
    project,
    put_attitude,
    turn_world,
)
from dead_reckoning.core.kernels.navigation.strapdown import added, cross
from dead_reckoning.core.kernels.navigation.vectors import follow_vector, place
from dead_reckoning.core.rotation import (
    composed,
    cross_matrix,
    matrix_from_quaternion,
    rotate,
    rotate_back,
    yaw_from_quaternion,
)
from dead_reckoning.core.samples import Matrix, Vector

UPRIGHT = 0.1
"""Square of the horizontal part of the body's x axis below which it has no heading."""

AT_REST = 1e-4
"""Variance of the velocity at a rest that levels [m²/s²]."""

NO_TILT = 1.0
"""Variance of a tilt of which nothing is known [rad²]."""


@rare
def take_aid(aid: Array, rate: Vector, f: Filter) -> None:
    """Take what else is known of a sample; ``rate`` [rad/s] is the sample's."""
    if aid[2] == LEVEL:
        level(triple(aid[3:6]), triple(aid[6:9]), aid[9], aid[10], f)
    elif aid[2] == NORTH:
        turn_world(f, _wrapped(aid[3] - yaw_from_quaternion(attitude_of(f.state))))
        f.p[ATTITUDE + 2, ATTITUDE + 2] += aid[4]
    elif aid[2] == VECTOR:
        follow_vector(aid, rate, f)
    elif aid[2] == PLACE:
        place(aid, f)
    else:
        follow_yaw(aid, rate, f)


def follow_yaw(aid: Array, rate: Vector, f: Filter) -> None:
    """Take the yaw that a compass, or a pose, showed some time ago.

    The yaw of R = exp(θ) R̂, that of its x axis e, changes by θ_z − e_z (e_x θ_x + e_y θ_y)/(e_x² +
    e_y²).  Its error lasts, so its variance [rad²] says whether it may be, but the more there are
    in that time, by the interval [s], the less each counts.
    """
    state, h = f.state, f.h
    age, yaw, variance, interval, lasts, patience, who = (
        -aid[1], aid[3], aid[4], aid[5], aid[6], aid[7], int(aid[8]),
    )  # fmt: skip
    attitude = attitude_of(state)
    rot_ws = matrix_from_quaternion(attitude)
    x, y, z = rot_ws[0], rot_ws[3], rot_ws[6]
    level_part = x * x + y * y
    if level_part < UPRIGHT:
        return
    if state[STEP] == 0.0 and age > 0.0:  # of a gap, after which nothing is as it was
        state[COUNTS + AIDED + 2 * who + 1] += 1.0
        return
    h[ATTITUDE], h[ATTITUDE + 1], h[ATTITUDE + 2] = -z * x / level_part, -z * y / level_part, 1.0
    wx, wy, wz = rotate(rot_ws, added(rate, triple(state[X_RATE_BIAS : X_RATE_BIAS + 3]), -1.0))
    since = age - 0.5 * f.rules[AVERAGING] * state[STEP]  # a mean shows the middle of its time
    turned = since * (h[ATTITUDE] * wx + h[ATTITUDE + 1] * wy + wz)
    innovation = _wrapped(yaw + turned - yaw_from_quaternion(attitude))
    excess = innovation * innovation > f.rules[AXIS_GATE] * (project(f) + variance)
    if not believed(f, AID_REFUSED + who, excess, interval, patience):
        state[COUNTS + AIDED + 2 * who + 1] += 1.0
        h[ATTITUDE] = h[ATTITUDE + 1] = h[ATTITUDE + 2] = 0.0
        return
    if lasts > 0.0:
        variance *= max(1.0, 2.0 * lasts / interval)
    measure(f, innovation, variance)
    inject(f)
    state[COUNTS + AIDED + 2 * who] += 1.0


def _wrapped(angle: float) -> float:
    """Return an angle between −π and π."""
    return angle - tau * floor(angle / tau + 0.5)


def level(force: Vector, rate: Vector, of_force: float, of_rate: float, f: Filter) -> None:
    """Take tilt and bias of the gyro from a rest; position and yaw stay.

    ``force`` and ``rate`` are means over it, ``of_force`` and ``of_rate`` their variances.  What
    the tilt is wrong by is what the bias of the accelerometer is, R (f − b_a) = (0, 0, g).  A bias
    of the gyro that is known better, and agrees, stays.
    """
    state, p, h, gravity = f.state, f.p, f.h, f.rules[GRAVITY]
    attitude = attitude_of(state)
    force = added(force, triple(state[X_FORCE_BIAS : X_FORCE_BIAS + 3]), -1.0)
    x, y, z = rotate(matrix_from_quaternion(attitude), force)
    length = sqrt(x * x + y * y + z * z)
    attitude = composed((y, -x, 0.0, length + z), attitude)  # takes it to the vertical
    put_attitude(state, attitude)
    put(state[X_VELOCITY : X_VELOCITY + 3], (0.0, 0.0, 0.0))
    h[ATTITUDE] = h[ATTITUDE + 1] = 1.0
    for i in range(3):
        h[VELOCITY + i] = 1.0
        known = p[RATE_BIAS + i, RATE_BIAS + i]
        excess = rate[i] - state[X_RATE_BIAS + i]
        if known > of_rate or excess * excess > f.rules[AXIS_GATE] * (known + of_rate):
            h[RATE_BIAS + i] = 1.0
            state[X_RATE_BIAS + i] = rate[i]
    anew = (h[RATE_BIAS], h[RATE_BIAS + 1], h[RATE_BIAS + 2])
    forget(f)
    p[ATTITUDE, ATTITUDE] = p[ATTITUDE + 1, ATTITUDE + 1] = NO_TILT
    for i in range(3):
        p[VELOCITY + i, VELOCITY + i] = AT_REST
        if anew[i] > 0.0:
            p[RATE_BIAS + i, RATE_BIAS + i] = of_rate
    rot_ws = matrix_from_quaternion(attitude_of(state))
    for i in range(2):
        h[ATTITUDE + 1 - i] = gravity if i == 0 else -gravity
        for j in range(3):
            h[FORCE_BIAS + j] = -rot_ws[3 * i + j]
        measure(f, 0.0, of_force)
    inject(f)
    state[HELD] = 0.0


def bound_velocity(dt: float, f: Filter) -> None:
    """Take a held body for slow: what its velocity would become shows where down is."""
    rules, state = f.rules, f.state
    x, y, z = triple(state[X_VELOCITY : X_VELOCITY + 3])
    variance = rules[HELD_VELOCITY] ** 2
    excess = nis(f.p, variance, (x, y, z)) > rules[GATE]
    if not believed(f, BOUND_REFUSED, excess, dt, rules[HELD_TIME]):
        state[COUNTS + BOUNDED_REFUSED] += 1.0
        return
    for i in range(3):
        f.h[VELOCITY + i] = 1.0
        measure(f, -state[X_VELOCITY + i], variance * rules[HELD_TIME] / dt)
    inject(f)
    state[COUNTS + BOUNDED] += 1.0


def roll_along(dt: float, rate: Vector, f: Filter) -> None:
    """Take the wheels of a vehicle, whose axle moves neither sideways nor up.

    Of v_b = Rᵀ v + (ω − b_g) × r the errors are R̂ᵀ ξ + [r]× δb_g, whatever the attitude.
    """
    rules, state = f.rules, f.state
    rot_ws = matrix_from_quaternion(attitude_of(state))
    w = added(rate, triple(state[X_RATE_BIAS : X_RATE_BIAS + 3]), -1.0)
    r = triple(rules[AXLE : AXLE + 3])
    velocity = triple(state[X_VELOCITY : X_VELOCITY + 3])
    v = added(rotate_back(rot_ws, velocity), cross(w, r), 1.0)
    askew = rules[SLIP_ANGLE] * v[0]
    variance = rules[SLIP] ** 2 + askew * askew
    excess = False
    for i in range(2):
        _look_along(1 + i, rot_ws, r, f.h)
        excess = excess or v[1 + i] * v[1 + i] > rules[AXIS_GATE] * (project(f) + variance)
    if not believed(f, ROLL_REFUSED, excess, dt, rules[SLIP_TIME]):
        state[COUNTS + ROLLING_REFUSED] += 1.0
        clear(f.h)
        return
    for i in range(2):
        _look_along(1 + i, rot_ws, r, f.h)
        measure(f, -v[1 + i], variance * rules[SLIP_TIME] / dt)
    inject(f)
    state[COUNTS + ROLLING] += 1.0


def _look_along(axis: int, rot_ws: Matrix, arm: Vector, h: Array) -> None:
    """Let the next measurement be the velocity at an arm, along an axis of the body."""
    crossed = cross_matrix(arm)
    for j in range(3):
        h[VELOCITY + j] = rot_ws[3 * j + axis]
        h[RATE_BIAS + j] = crossed[3 * axis + j]
