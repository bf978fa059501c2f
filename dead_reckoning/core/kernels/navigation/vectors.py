"""Take a velocity or a position that something else measures, and a pose that is set."""

from __future__ import annotations

from math import sqrt

import numpy as np

from dead_reckoning.core.kernels.columns import Array, put, triple
from dead_reckoning.core.kernels.navigation.layout import (
    AID_REFUSED,
    AIDED,
    AIDING_CORRELATION,
    AIDING_GATE,
    AIDING_PATIENCE,
    ATTITUDE,
    AVERAGING,
    BODY_VELOCITY,
    COUNTS,
    ERRORS,
    FLOOR,
    FLOOR_KNOWN,
    MOVES,
    PLACED,
    POSITION,
    RATE_BIAS,
    STEP,
    VELOCITY,
    WORLD_POSITION,
    X_POSITION,
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
    normalized_square,
    project,
    put_attitude,
    turn_world,
)
from dead_reckoning.core.kernels.navigation.strapdown import added, cross
from dead_reckoning.core.rotation import (
    cross_matrix,
    matrix_from_quaternion,
    product,
    rotate,
    rotate_back,
    yaw_from_quaternion,
)
from dead_reckoning.core.samples import UNMEASURED_VARIANCE, Vector

MOVING = 1.5
"""Time [s] for which a velocity shows that the body moves: a GNSS gives one each second."""

UNKNOWN = 1e6
"""So many times a variance is as good as none; its inverse is far above rounding."""


def follow_vector(aid: Array, rate: Vector, f: Filter) -> None:
    """Take a velocity or a position of a point of the body; ``rate`` [rad/s] is the sample's.

    Its axes are turned and scaled such that their errors are independent, of variance 1: with
    L Lᵀ its covariance, L⁻¹ y and L⁻¹ H.  Where an error lasts, the more there are in that time,
    by the interval [s], the less each counts.  What is refused for too long shows that the filter
    is wrong, by as much as can be seen.  A velocity that is none of a body at rest, refused or
    not, says for `MOVING` that what looks like rest is a steady drive.
    """
    state, rules, who = f.state, f.rules, int(aid[4])
    if state[STEP] == 0.0 and aid[1] < 0.0:  # of a gap, after which nothing is as it was
        state[COUNTS + AIDED + 2 * who + 1] += 1.0
        return
    what, half = int(aid[3]), aid[9:15]
    if what != WORLD_POSITION:
        known = half[0], half[1], half[2], half[3], half[4], half[5]
        if normalized_square(known, triple(aid[6:9])) > rules[AIDING_GATE]:
            state[MOVES] = MOVING
    rows = np.zeros((3, ERRORS))
    since = -aid[1] - 0.5 * rules[AVERAGING] * state[STEP]  # a mean shows the middle of its time
    y = _innovation(what, triple(aid[6:9]), triple(aid[15:18]), since, rate, f, rows)
    seen = y
    y = _whiten(half, y, rows)
    excess = _square(rows, y, f) > rules[AIDING_GATE]
    if not believed(f, AID_REFUSED + who, excess, aid[5], rules[AIDING_PATIENCE]):
        state[COUNTS + AIDED + 2 * who + 1] += 1.0
        return
    if excess:
        of = POSITION if what == WORLD_POSITION else VELOCITY
        if what == BODY_VELOCITY:
            seen = rotate(matrix_from_quaternion(attitude_of(state)), seen)
        for i in range(3):
            f.p[of + i, of + i] += seen[i] * seen[i]
        state[AID_REFUSED + who] = 0.0
    weaker = max(1.0, 2.0 * rules[AIDING_CORRELATION] / aid[5]) if aid[5] > 0.0 else 1.0
    for i in range(3):
        for a in range(ERRORS):
            f.h[a] = rows[i, a]
        measure(f, y[i], weaker)
    inject(f)
    state[COUNTS + AIDED + 2 * who] += 1.0


def _innovation(
    what: int, value: Vector, arm: Vector, since: float, rate: Vector, f: Filter, rows: Array
) -> Vector:
    """Write H, shape (3, 16), of a point r from the sensor; return by how much it is otherwise.

    u = v + R (ω − b_g) × r has the errors ξ + θ × û + R̂ [r]× δb_g, Rᵀ u those of ξ and δb_g alone,
    R̂ᵀ ξ + [r]× δb_g; p + R r has δp + θ × R̂ r, and was u · since less when it was measured.
    """
    state = f.state
    rot_ws = matrix_from_quaternion(attitude_of(state))
    w = added(rate, triple(state[X_RATE_BIAS : X_RATE_BIAS + 3]), -1.0)
    velocity = triple(state[X_VELOCITY : X_VELOCITY + 3])
    crossed = cross_matrix(arm)
    if what == BODY_VELOCITY:
        for i in range(3):
            for j in range(3):
                rows[i, VELOCITY + j] = rot_ws[3 * j + i]
                rows[i, RATE_BIAS + j] = crossed[3 * i + j]
        return added(value, added(rotate_back(rot_ws, velocity), cross(w, arm), 1.0), -1.0)
    u = added(velocity, rotate(rot_ws, cross(w, arm)), 1.0)
    if what == WORLD_POSITION:
        away = rotate(rot_ws, arm)
        _turns(away, rows)
        for i in range(3):
            rows[i, POSITION + i] = 1.0
        expected = added(added(triple(state[X_POSITION : X_POSITION + 3]), away, 1.0), u, -since)
        return added(value, expected, -1.0)
    _turns(u, rows)
    of_bias = product(rot_ws, crossed)
    for i in range(3):
        rows[i, VELOCITY + i] = 1.0
        for j in range(3):
            rows[i, RATE_BIAS + j] = of_bias[3 * i + j]
    return added(value, u, -1.0)


