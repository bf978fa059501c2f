"""Find steps by their rhythm in magnitudes that come 50 times a second: the work of one sample.

docs/pedometer.md derives it.  All is kept in one array, with a place for each of the names below.
Moments are counted in samples from the first one on.
"""

from __future__ import annotations

from math import atan2, cos, exp, pi, sin, sqrt, tan

import numpy as np

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import Array

RATE = 50
"""Samples per second [Hz]."""

SHORTEST, LONGEST = 14, 100
"""Lags that are looked at [samples]: 0.28 to 2 s."""

LOOK = 5
"""Samples from one look at the rhythm to the next."""

LOOKS = 10
"""Looks in the second after which a lag has to fit still."""

CHANGE = 0.2
"""By so much of itself a lag may change in that second."""

LIKE_BEST = 0.85
"""The shortest lag of so much of the best autocorrelation is the cycle."""

STRIDE = 40
"""No stride is shorter [samples], so that a shorter cycle is a step."""

HALF = 0.5
"""A cycle is a stride if half of it has so much of its autocorrelation,"""

HEAVY, HEAVY_HALF = 1.4, -0.6
"""or, where the magnitude deviates by more than this [m/s²], so much: few step so slowly so hard,
but those who do show the half of their step upside down."""

NEAR = 0.35
"""Peaks are no closer than so much of a step's time, in a perfect rhythm; 1 − r in another one."""

FEWEST = 5
"""So many peaks make a walk: four times between them that are alike are no chance."""

MISSED, REST = 1.8, 3.8
"""Of so many steps' times between peaks, a step was not seen, or nobody walked."""

CREDIT = 100
"""Samples before the evidence begins, in which the steps that make it lie."""

WAITING = 1
"""So many peaks that are not like the cycle before may wait for one that is."""

PROMINENCES = 5
"""Of so many peaks the median prominence is taken."""

BEHIND = 7
"""So many samples the filter of the peaks is late, about."""

LANDING = 3.0
"""A foot lands so many samples after the crest of the fundamental, in the median of walks."""

RHYTHM_BAND, PEAK_BAND = (0.6, 3.5), (0.6, 2.8)
"""Where the rhythm is looked for, first order, and the peaks, second order [Hz]."""

SECTIONS = 3
"""Filters of second order: one for the rhythm, two for the peaks."""

RING = 320
"""Samples of the saturated magnitude: the longest lag and two of the longest steps."""

KEPT = 6000
"""Magnitudes that are kept: 2 minutes, in which a rhythm that is weak can show itself."""

PEAKS = 512
"""Peaks that are kept until the gate opens."""

STEPS = 2048
"""Steps that can wait for what comes after them."""

(
    MEMORY, FLOOR, FAINT, CENTRE, STRONG, GAIN, OPEN, CLOSE, LIKENESS, RISE, SHARE, FILTERS,
) = range(12)  # fmt: skip
"""Places of the rules: the settings of `RhythmSettings`, and coefficients from the last one on."""

(
    COUNT, FIRST, ENERGY, SQUARE, CYCLE, PERIOD, CORRELATION, SEEN, EVIDENCE, SINCE, WALKS,
    SEEKS, TOP, TOP_AT, BOTTOM, TURNED, PROMINENT, LAST, HELD, HELD_COUNT, WAITING_COUNT, QUEUED,
    MEMORIES,
) = range(23)  # fmt: skip
"""Places of the state: numbers, then what follows."""

RULES = FILTERS + 5 * SECTIONS
"""How many rules there are."""

PROMINENCE_AT = MEMORIES + 2 * SECTIONS
LOOK_AT = PROMINENCE_AT + PROMINENCES
WAITING_AT = LOOK_AT + LOOKS
LAG_AT = WAITING_AT + WAITING
LIKE_AT = LAG_AT + LONGEST + 2
SATURATED_AT = LIKE_AT + LONGEST + 2
ENERGY_AT = SATURATED_AT + 2 * RING
MAGNITUDE_AT = ENERGY_AT + RING
HELD_AT = MAGNITUDE_AT + KEPT
HEIGHT_AT = HELD_AT + PEAKS
QUEUE_AT = HEIGHT_AT + PEAKS
FOUND_AT = QUEUE_AT + 2 * STEPS
LENGTH = FOUND_AT + 2 * STEPS


