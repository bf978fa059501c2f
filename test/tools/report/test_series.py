"""Long series thinned to what a picture shows."""

import numpy as np
import pytest

from dead_reckoning.tools.report import series

START_NS = 1_700_000_000_000_000_000


def walk(count, width=3):
    values = np.cumsum(np.random.default_rng(1).normal(0.0, 1.0, (count, width)), axis=0)
    return 0.005 * np.arange(count), values, np.zeros(count, bool)


def test_short_series_stay_as_they_are():
    time, values, broken = walk(500)
    for found in series.envelope(time, values, broken)[1:]:
        np.testing.assert_array_equal(found, values)


def test_long_series_keep_their_extremes_and_little_else():
    time, values, broken = walk(200_000)
    values[123_456] += 1000.0
    thinned, low, high = series.envelope(time, values, broken)
    assert len(thinned) <= series.COLUMNS + 1
    np.testing.assert_array_equal(high.max(axis=0), values.max(axis=0))
    np.testing.assert_array_equal(low.min(axis=0), values.min(axis=0))
    peak = thinned[high[:, 0].argmax()]
    assert peak == pytest.approx(time[123_456], abs=time[-1] / series.COLUMNS)


@pytest.mark.parametrize('count', [100, 100_000])
def test_lines_are_broken_at_gaps_and_where_stamps_go_back(count):
    stamp_ns = START_NS + 10_000_000 * np.arange(count)
    stamp_ns[count // 2 :] += 5_000_000_000
    stamp_ns[count * 3 // 4 :] -= 20_000_000_000
    broken = series.breaks(stamp_ns)
    assert np.flatnonzero(broken).tolist() == [count // 2, count * 3 // 4]
    time = series.elapsed(stamp_ns, START_NS)
    assert (np.diff(time) >= 0.0).all()
    thinned, low, high = series.envelope(time, np.ones((count, 1)), broken)
    assert np.isnan(thinned).sum() == np.isnan(low).sum() == np.isnan(high).sum() == 2


def test_slow_samples_are_no_gaps():
    assert not series.breaks(START_NS + 2_000_000_000 * np.arange(50)).any()


def test_way_is_as_exact_as_the_picture():
    angle = np.linspace(0.0, 40.0, 300_000)
    position = 5.0 * np.column_stack([np.cos(angle), np.sin(1.3 * angle)])
    shown = series.way(position, np.zeros(len(position), bool))
    assert len(shown) < len(position) / 3
    np.testing.assert_array_equal(shown[[0, -1]], position[[0, -1]])
    jumps = np.linalg.norm(np.diff(shown, axis=0), axis=1)
    assert jumps.max() < 3.0 * 10.0 / series.PIXELS


def test_intervals_are_those_of_the_flags_and_end_at_gaps():
    time = 0.1 * np.arange(100)
    time[70:] += 10.0
    flags, broken = np.zeros(100, bool), np.arange(100) == 70
    flags[10:20] = flags[50:] = True
    np.testing.assert_allclose(
        series.intervals(time, flags, broken), [(1.0, 0.9), (5.0, 1.9), (17.0, 2.9)]
    )
    assert series.intervals(time, np.zeros(100, bool), broken).shape == (0, 2)


def test_flickering_is_one_interval_to_the_eye():
    time = 0.001 * np.arange(1_000_000)
    flags = np.arange(1_000_000) % 2 == 0
    assert len(series.intervals(time, flags, np.zeros(len(time), bool))) == 1