def _turns(vector: Vector, rows: Array) -> None:
    """Write of which θ a vector turns: θ × vector."""
    x, y, z = vector
    rows[0, ATTITUDE + 1], rows[0, ATTITUDE + 2] = z, -y
    rows[1, ATTITUDE], rows[1, ATTITUDE + 2] = -z, x
    rows[2, ATTITUDE], rows[2, ATTITUDE + 1] = y, -x


def _whiten(half: Array, y: Vector, rows: Array) -> Vector:
    """Return L⁻¹ y and let H become L⁻¹ H, with L Lᵀ the covariance of which half is given."""
    l00 = sqrt(half[0])
    l10, l20 = half[1] / l00, half[2] / l00
    l11 = sqrt(half[3] - l10 * l10)
    l21 = (half[4] - l10 * l20) / l11
    l22 = sqrt(half[5] - l20 * l20 - l21 * l21)
    for a in range(ERRORS):
        rows[0, a] /= l00
        rows[1, a] = (rows[1, a] - l10 * rows[0, a]) / l11
        rows[2, a] = (rows[2, a] - l20 * rows[0, a] - l21 * rows[1, a]) / l22
    y0 = y[0] / l00
    y1 = (y[1] - l10 * y0) / l11
    return y0, y1, (y[2] - l20 * y0 - l21 * y1) / l22


def _square(rows: Array, y: Vector, f: Filter) -> float:
    """Return yᵀ (H P Hᵀ + I)⁻¹ y."""
    s = np.zeros((3, 3))
    for i in range(3):
        for a in range(ERRORS):
            f.h[a] = rows[i, a]
        project(f)
        for j in range(3):
            for a in range(ERRORS):
                s[i, j] += rows[j, a] * f.gain[a]
    clear(f.h)
    a, d, f_ = s[0, 0] + 1.0, s[1, 1] + 1.0, s[2, 2] + 1.0
    return normalized_square((a, s[0, 1], s[0, 2], d, s[1, 2], f_), y)


def place(aid: Array, f: Filter) -> None:
    """Set position and attitude to a pose, but for what it does not know.

    The velocity along the axes of the body stays.  What is set is where a point of the body is, so
    the error of the sensor's position is that of the attitude, too: the position counts as unknown
    and the point is measured there.
    """
    state, rows = f.state, np.zeros((3, ERRORS))
    sets_yaw = aid[21] < UNMEASURED_VARIANCE
    sets_tilt = sets_yaw and max(aid[16], aid[19]) < UNMEASURED_VARIANCE
    attitude = (aid[12], aid[13], aid[14], aid[15])
    if sets_yaw:
        turn_world(f, yaw_from_quaternion(attitude) - yaw_from_quaternion(attitude_of(state)))
        f.h[ATTITUDE + 2] = 1.0
    if sets_tilt:
        velocity = triple(state[X_VELOCITY : X_VELOCITY + 3])
        along = rotate_back(matrix_from_quaternion(attitude_of(state)), velocity)
        put_attitude(state, attitude)
        velocity = rotate(matrix_from_quaternion(attitude_of(state)), along)
        put(state[X_VELOCITY : X_VELOCITY + 3], velocity)
        f.h[ATTITUDE] = f.h[ATTITUDE + 1] = 1.0
    away = rotate(matrix_from_quaternion(attitude_of(state)), triple(aid[22:25]))
    for i, variance in enumerate((aid[6], aid[9], aid[11])):
        if variance < UNMEASURED_VARIANCE:
            state[X_POSITION + i] = aid[3 + i] + away[i]
            f.h[POSITION + i] = 1.0
            state[FLOOR_KNOWN] = 0.0  # another place may have another one
    f.h[FLOOR] = f.h[POSITION + 2]
    sets = (f.h[0], f.h[1], f.h[2])
    marks = (f.h[ATTITUDE], f.h[ATTITUDE + 1], f.h[ATTITUDE + 2])
    forget(f)
    _put_half(f.p, ATTITUDE, aid[16:22], marks)
    _turns((-away[0], -away[1], -away[2]), rows)
    for i, variance in enumerate((aid[6], aid[9], aid[11])):
        rows[i, POSITION + i] = 1.0
        if sets[i] > 0.0:
            for a in range(ATTITUDE, ATTITUDE + 3):
                variance += 3.0 * rows[i, a] * rows[i, a] * f.p[a, a]
            f.p[i, i] = UNKNOWN * variance
    _whiten(aid[6:12], (0.0, 0.0, 0.0), rows)
    for i in range(3):
        if sets[i] > 0.0:
            for a in range(ERRORS):
                f.h[a] = rows[i, a]
            measure(f, 0.0, 1.0)
    inject(f)
    state[COUNTS + PLACED] += 1.0


def _put_half(p: Array, begin: int, half: Array, marks: Vector) -> None:
    """Write a symmetric block of P, where it is marked."""
    k = 0
    for i in range(3):
        for j in range(i, 3):
            if marks[i] * marks[j] > 0.0:
                p[begin + i, begin + j] = p[begin + j, begin + i] = half[k]
            k += 1