def coefficients() -> Array:
    """Return b₀, b₁, b₂, a₁, a₂ of each section, one after the other: Butterworth, bilinear."""
    low, high = (tan(pi * edge / RATE) for edge in RHYTHM_BAND)
    both = (1.0 + low) * (1.0 + high)
    first = (low - 1.0) / (low + 1.0), (high - 1.0) / (high + 1.0)
    sections = [high / both, 0.0, -high / both, first[0] + first[1], first[0] * first[1]]
    for edge, is_high in zip(PEAK_BAND, (True, False), strict=True):
        k = tan(pi * edge / RATE)
        gain = 1.0 / (1.0 + sqrt(2.0) * k + k * k)
        b = (gain, -2.0 * gain) if is_high else (k * k * gain, 2.0 * k * k * gain)
        a = 2.0 * (k * k - 1.0) * gain, (1.0 - sqrt(2.0) * k + k * k) * gain
        sections += [b[0], b[1], b[0], *a]
    return np.array(sections)


def new_state() -> Array:
    """Return the state before the first sample."""
    state = np.zeros(LENGTH)
    state[PERIOD] = 0.5 * RATE
    state[CORRELATION] = 1.0
    state[TURNED] = state[LAST] = -10.0 * RATE
    state[SEEKS] = 1.0
    state[PROMINENCE_AT : PROMINENCE_AT + PROMINENCES] = 1.0
    return state


@compiled
def take(magnitude: float, soonest: float, latest: float, memory: Array) -> int:
    """Take a sample [m/s²]; return twice the number of steps that it proves, and 1 for a walk.

    ``soonest`` and ``latest`` [s] are the least and greatest times between steps; ``memory`` is
    `RULES` rules, then the state: each array that is given costs a tenth of a microsecond.  The
    steps are in the rows of ``state[FOUND_AT:]``, of two: when, and the time of a step then.
    """
    rules, state = memory[:RULES], memory[RULES:]
    now = int(state[COUNT])
    if now == 0:
        state[FIRST] = magnitude
    state[MAGNITUDE_AT + now % KEPT] = magnitude
    saturated, smooth = _filter(magnitude - state[FIRST], rules, state)
    _correlate(saturated, now, rules, state)
    state[SQUARE] += (smooth * smooth - state[SQUARE]) / (6 * RATE)
    peak = _find_peak(smooth, now, rules, state)
    if peak >= 0:
        _take_peak(peak, now, soonest * RATE, rules, state)
    if now % LOOK == 0 and now >= LONGEST + 2:
        _look(now, soonest * RATE, rules, state)
    state[COUNT] = now + 1
    return _publish(now, latest * RATE, False, state)


@compiled
def finish(state: Array) -> int:
    """Let the steps out that wait for samples, as there are no more; return as `take` does."""
    return _publish(int(state[COUNT]) - 1, 0.0, True, state)


def _filter(x: float, rules: Array, state: Array) -> tuple[float, float]:
    """Return the magnitude in the band of the rhythm, saturated, and in that of the peaks."""
    rhythm, value = 0.0, x
    for k in range(SECTIONS):
        at, of = FILTERS + 5 * k, MEMORIES + 2 * k
        out = rules[at] * value + state[of]
        state[of] = rules[at + 1] * value - rules[at + 3] * out + state[of + 1]
        state[of + 1] = rules[at + 2] * value - rules[at + 4] * out
        if k == 0:
            rhythm = out
        else:
            value = out
    return rhythm / sqrt(rhythm * rhythm + rules[FLOOR] * rules[FLOOR]), value


def _correlate(saturated: float, now: int, rules: Array, state: Array) -> None:
    """Let the autocorrelation of each lag follow."""
    slot = now % RING
    state[SATURATED_AT + slot] = state[SATURATED_AT + RING + slot] = saturated
    newest = SATURATED_AT + RING + slot
    part = rules[MEMORY]
    state[ENERGY] += part * (saturated * saturated - state[ENERGY])
    state[ENERGY_AT + slot] = state[ENERGY]
    past = state[newest - LONGEST - 1 : newest + 1]
    means = state[LAG_AT : LAG_AT + LONGEST + 2]  # that of the greatest lag comes first
    for i in range(LONGEST + 2):
        means[i] += part * (saturated * past[i] - means[i])


def _find_peak(smooth: float, now: int, rules: Array, state: Array) -> int:
    """Follow the extremes; return when a peak was that is over now, or −1."""
    least = rules[SHARE] * _median(state)
    if now - state[TURNED] > RATE:
        least *= exp(1.0 - (now - state[TURNED]) / RATE)
    least = max(rules[RISE], least)
    if state[SEEKS] == 0.0:
        state[BOTTOM] = min(state[BOTTOM], smooth)
        if smooth > state[BOTTOM] + least:
            state[SEEKS], state[TOP], state[TOP_AT] = 1.0, smooth, now
        return -1
    if smooth > state[TOP]:
        state[TOP], state[TOP_AT] = smooth, now
    if smooth >= state[TOP] - least:
        return -1
    prominence = state[TOP] - state[BOTTOM]
    state[TURNED] = now
    state[SEEKS], state[BOTTOM] = 0.0, smooth
    if now - state[TOP_AT] > LONGEST:
        return -1  # a rest was between: no crest, but what the last trough came back to
    state[PROMINENCE_AT + int(state[PROMINENT]) % PROMINENCES] = prominence
    state[PROMINENT] += 1.0
    return int(state[TOP_AT])


