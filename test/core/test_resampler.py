"""One rate from any other, causally."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.resampler import Resampler

START_NS = 1_700_000_000_000_000_000
RATE = 30


def taken(resampler, stamps_ns, vectors):
    """Return stamps, shape (n,) [ns], and magnitudes, shape (n,)."""
    made = [
        sample
        for stamp, vector in zip(stamps_ns, np.asarray(vectors).tolist(), strict=True)
        for sample in resampler.add(int(stamp), tuple(vector))
    ]
    return np.array([stamp for stamp, _ in made]), np.array([each for _, each in made])


def run(stamps_ns, vectors):
    """Return stamps, shape (n,) [ns], and the magnitude of each axis, shape (n, 3)."""
    columns = [taken(Resampler(RATE, use), stamps_ns, vectors) for use in np.eye(3)]
    return columns[0][0], np.column_stack([magnitudes for _, magnitudes in columns])


def bounds(count):
    """Return the bounds of so many cells, relative to the start [ns]."""
    return np.round(np.arange(count + 1) * 1e9 / RATE)


def integral(times, values, at):
    """Integrate straight lines between values, shape (n, 3), up to each time of ``at``."""
    steps = np.diff(times)[:, None]
    area = np.vstack([np.zeros(3), np.cumsum(0.5 * steps * (values[1:] + values[:-1]), axis=0)])
    piece = np.clip(np.searchsorted(times, at, 'right') - 1, 0, len(times) - 2)
    since = (at - times[piece])[:, None]
    slope = (values[piece + 1] - values[piece]) / steps[piece]
    return area[piece] + values[piece] * since + 0.5 * slope * since**2


@st.composite
def streams(draw):
    """Draw irregular stamps from the start on [ns], and vectors."""
    steps = draw(st.lists(st.integers(500_000, 200_000_000), min_size=2, max_size=80))
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    return np.cumsum([0, *steps]), random.normal(0.0, 10.0, (len(steps) + 1, 3))


@given(streams())
def test_each_sample_is_the_mean_of_the_lines_over_its_cell(stream):
    times, vectors = stream
    stamps, means = run(START_NS + times, vectors)
    edges = bounds(len(stamps))
    expected = np.diff(integral(times.astype(float), vectors, edges), axis=0)
    expected = np.abs(expected / np.diff(edges)[:, None])
    np.testing.assert_allclose(means, expected, rtol=0, atol=1e-6)
    assert len(stamps) == np.searchsorted(bounds(2000), times[-1], 'right') - 1


@given(streams(), st.integers(1, 3))
def test_more_samples_on_the_same_lines_change_nothing(stream, between):
    times, vectors = stream
    finer = np.unique(np.concatenate([times[:-1] + np.diff(times) * k // 4 for k in range(4)]))
    finer = np.append(finer, times[-1])
    lines = np.column_stack([np.interp(finer, times, channel) for channel in vectors.T])
    stamps, means = run(START_NS + times, vectors)
    again, finer_means = run(START_NS + finer, lines)
    np.testing.assert_array_equal(stamps, again)
    np.testing.assert_allclose(means, finer_means, rtol=0, atol=1e-6)


@given(
    st.floats(60.0, 1000.0),
    st.floats(0.0, 0.4),
    st.floats(0.5, 3.5),
    st.integers(0, 2**32),
)
def test_any_rate_and_jitter_gives_the_same_walk(rate, jitter, frequency, seed):
    """A sine of a walk's frequency comes out as its mean over each cell, within 2 %."""
    random = np.random.default_rng(seed)
    count = int(4.0 * rate)
    ticks = np.arange(count) + random.uniform(-jitter, jitter, count)
    times = np.round((ticks - ticks[0]) * 1e9 / rate).astype(int)
    turn = 2.0 * math.pi * frequency
    values = np.sin(turn * times * 1e-9)
    stamps, means = run(START_NS + times, np.column_stack([values] * 3))
    edges = bounds(len(stamps)) * 1e-9
    exact = np.diff(-np.cos(turn * edges)) / turn / np.diff(edges)
    np.testing.assert_allclose(means, np.abs(np.column_stack([exact] * 3)), rtol=0, atol=0.02)


