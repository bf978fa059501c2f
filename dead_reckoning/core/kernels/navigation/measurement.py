"""Take a measurement into the state and its covariance."""

from __future__ import annotations

from math import cos, sin
from typing import TypeAlias

from dead_reckoning.core.kernels.columns import Array, put, triple
from dead_reckoning.core.kernels.navigation.layout import (
    ATTITUDE,
    ERRORS,
    FLOOR,
    FOLLOW,
    FORCE_BIAS,
    FORGET,
    LOGGED,
    MEASURE,
    NONHOLONOMIC,
    RATE_BIAS,
    TURN,
    VELOCITY,
    X_ATTITUDE,
    X_FLOOR,
    X_FORCE_BIAS,
    X_POSITION,
    X_RATE_BIAS,
    X_VELOCITY,
    Filter,
)
from dead_reckoning.core.kernels.navigation.strapdown import added, mirror, transpose
from dead_reckoning.core.rotation import (
    composed,
    matrix_from_quaternion,
    quaternion_from_turn,
    rotate,
    unit,
)
from dead_reckoning.core.samples import Quaternion, Vector

Half: TypeAlias = tuple[float, float, float, float, float, float]
"""The upper half of a symmetric matrix, shape (3, 3), row by row."""


def measure(f: Filter, innovation: float, variance: float) -> None:
    """Measure ``f.h`` · errors, and clear ``f.h``; the correction waits in ``f.dx``.

    ``innovation`` is that without the corrections that wait, ``variance`` that of the measurement.
    """
    p, h, dx, gain = f.p, f.h, f.dx, f.gain
    total = project(f) + variance
    known = 0.0
    for a in range(ERRORS):
        if h[a] != 0.0:
            known += h[a] * dx[a]
    innovation -= known
    inverse = 1.0 / total
    for a in range(ERRORS):
        share = gain[a] * inverse
        dx[a] += share * innovation
        for b in range(a, ERRORS):
            p[a, b] -= share * gain[b]
    mirror(p)
    entry = enter(f, MEASURE)
    if entry >= 0:
        f.log[entry, 1], f.log[entry, 2] = total, innovation
        for a in range(ERRORS):
            f.log[entry, 3 + a] = gain[a] * inverse
    clear(h)


def project(f: Filter) -> float:
    """Write P Hᵀ into ``f.gain`` and return H P Hᵀ."""
    p, h, gain = f.p, f.h, f.gain
    clear(gain)
    for b in range(ERRORS):
        if h[b] != 0.0:
            for a in range(ERRORS):
                gain[a] += h[b] * p[b, a]
    total = 0.0
    for b in range(ERRORS):
        if h[b] != 0.0:
            total += h[b] * gain[b]
    return total


def enter(f: Filter, what: int) -> int:
    """Begin an entry of the log, with ``f.h`` in it; return its place, −1 where none is kept."""
    entry = int(f.state[LOGGED])
    f.state[LOGGED] = entry + 1
    if entry >= len(f.log):
        return -1
    f.log[entry, 0] = what
    for a in range(ERRORS):
        f.log[entry, 3 + ERRORS + a] = f.h[a]
    return entry


def clear(vector: Array) -> None:
    """Write zeros."""
    for a in range(len(vector)):
        vector[a] = 0.0


def nis(p: Array, variance: float, y: Vector) -> float:
    """Return yᵀ S⁻¹ y of the velocity, S = P_ξξ + variance · I."""
    a, d, f = p[3, 3] + variance, p[4, 4] + variance, p[5, 5] + variance
    return normalized_square((a, p[3, 4], p[3, 5], d, p[4, 5], f), y)


def normalized_square(s: Half, y: Vector) -> float:
    """Return yᵀ S⁻¹ y; of S, shape (3, 3), the upper half is given.

    By S = L D Lᵀ: a determinant has no digits left where one axis is known a million times worse.
    """
    a, b, c, d, e, f = s
    l10, l20 = b / a, c / a
    d, e = d - l10 * b, e - l10 * c
    l21 = e / d
    f -= l20 * c + l21 * e
    y0, y1 = y[0], y[1] - l10 * y[0]
    y2 = y[2] - l20 * y0 - l21 * y1
    return float(y0 * y0 / a + y1 * y1 / d + y2 * y2 / f)