def _median(state: Array) -> float:
    """Return the median of the last prominences: of five, the one that two are below."""
    for i in range(PROMINENCES):
        value, below, equal = state[PROMINENCE_AT + i], 0, 0
        for j in range(PROMINENCES):
            other = state[PROMINENCE_AT + j]
            below += other < value
            equal += other == value
        if below <= PROMINENCES // 2 < below + equal:
            return float(value)
    return 0.0


def _take_peak(peak: int, now: int, soonest: float, rules: Array, state: Array) -> None:
    """Count a peak, keep it waiting, or hold it back until the gate opens."""
    period, walks = state[PERIOD], state[WALKS] > 0.0
    near = max(NEAR, 1.0 - state[CORRELATION]) * period if walks else 0.0  # else of another rhythm
    if peak - state[LAST] < max(soonest, near):
        return
    if walks and now - peak > 1.5 * period:  # what falls so slowly is no step
        return
    waiting = int(state[WAITING_COUNT])
    if not walks:
        _hold(peak, state)
        state[WAITING_COUNT] = 0.0
    elif _likeness(now, int(state[CYCLE]), int(2.0 * period), state) >= rules[LIKENESS]:
        if waiting <= WAITING and now - state[WAITING_AT] < 1.6 * period:
            for i in range(waiting):
                _queue(state[WAITING_AT + i], period, state)
        state[WAITING_COUNT] = 0.0
        _queue_to(state[LAST], peak, period, soonest, state)
    else:
        if waiting < WAITING:
            state[WAITING_AT + waiting] = peak
        state[WAITING_COUNT] = min(waiting + 1, WAITING + 1)
    state[LAST] = peak


def _hold(peak: int, state: Array) -> None:
    """Keep a peak, of the last ones, until the gate opens."""
    head, count = int(state[HELD]), int(state[HELD_COUNT])
    at = (head + count) % PEAKS
    state[HELD_AT + at] = peak
    state[HEIGHT_AT + at] = state[PROMINENCE_AT + int(state[PROMINENT] - 1.0) % PROMINENCES]
    if count < PEAKS:
        state[HELD_COUNT] = count + 1
    else:
        state[HELD] = (head + 1) % PEAKS


def _likeness(now: int, lag: int, span: int, state: Array) -> float:
    """Return how much the last samples are like those a cycle before, at most 1."""
    newest = SATURATED_AT + RING + now % RING
    best = -1.0
    for each in range(lag - 2, lag + 3):
        if each < 1 or each + span >= RING or each + span > now:
            continue
        product = mine = other = 0.0
        for i in range(span + 1):
            a, b = state[newest - i], state[newest - i - each]
            product += a * b
            mine += a * a
            other += b * b
        best = max(best, product / sqrt(mine * other + 1e-9))
    return best