@pytest.mark.parametrize('rate', [5.0, 12.5, 25.0])
def test_lower_rate_is_interpolated(rate):
    times = np.round(np.arange(40) * 1e9 / rate).astype(int)
    line = np.outer(times * 1e-9, [1.0, -2.0, 0.5])
    stamps, means = run(START_NS + times, line)
    middles = (stamps - START_NS) * 1e-9
    np.testing.assert_allclose(means, np.outer(middles, [1.0, 2.0, 0.5]), atol=1e-6)


def test_constant_stays_what_it_is():
    times = np.cumsum(np.random.default_rng(3).integers(1_000_000, 90_000_000, 400))
    _, means = run(START_NS + times, np.tile([0.1, -9.80665, 3.3], (400, 1)))
    np.testing.assert_allclose(means, np.tile([0.1, 9.80665, 3.3], (len(means), 1)), rtol=1e-12)


def test_what_is_faster_than_the_output_does_not_fold_down():
    """50 Hz at 400 Hz in would show as 10 Hz if only every so-many-th sample were taken."""
    times = np.arange(4000) * 2_500_000
    values = np.sin(2.0 * math.pi * 50.0 * times * 1e-9 + 0.3)
    _, means = run(START_NS + times, np.column_stack([values] * 3))
    assert np.abs(means).max() < 0.25


def test_stamps_stand_at_the_middle_of_the_cells_and_do_not_drift():
    times = np.arange(30_001) * 10_000_000
    stamps, _ = run(START_NS + times, np.zeros((30_001, 3)))
    exact = (np.arange(len(stamps)) + 0.5) * 1e9 / RATE
    assert np.abs(stamps - START_NS - exact).max() <= 1.0
    assert len(stamps) == 9000


def test_a_sample_comes_with_the_first_one_at_or_after_its_end():
    resampler = Resampler(10)
    assert resampler.add(START_NS, (0.0, 0.0, 0.0)) == []
    assert resampler.add(START_NS + 99_999_999, (1.0, 0.0, 0.0)) == []
    assert len(resampler.add(START_NS + 100_000_000, (1.0, 0.0, 0.0))) == 1
    assert len(resampler.add(START_NS + 450_000_000, (1.0, 0.0, 0.0))) == 3


def test_later_start_shifts_the_stamps_and_nothing_else():
    times = np.cumsum(np.random.default_rng(4).integers(1_000_000, 30_000_000, 300))
    vectors = np.random.default_rng(5).normal(0.0, 5.0, (300, 3))
    stamps, means = run(START_NS + times, vectors)
    later, same = run(START_NS + 123_456_789_012 + times, vectors)
    np.testing.assert_array_equal(later - stamps, 123_456_789_012)
    np.testing.assert_array_equal(means, same)


@given(streams())
def test_magnitude_is_that_of_the_mean_along_the_axes_that_count(stream):
    times, vectors = stream
    _, means = run(START_NS + times, vectors)
    for use in ((1.0, 1.0, 1.0), (1.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        _, magnitudes = taken(Resampler(RATE, use), START_NS + times, vectors)
        np.testing.assert_allclose(magnitudes, np.linalg.norm(means * use, axis=1), rtol=1e-12)


@given(streams())
def test_compiled_code_does_what_the_function_does(stream):
    times, vectors = stream
    ways = [Resampler(RATE), Resampler(RATE, compiled=True)]
    (stamps, expected), (again, magnitudes) = (
        taken(way, START_NS + times, vectors) for way in ways
    )
    np.testing.assert_array_equal(stamps, again)
    np.testing.assert_allclose(expected, magnitudes, rtol=1e-12)
    assert list(ways[0].grid) == list(ways[1].grid)
    np.testing.assert_allclose(ways[0].lines, ways[1].lines, rtol=1e-12)


@pytest.mark.parametrize('compiled', [False, True])
def test_reset_begins_the_first_cell_anew(compiled):
    resampler = Resampler(RATE, compiled=compiled)
    times = np.arange(50) * 7_000_000
    vectors = np.random.default_rng(6).normal(0.0, 5.0, (50, 3))
    first = taken(resampler, START_NS + times, vectors)
    resampler.reset()
    second = taken(resampler, START_NS + 5 + times, vectors)
    np.testing.assert_array_equal(second[0] - first[0], 5)
    np.testing.assert_array_equal(second[1], first[1])