def believed(f: Filter, refused: int, excess: bool, dt: float, patience: float) -> bool:
    """Say whether to take what may be in excess of its gate, and keep the time of refusals.

    An error that lasts longer than it may is none, but shows that the filter is wrong.
    """
    if not excess:
        f.state[refused] = 0.0
    elif f.state[refused] <= patience:
        f.state[refused] += dt
        return False
    return True


def forget(f: Filter) -> None:
    """Let go of the errors that ``f.h`` marks, and clear ``f.h``; their variances are 0 then."""
    for a in range(ERRORS):
        if f.h[a] != 0.0:
            for b in range(ERRORS):
                f.p[a, b] = f.p[b, a] = 0.0
    enter(f, FORGET)
    clear(f.h)


def turn_world(f: Filter, angle: float) -> None:
    """Turn velocity and attitude about the vertical by an angle [rad]; the position stays."""
    x, turn = f.state, (0.0, 0.0, angle)
    put_attitude(x, composed(quaternion_from_turn(turn), attitude_of(x)))
    c, s = cos(angle), sin(angle)
    vx, vy = x[X_VELOCITY], x[X_VELOCITY + 1]
    x[X_VELOCITY], x[X_VELOCITY + 1] = c * vx - s * vy, s * vx + c * vy
    _turn(f, TURN, turn)


def inject(f: Filter) -> None:
    """Correct the state, and let the velocity turn with the attitude.

    What wheels measure is along the axes of the body, R̂ᵀ ξ, so there ξ turns along, too: else
    each turn of R̂ would let them measure a little of a speed that they do not show.
    """
    if f.rules[NONHOLONOMIC] > 0.0:
        _turn(f, FOLLOW, triple(f.dx[ATTITUDE : ATTITUDE + 3]))
    correct(f.state, f.dx)
    clear(f.dx)


def _turn(f: Filter, what: int, turn: Vector) -> None:
    """Turn errors by a rotation vector [rad], and log that."""
    turn_both(f.p, what, turn)
    mirror(f.p)
    entry = enter(f, what)
    if entry >= 0:
        put(f.log[entry, 1:4], turn)


def turn_both(m: Array, what: int, turn: Vector) -> None:
    """Turn rows and columns of m, symmetric, shape (16, 16), as `turn_errors` does rows."""
    turn_errors(m, what, turn)
    transpose(m)
    turn_errors(m, what, turn)


def turn_errors(m: Array, what: int, turn: Vector) -> None:
    """Turn rows of m, shape (16, n), by a rotation vector [rad].

    They are those of the velocity, and, where ``what`` is TURN and not FOLLOW, of the attitude.
    """
    rot = matrix_from_quaternion(quaternion_from_turn(turn))
    for i in (VELOCITY, ATTITUDE):
        if i == VELOCITY or what == TURN:
            for j in range(m.shape[1]):
                m[i, j], m[i + 1, j], m[i + 2, j] = rotate(
                    rot, (m[i, j], m[i + 1, j], m[i + 2, j])
                )


def correct(x: Array, dx: Array) -> None:
    """Add errors, shape (16,), to what is estimated, shape (≥ 17,).

    v = exp(θ) (v̂ + ξ), exactly: v̂ + θ × v̂ would be faster with each large θ.
    """
    turn = quaternion_from_turn(triple(dx[ATTITUDE : ATTITUDE + 3]))
    velocity = triple(x[X_VELOCITY : X_VELOCITY + 3])
    velocity = added(velocity, triple(dx[VELOCITY : VELOCITY + 3]), 1.0)
    put(x[X_VELOCITY : X_VELOCITY + 3], rotate(matrix_from_quaternion(turn), velocity))
    for i in range(3):
        x[X_POSITION + i] += dx[i]
        x[X_RATE_BIAS + i] += dx[RATE_BIAS + i]
        x[X_FORCE_BIAS + i] += dx[FORCE_BIAS + i]
    x[X_FLOOR] += dx[FLOOR]
    put_attitude(x, composed(turn, attitude_of(x)))


def attitude_of(state: Array) -> Quaternion:
    """Return the attitude in a state."""
    a = X_ATTITUDE
    return state[a], state[a + 1], state[a + 2], state[a + 3]


def put_attitude(state: Array, attitude: Quaternion) -> None:
    """Write an attitude, at unit length, into a state."""
    attitude = unit(attitude)
    for i in range(4):
        state[X_ATTITUDE + i] = attitude[i]
