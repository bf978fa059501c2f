"""Judge rest from samples in a moving window, with a threshold that follows noise and gait."""

from __future__ import annotations

from math import nan, sqrt
from typing import NamedTuple

import numpy as np

from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.stationarity import Watch

BEHIND, AHEAD, MINIMUM, HYSTERESIS, MEMORY, FACTOR, GRAVITY, FLOOR, SHARE, WEIGHT = range(10)
"""Elements of the rules: those of `Watch`, and the detector's own."""

COUNT, LOW, RUN, RESTS, START = range(5)
"""Elements of the state: samples so far; whether the last was below the threshold, and how many in
a row; the last verdict; begin of the rings.  These are the samples of the window, (statistic,
threshold, low) of the shortest rest, and two queues."""

LASTING = 2
"""A statistic that is kept for so many windows is a swing; what is shorter may be a knock."""


class Sums(NamedTuple):
    """Sums over the n samples of a window: Σf (3), Σ|f|, Σ|f|², Σ|ω|²."""

    n: int
    x: float
    y: float
    z: float
    magnitude: float
    force: float
    rate: float


def state_of(watch: Watch) -> Array:
    """Return the state before the first sample."""
    width = watch.behind + watch.ahead + 1
    queues = _length(LASTING * width - 1) + _length(watch.memory)
    return np.zeros(START + 6 * width + 3 * watch.minimum + queues)


def rules_of(watch: Watch, floor: float, share: float, weight: float) -> Array:
    """Return what the kernel goes by: the threshold is a ``share`` of a swing or the ``floor``."""
    return np.array([*watch, floor, share, weight], np.float64)


def window_sums(sample: Array, rules: Array, state: Array) -> Sums:
    """Take a sample, shape (≥ 7,), into the window; return the sums over it."""
    width = int(rules[BEHIND]) + int(rules[AHEAD]) + 1
    window = state[START : START + 6 * width].reshape((width, 6))
    count = int(state[COUNT])
    state[COUNT] = count + 1
    for i in range(6):
        window[count % width, i] = sample[1 + i]
    n = min(count + 1, width)
    x = y = z = magnitude = force = rate = 0.0
    for i in range(n):
        fx, fy, fz = window[i, 0], window[i, 1], window[i, 2]
        square = fx * fx + fy * fy + fz * fz
        x, y, z = x + fx, y + fy, z + fz
        magnitude, force = magnitude + sqrt(square), force + square
        rate += window[i, 3] ** 2 + window[i, 4] ** 2 + window[i, 5] ** 2
    return Sums(n, x, y, z, magnitude, force, rate)


def judge(statistic: float, rules: Array, state: Array, verdict: Array) -> None:
    """Judge by the statistic of the window, shape (3,) the verdict: rest is low for long enough.

    Low is below T = max(floor, share · q₁) with q₁ the greatest statistic that lasted, of those in
    the memory.
    """
    ahead, minimum, memory = int(rules[AHEAD]), int(rules[MINIMUM]), int(rules[MEMORY])
    verdict[0], verdict[1], verdict[2] = nan, nan, 0.0
    j = int(state[COUNT]) - 1 - ahead  # the sample in the middle of the window
    if j < 0:
        return
    width = int(rules[BEHIND]) + ahead + 1
    begin = START + 6 * width
    recent = state[begin : begin + 3 * minimum].reshape((minimum, 3))
    begin += 3 * minimum
    span = LASTING * width - 1
    middle = begin + _length(span)
    lasting = _least(state[begin:middle], span, j, statistic)
    if j < span:
        lasting = 0.0
    swing = -_least(state[middle : middle + _length(memory)], memory, j, -lasting)
    threshold = max(rules[FLOOR], rules[SHARE] * swing)
    factor = rules[HYSTERESIS] if state[LOW] else 1.0
    state[LOW] = 1.0 if statistic < factor * threshold else 0.0
    state[RUN] = state[RUN] + 1.0 if state[LOW] else 0.0
    slot = j % minimum
    recent[slot, 0], recent[slot, 1], recent[slot, 2] = statistic, threshold, state[LOW]
    if j < minimum - 1:
        return
    slot = (j + 1) % minimum  # the oldest, which is judged now
    rests = state[RUN] >= minimum or (state[RESTS] > 0.0 and recent[slot, 2] > 0.0)
    state[RESTS] = 1.0 if rests else 0.0
    verdict[0], verdict[1], verdict[2] = recent[slot, 0], recent[slot, 1], state[RESTS]


def _length(memory: int) -> int:
    """Return how long the array of a queue over a memory is."""
    return 2 + 2 * (memory + 2)


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
