"""Stamps by the clock of a board: even where arrivals are not, and never by a clock that was."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.sources.serial.board_clock import CORNERS, SEGMENTS, BoardClock

START_NS = 1_700_000_000 * NANOSECONDS
RATE = 100.0


def delays(count, seed=1):
    """Return delays [s]: none now and then, up to 16 ms else."""
    random = np.random.default_rng(seed)
    return random.uniform(0.0, 0.016, count) * (random.random(count) > 0.05)


def stamped(clock, numbers, times, delay=0.0, unit=1.0):
    """Return the stamps [s from the start] of readings by their numbers and true times [s]."""
    arrivals = np.broadcast_to(times + delay, len(numbers))
    found = [
        clock.stamp(unit * number, START_NS + round(arrival * NANOSECONDS))
        for number, arrival in zip(numbers, arrivals, strict=True)
    ]
    return (np.array(found) - START_NS) / NANOSECONDS


def test_readings_without_jitter_are_stamped_when_they_arrive():
    numbers = np.arange(3000)
    times = numbers / RATE * 1.00005
    assert stamped(BoardClock(), numbers, times) == pytest.approx(times, abs=1e-8)


@pytest.mark.parametrize('unit', [1.0, 0.01, 10_000.0])
def test_jitter_is_taken_off_whatever_unit_the_clock_has(unit):
    numbers = np.arange(6000)
    times = numbers / RATE * 1.00005
    clock = BoardClock()
    error = stamped(clock, numbers, times, delays(6000), unit) - times
    assert np.abs(error[1000:]).max() < 0.0002
    assert clock.rate == pytest.approx(1.00005 / RATE * NANOSECONDS / unit, rel=1e-5)
    assert clock.restarts == 0


def test_lost_readings_do_not_matter():
    kept = np.flatnonzero(np.random.default_rng(2).random(6000) > 0.3)
    times = kept / RATE
    error = stamped(BoardClock(), kept, times, delays(len(kept))) - times
    assert np.abs(error[1000:]).max() < 0.0002


def test_a_crystal_that_warms_up_is_followed():
    """By 2 ppm a minute, over half an hour."""
    numbers = np.arange(round(1800 * RATE))
    seconds = numbers / RATE
    times = seconds + 0.5 * 2e-6 / 60.0 * seconds**2
    error = stamped(BoardClock(), numbers, times, delays(len(numbers))) - times
    assert np.abs(error[10_000:]).max() < 0.002


@given(st.lists(st.tuples(st.integers(1, 3), st.floats(0.0, 0.2)), min_size=1, max_size=200))
def test_two_stamps_keep_half_of_their_distance(steps):
    """But for the very first and those that do not fit, which are arrivals."""
    clock = BoardClock()
    number, found = 0, []
    for step, delay in steps:
        number += step
        stamp = clock.stamp(number, START_NS + round((number / RATE + delay) * NANOSECONDS))
        known = clock.rate is not None and not clock.doubted
        found.append((clock.restarts, known, clock.rate, number, stamp))
    for before, (later, known, _, after, other) in pairwise(found):
        restarts, known_before, rate, number, stamp = before
        if known_before and known and restarts == later:
            assert other - stamp >= 0.45 * rate * (after - number) - 1.0


@pytest.mark.parametrize(
    ('numbers', 'lag'),
    [
        (np.arange(1000), 0.0),  # the counter was reset
        (np.arange(7000, 8000), 0.0),  # it leapt on
        (np.arange(5000, 6000), -10.0),  # the clock of the host was set back
        (np.arange(5000, 6000), 10.0),  # or on, or nothing came for a while
    ],
)
def test_it_starts_anew_where_the_clock_of_the_board_or_of_the_host_leaps(numbers, lag):
    clock = BoardClock()
    times = np.arange(6000) / RATE
    stamped(clock, np.arange(5000), times[:5000], delays(5000))
    later = times[5000:] + lag
    error = stamped(clock, numbers, later, delays(1000, seed=3)) - later
    assert clock.restarts == 1
    assert np.abs(error).max() < 0.017
    assert np.abs(error[500:]).max() < 0.001


@pytest.mark.parametrize('bit', range(12))
def test_a_number_that_is_disturbed_on_the_wire_costs_its_own_stamp_only(bit):
    """Now and then one of its bits is turned, so that it is ahead or behind."""
    numbers = np.arange(6000)
    times = numbers / RATE
    disturbed = numbers ^ np.where(numbers % 97 == 50, 1 << bit, 0)
    clock = BoardClock()
    error = stamped(clock, disturbed, times, delays(6000)) - times
    assert clock.restarts == 0
    assert np.abs(error[1000:][numbers[1000:] % 97 != 50]).max() < 0.0002
    assert np.abs(error).max() < 0.021  # when it arrived, or that of a number just before


def test_a_board_that_rested_uncounted_is_noticed_within_seconds():
    clock = BoardClock()
    times = np.arange(6000) / RATE
    times[5000:] += 0.2
    error = stamped(clock, np.arange(6000), times, delays(6000)) - times
    assert clock.restarts == 1
    assert np.abs(error[5300:]).max() < 0.017


def test_a_reading_that_comes_twice_changes_nothing():
    """Its second stamp is no later than the second arrival was, a millisecond after the first."""
    clock = BoardClock()
    numbers = np.repeat(np.arange(2000), 2)
    found = stamped(clock, numbers, numbers / RATE, np.tile([0.0, 0.001], 2000))
    assert clock.restarts == 0
    assert found[1000::2] == pytest.approx(np.arange(500, 2000) / RATE, abs=1e-6)
    assert found[1001::2] == pytest.approx(np.arange(500, 2000) / RATE, abs=0.001 + 1e-6)


def test_memory_is_bounded_where_every_point_is_a_corner():
    clock = BoardClock()
    numbers = np.arange(100_000)
    seconds = numbers / RATE
    stamped(clock, numbers, seconds + 1e-6 * seconds**2)
    assert clock.restarts == 0
    assert sum(map(len, clock._segments)) <= CORNERS * SEGMENTS