def _look(now: int, soonest: float, rules: Array, state: Array) -> None:
    """Look for the cycle, add up what it says, and open or close the gate."""
    for lag in range(SHORTEST - 1, LONGEST + 2):  # of energies that were as strong
        ago = state[ENERGY_AT + (now - lag) % RING]
        mean = state[LAG_AT + LONGEST + 1 - lag]
        state[LIKE_AT + lag] = mean / (sqrt(state[ENERGY] * ago) + rules[FAINT])
    found = _cycle(state)
    state[CORRELATION] = 0.0
    if found > 0:
        correlation = state[LIKE_AT + found]
        state[CORRELATION], state[CYCLE], state[PERIOD] = correlation, found, found
        if found > STRIDE:
            half = _best((found + 1) // 2 - 3, (found + 1) // 2 + 3, state)
            least = HEAVY_HALF if sqrt(state[SQUARE]) > HEAVY else HALF
            if half > least * correlation:
                state[PERIOD] = 0.5 * found
    seen = int(state[SEEN])
    before, state[LOOK_AT + seen % LOOKS] = int(state[LOOK_AT + seen % LOOKS]), found
    state[SEEN] = seen + 1
    still = 0.0
    if before > 0:
        least, most = int(before * (1.0 - CHANGE)), int(before * (1.0 + CHANGE) + 1.0)
        still = max(0.0, _best(max(SHORTEST, least), min(LONGEST, most), state))
    gain = still - rules[CENTRE] + rules[GAIN] * max(0.0, still - rules[STRONG])
    evidence = state[EVIDENCE] + gain * LOOK / RATE
    state[EVIDENCE] = min(max(evidence, 0.0), 1.1 * rules[OPEN])
    if state[EVIDENCE] == 0.0:
        state[SINCE] = now
    if state[WALKS] == 0.0 and state[EVIDENCE] > rules[OPEN]:
        _credit(now, soonest, rules, state)
    elif state[WALKS] > 0.0 and state[EVIDENCE] < rules[CLOSE]:
        state[WALKS] = state[HELD_COUNT] = 0.0


def _best(least: int, most: int, state: Array) -> float:
    """Return the greatest autocorrelation of some lags."""
    best = -1.0
    for lag in range(max(least, SHORTEST - 1), most + 1):
        best = max(best, state[LIKE_AT + lag])
    return best


def _cycle(state: Array) -> int:
    """Return the shortest lag that is about as good as the best maximum, or 0."""
    best = 0.0
    for lag in range(SHORTEST, LONGEST + 1):
        if _is_maximum(lag, state):
            best = max(best, state[LIKE_AT + lag])
    for lag in range(SHORTEST, LONGEST + 1):
        if best > 0.0 and _is_maximum(lag, state) and state[LIKE_AT + lag] >= LIKE_BEST * best:
            return lag
    return 0


def _is_maximum(lag: int, state: Array) -> bool:
    at = LIKE_AT + lag
    return bool(state[at] >= state[at - 1] and state[at] >= state[at + 1])


def _credit(now: int, soonest: float, rules: Array, state: Array) -> None:
    """Open the gate and count the peaks since the evidence began, if they are enough."""
    held, period, before = int(state[HELD_COUNT]), state[PERIOD], -1.0
    oldest = max(state[SINCE] - CREDIT, now - KEPT + 4.0 * LONGEST)
    while held > 0 and state[HELD_AT + int(state[HELD])] < oldest:
        state[HELD] = (state[HELD] + 1) % PEAKS
        held -= 1
    state[HELD_COUNT] = held
    if held < FEWEST:
        return
    state[WALKS], state[HELD_COUNT] = 1.0, 0.0
    near = max(NEAR, 1.0 - state[CORRELATION]) * period
    least = rules[SHARE] * _median(state)
    for i in range(held):
        at = (int(state[HELD]) + i) % PEAKS
        peak = state[HELD_AT + at]
        if state[HEIGHT_AT + at] < least or (before >= 0.0 and peak - before < near):
            continue
        if before < 0.0:
            _queue(peak, period, state)
        else:
            _queue_to(before, peak, period, soonest, state)
        before = peak


def _queue_to(before: float, peak: float, period: float, soonest: float, state: Array) -> None:
    """Count a peak, and a step that was not seen halfway between it and the one before.

    There may have been two, but the first of them would come two steps late.
    """
    gap = peak - before
    if MISSED * period <= gap < REST * period and gap >= 2.0 * soonest:
        _queue(before + 0.5 * gap, period, state)
    _queue(peak, period, state)


def _queue(peak: float, period: float, state: Array) -> None:
    count = int(state[QUEUED])
    if count < STEPS:
        state[QUEUE_AT + 2 * count] = peak - BEHIND
        state[QUEUE_AT + 2 * count + 1] = period
        state[QUEUED] = count + 1


def _publish(now: int, latest: float, ends: bool, state: Array) -> int:
    """Write the steps out that have another one after them, or samples enough."""
    count, out = int(state[QUEUED]), 0
    for i in range(count):
        peak, period = state[QUEUE_AT + 2 * i], state[QUEUE_AT + 2 * i + 1]
        if not ends and i + 1 == count and peak + period > now:
            break
        state[FOUND_AT + 2 * out] = peak - _phase(peak, period, now, state) + LANDING
        state[FOUND_AT + 2 * out + 1] = period
        out += 1
    if out:
        for i in range(2 * (count - out)):
            state[QUEUE_AT + i] = state[QUEUE_AT + 2 * out + i]
        state[QUEUED] = count - out
    walks = state[WALKS] > 0.0 and now - state[LAST] <= latest
    return 2 * out + (1 if walks or count > out else 0)


def _phase(peak: float, period: float, now: int, state: Array) -> float:
    """Return how long after the crest of the fundamental a peak lies [samples].

    It is taken over the two steps around it, in which what differs from foot to foot drops out.
    """
    begin, end = max(0, int(peak - period + 0.5)), min(now, int(peak + period + 0.5))
    begin = max(begin, now - KEPT + 1)
    if end <= begin:
        return 0.0
    mean = 0.0
    for i in range(begin, end + 1):
        mean += state[MAGNITUDE_AT + i % KEPT]
    mean /= end - begin + 1
    even = odd = 0.0
    turn = 2.0 * pi / period
    for i in range(begin, end + 1):
        value = state[MAGNITUDE_AT + i % KEPT] - mean
        even += value * cos(turn * (i - peak))
        odd += value * sin(turn * (i - peak))
    return float(atan2(-odd, even) / turn) if even != 0.0 or odd != 0.0 else 0.0
