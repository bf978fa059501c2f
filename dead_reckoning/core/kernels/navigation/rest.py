"""What is known while the body rests: its velocity, its rate, and the height of the floor."""

from __future__ import annotations

from math import sqrt

from dead_reckoning.core.kernels.columns import Array, put, triple
from dead_reckoning.core.kernels.navigation.layout import (
    AXIS_GATE,
    CLONE,
    CORRELATION,
    COUNTS,
    ERRORS,
    FLOOR,
    FLOOR_DEVIATION,
    FLOOR_GATE,
    FLOOR_KNOWN,
    FLOOR_SLOPE,
    GATE,
    HEIGHT,
    HELD,
    HOLD,
    HOLDS,
    NEW_FLOOR,
    NOISE,
    ON_FLOOR,
    PATIENCE,
    PIVOT,
    RATE_BIAS,
    RATE_NOISE,
    RATE_REFUSED,
    REFUSED,
    SQUARES,
    STANCE,
    STANCE_VELOCITY,
    STILL_COUNT,
    STILL_DEVIATION,
    STILL_NOISE,
    STILL_WINDOW,
    STOOD,
    SUMS,
    SWAY,
    VELOCITY,
    X_FLOOR,
    X_POSITION,
    X_RATE_BIAS,
    X_VELOCITY,
    ZARU,
    ZARU_REFUSED,
    ZUPT,
    ZUPT_REFUSED,
    Filter,
)
from dead_reckoning.core.kernels.navigation.measurement import (
    attitude_of,
    believed,
    enter,
    inject,
    measure,
    nis,
    project,
)
from dead_reckoning.core.kernels.navigation.strapdown import added
from dead_reckoning.core.rotation import matrix_from_quaternion, rotate
from dead_reckoning.core.samples import Vector


def is_still(rate: Vector, f: Filter) -> bool:
    """Take a rate; say whether it has been still, as still as the sensor was at its stillest."""
    rules, state, rates = f.rules, f.state, f.rates
    n = len(rates)
    count = int(state[STILL_COUNT])
    slot = count % n
    for i in range(3):
        if count >= n:
            state[SUMS + i] -= rates[slot, i]
            state[SQUARES] -= rates[slot, i] ** 2
        rates[slot, i] = rate[i]
    if slot == 0:  # anew, so that no rounding gathers
        state[SQUARES] = 0.0
        for i in range(3):
            state[SUMS + i] = 0.0
            for j in range(1, min(count, n)):
                state[SUMS + i] += rates[j, i]
                state[SQUARES] += rates[j, i] ** 2
    for i in range(3):
        state[SUMS + i] += rate[i]
        state[SQUARES] += rate[i] ** 2
    state[STILL_COUNT] = count + 1
    if count + 1 < n:
        return False
    x, y, z = state[SUMS], state[SUMS + 1], state[SUMS + 2]
    variance = max(0.0, state[SQUARES] / n - (x * x + y * y + z * z) / (n * n)) / 3.0
    if state[NOISE] < 0.0:
        state[NOISE] = rules[STILL_NOISE] ** 2
    state[NOISE] = min(state[NOISE], variance)
    return bool(variance - state[NOISE] < rules[STILL_DEVIATION] ** 2)


def zero_velocity(dt: float, rate: Vector, statistic: float, f: Filter) -> bool:
    """Take a standing foot, which turns about a point below it; say whether it is believed."""
    rules, state = f.rules, f.state
    w = added(rate, triple(state[X_RATE_BIAS : X_RATE_BIAS + 3]), -1.0)
    x, y, _ = rotate(matrix_from_quaternion(attitude_of(state)), w)
    v = X_VELOCITY  # ω × (0, 0, height) − v
    innovation = (
        rules[HEIGHT] * y - state[v],
        -rules[HEIGHT] * x - state[v + 1],
        -state[v + 2],
    )
    rolls = rules[PIVOT] * statistic
    variance = (rules[STANCE_VELOCITY] ** 2 + rolls * rolls) * rules[CORRELATION] / dt
    excess = nis(f.p, variance, innovation) > rules[GATE]
    if not believed(f, REFUSED, excess, dt, rules[PATIENCE]):
        state[COUNTS + ZUPT_REFUSED] += 1.0
        return False
    for i in range(3):
        f.h[VELOCITY + i] = 1.0
        measure(f, innovation[i], variance)
    state[COUNTS + ZUPT] += 1.0
    return True


def zero_rate(dt: float, f: Filter) -> None:
    """Take the rate of a rest for a bias, as the angle of a resting foot stays within the sway.

    The rate is that of the middle of the still window.
    """
    rules, state, rates = f.rules, f.state, f.rates
    n = len(rates)
    rate = triple(rates[(int(state[STILL_COUNT]) - n + n // 2) % n])
    if state[HELD] == 0.0:
        state[HOLDS] = 0.0
        put(state[HOLD : HOLD + 3], (0.0, 0.0, 0.0))
    state[HELD] += dt
    state[HOLDS] += 1.0
    age = state[HELD] + rules[STILL_WINDOW]
    variance = (rules[SWAY] ** 2 / age + rules[RATE_NOISE] ** 2) / dt
    square = 0.0
    for i in range(3):
        state[HOLD + i] += rate[i]
        innovation = _of_rest(i, rate, state)
        square += innovation * innovation / (f.p[RATE_BIAS + i, RATE_BIAS + i] + variance)
    if not believed(f, RATE_REFUSED, square > rules[GATE], dt, rules[PATIENCE]):
        state[COUNTS + ZARU_REFUSED] += 1.0
        return
    for i in range(3):
        f.h[RATE_BIAS + i] = 1.0
        measure(f, _of_rest(i, rate, state), variance)
    state[COUNTS + ZARU] += 1.0


def _of_rest(i: int, rate: Vector, state: Array) -> float:
    """Return what half of a rate and half of the mean so far are beyond the bias."""
    return float(0.5 * (rate[i] + state[HOLD + i] / state[HOLDS]) - state[X_RATE_BIAS + i])


def level_floor(f: Filter) -> None:
    """Level the first sample of a stance with the floor, or begin a new one with it."""
    rules, state = f.rules, f.state
    if state[STOOD] == 0.0 and state[FLOOR_KNOWN] > 0.0:
        rise = state[X_POSITION + 2] - state[X_FLOOR]
        x, y = state[X_POSITION] - state[STANCE], state[X_POSITION + 1] - state[STANCE + 1]
        near = abs(rise) < rules[FLOOR_GATE] + rules[FLOOR_SLOPE] * sqrt(x * x + y * y)
        variance = rules[FLOOR_DEVIATION] ** 2
        f.h[2], f.h[FLOOR] = 1.0, -1.0
        if near and rise * rise <= rules[AXIS_GATE] * (project(f) + variance):
            measure(f, -rise, variance)
            inject(f)
            state[COUNTS + ON_FLOOR] += 1.0
        else:
            f.h[2] = f.h[FLOOR] = 0.0
            state[FLOOR_KNOWN] = 0.0
            state[COUNTS + NEW_FLOOR] += 1.0
    if state[FLOOR_KNOWN] > 0.0:
        return
    state[FLOOR_KNOWN] = 1.0
    state[X_FLOOR] = state[X_POSITION + 2]
    for i in range(ERRORS):  # a clone: its error is that of the height
        f.p[FLOOR, i] = f.p[2, i]
    for i in range(ERRORS):
        f.p[i, FLOOR] = f.p[i, 2]
    enter(f, CLONE)
