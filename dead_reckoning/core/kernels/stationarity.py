"""Judge rest from samples in a moving window, with a threshold that follows the gait."""

from __future__ import annotations

from collections.abc import Callable
from math import nan, sqrt
from types import FunctionType
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.stationarity import Watch

BEHIND, AHEAD, MINIMUM, HYSTERESIS, MEMORY, EXPONENT, GRAVITY, LEAST, MOST, WEIGHT = range(10)
"""Elements of the rules: those of `Watch`, and the detector's own."""

COUNT, LOW, RUN, RESTS, START = range(5)
"""Elements of the state: samples so far; whether the last was below the threshold, and how many in
a row; the last verdict; begin of the rings.  These are the samples of the window, (statistic,
threshold, low) of the shortest rest, and two queues."""


class Sums(NamedTuple):
    """Sums over the n samples of a window: Σf (3), Σ|f|, Σ|f|², Σ|ω|²."""

    n: int
    x: float
    y: float
    z: float
    magnitude: float
    force: float
    rate: float


Statistic: TypeAlias = Callable[[Sums, float, float], float]
"""What a window shows, from its sums, gravity [m/s²] and the detector's weight."""


def state_of(watch: Watch) -> Array:
    """Return the state before the first sample."""
    return np.zeros(
        START
        + 6 * (watch.behind + watch.ahead + 1)
        + 3 * watch.minimum
        + 2 * (2 + 2 * (watch.memory + 2))
    )


def rules_of(watch: Watch, least: float, most: float, weight: float) -> Array:
    """Return what the kernel goes by: the threshold is from ``least`` to ``most``."""
    return np.array([*watch, least, most, weight], np.float64)


def kernel_of(statistic: Statistic) -> Callable[[Array, Array, Array, Array], None]:
    """Return the kernel that judges by a statistic: samples, rules, state, verdicts."""
    own: Any = {**_judge.__globals__, '_statistic': statistic}
    return compiled(FunctionType(_judge.__code__, own, _judge.__name__))


def _statistic(sums: Sums, gravity: float, weight: float) -> float:
    raise NotImplementedError  # `kernel_of` puts that of a detector here


def _judge(samples: Array, rules: Array, state: Array, verdicts: Array) -> None:
    """Judge samples: rest is a statistic below T for long enough.

    T = min(max(low, least)^(1 − e) · max(high, least)^e, most) with the least and the greatest
    statistic over the memory, low and high, and the exponent e.
    """
    ahead, minimum, memory = int(rules[AHEAD]), int(rules[MINIMUM]), int(rules[MEMORY])
    width = int(rules[BEHIND]) + ahead + 1
    window = state[START : START + 6 * width].reshape((width, 6))
    begin = START + 6 * width + 3 * minimum
    recent = state[START + 6 * width : begin].reshape((minimum, 3))
    half = 2 + 2 * (memory + 2)
    lows, highs = state[begin : begin + half], state[begin + half : begin + 2 * half]
    least, exponent = rules[LEAST], rules[EXPONENT]
    for k in range(len(samples)):
        count = int(state[COUNT])
        state[COUNT] = count + 1
        for i in range(6):
            window[count % width, i] = samples[k, 1 + i]
        verdicts[k, 0], verdicts[k, 1], verdicts[k, 2] = nan, nan, 0.0
        j = count - ahead  # the sample whose statistic is known now
        if j < 0:
            continue
        sums = _sums(window, min(count + 1, width))
        statistic = _statistic(sums, rules[GRAVITY], rules[WEIGHT])
        low = max(_least(lows, memory, j, statistic), least)
        high = max(-_least(highs, memory, j, -statistic), least)
        threshold = min(low ** (1.0 - exponent) * high**exponent, rules[MOST])
        factor = rules[HYSTERESIS] if state[LOW] else 1.0
        state[LOW] = 1.0 if statistic < factor * threshold else 0.0
        state[RUN] = state[RUN] + 1.0 if state[LOW] else 0.0
        slot = j % minimum
        recent[slot, 0], recent[slot, 1], recent[slot, 2] = statistic, threshold, state[LOW]
        if j < minimum - 1:
            continue
        slot = (j + 1) % minimum  # the oldest, which is judged now
        rests = state[RUN] >= minimum or (state[RESTS] > 0.0 and recent[slot, 2] > 0.0)
        state[RESTS] = 1.0 if rests else 0.0
        verdicts[k, 0], verdicts[k, 1] = recent[slot, 0], recent[slot, 1]
        verdicts[k, 2] = state[RESTS]


def _sums(window: Array, count: int) -> Sums:
    x = y = z = magnitude = force = rate = 0.0
    for i in range(count):
        fx, fy, fz = window[i, 0], window[i, 1], window[i, 2]
        square = fx * fx + fy * fy + fz * fz
        x, y, z = x + fx, y + fy, z + fz
        magnitude, force = magnitude + sqrt(square), force + square
        rate += window[i, 3] ** 2 + window[i, 4] ** 2 + window[i, 5] ** 2
    return Sums(count, x, y, z, magnitude, force, rate)


def _least(queue: Array, memory: int, j: int, value: float) -> float:
    """Put value j in; return the least of the values from j − memory to j.

    A monotone queue: only what may yet be the least is kept, (index, value) in a ring whose head
    and length come first.
    """
    size = memory + 2
    head, length = int(queue[0]), int(queue[1])
    while length and queue[3 + 2 * ((head + length - 1) % size)] >= value:
        length -= 1
    while length and queue[2 + 2 * head] < j - memory:
        head, length = (head + 1) % size, length - 1
    slot = 2 + 2 * ((head + length) % size)
    queue[slot], queue[slot + 1] = j, value
    queue[0], queue[1] = head, length + 1
    return float(queue[3 + 2 * head])
