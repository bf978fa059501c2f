"""Paths go exactly through their knots, smoothly, and stay where they end."""

import numpy as np
import pytest

from dead_reckoning.sources.paths import Path, crossing_times, ramp

RANDOM = np.random.default_rng(4)
TIMES = np.array([0.5, 1.0, 1.7, 4.0, 4.3])
VALUES, RATES, ACCELERATIONS = RANDOM.normal(0.0, 3.0, (3, 5, 2))
INNER = np.array([[0.0], [1.0], [1.0], [1.0], [0.0]])
RATES, ACCELERATIONS = RATES * INNER, ACCELERATIONS * INNER


@pytest.fixture
def path():
    return Path(TIMES, VALUES, RATES, ACCELERATIONS)


def test_knots_are_met_exactly(path):
    value, rate, acceleration = path.at(TIMES)
    np.testing.assert_array_equal(value, VALUES)
    np.testing.assert_allclose(rate, RATES, rtol=1e-14)
    np.testing.assert_allclose(acceleration, ACCELERATIONS, rtol=1e-14)


def test_knots_are_met_exactly_far_from_the_origin():
    path = Path(TIMES, VALUES + 1e6, RATES)
    np.testing.assert_array_equal(path.at(TIMES)[0], VALUES + 1e6)
    before = path.at(TIMES[1:] - 1e-12)[0]
    np.testing.assert_allclose(before, VALUES[1:] + 1e6, rtol=1e-15)


@pytest.mark.parametrize('part', [0, 1, 2])
def test_value_rate_and_acceleration_are_continuous(path, part):
    before, after = path.at(TIMES - 1e-9)[part], path.at(TIMES + 1e-9)[part]
    np.testing.assert_allclose(before, after, atol=1e-5)


def test_rate_and_acceleration_are_derivatives(path):
    time = np.linspace(0.0, 5.0, 2001)
    step = 1e-6
    before, after = path.at(time - step), path.at(time + step)
    inside = (np.abs(time[:, None] - TIMES) > 2.0 * step).all(axis=1)
    for part, atol in ((1, 1e-5), (2, 1e-4)):
        slope = (after[part - 1] - before[part - 1]) / (2.0 * step)
        np.testing.assert_allclose(path.at(time)[part][inside], slope[inside], atol=atol)


def test_it_stays_where_it_is_before_and_after(path):
    value, rate, acceleration = path.at(np.array([-1e9, 0.499, 4.3, 4.31, 1e9]))
    np.testing.assert_allclose(value, VALUES[[0, 0, -1, -1, -1]], rtol=1e-15)
    assert not rate.any()
    assert not acceleration.any()


def test_between_two_rests_it_is_the_way_of_least_jerk():
    tau = np.linspace(0.0, 1.0, 11)
    value = Path([2.0, 6.0], [[1.0], [3.0]]).at(2.0 + 4.0 * tau)[0][:, 0]
    np.testing.assert_allclose(value, 1.0 + 2.0 * (10 * tau**3 - 15 * tau**4 + 6 * tau**5))


def test_least_jerk_through_knots_is_smooth_to_the_fourth_derivative():
    path = Path.of_least_jerk(TIMES, VALUES)
    np.testing.assert_array_equal(path.at(TIMES)[0], VALUES)
    step = 1e-3
    for knot in TIMES[1:-1]:
        thirds, fourths = [], []
        for side in (-1.0, 1.0):
            a, b, c = (path.at(np.array([knot + side * k * step]))[2][0] for k in (1, 2, 3))
            thirds.append(side * (-1.5 * a + 2.0 * b - 0.5 * c) / step)
            fourths.append((a - 2.0 * b + c) / step**2)
        np.testing.assert_allclose(thirds[0], thirds[1], rtol=0.1, atol=2.0)
        np.testing.assert_allclose(fourths[0], fourths[1], rtol=0.1, atol=20.0)


def test_no_other_way_through_the_knots_has_less_jerk():
    def jerk(path):
        time = np.linspace(TIMES[0], TIMES[-1], 200_001)
        return np.sum(np.diff(path.at(time)[2], axis=0) ** 2)

    best = Path.of_least_jerk(TIMES, VALUES)
    _, rates, accelerations = best.at(TIMES)
    for knot in range(1, 4):
        for change in (0.1, -0.1):
            faster, harder = rates.copy(), accelerations.copy()
            faster[knot, 0] += change
            harder[knot, 0] += change
            assert jerk(Path(TIMES, VALUES, faster, accelerations)) > jerk(best)
            assert jerk(Path(TIMES, VALUES, rates, harder)) > jerk(best)


def test_least_jerk_between_two_knots_needs_no_more():
    straight = Path.of_least_jerk([0.0, 2.0], [[0.0], [1.0]])
    time = np.linspace(0.0, 2.0, 20)
    np.testing.assert_array_equal(
        straight.at(time)[0], Path([0.0, 2.0], [[0.0], [1.0]]).at(time)[0]
    )


def test_a_polynomial_of_fifth_degree_is_reproduced():
    polynomial = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0, -1.0, 0.25])
    times = np.array([0.0, 0.4, 1.5, 2.0])
    knots = [
        polynomial.deriv(n)(times)[:, None] if n else polynomial(times)[:, None] for n in (0, 1, 2)
    ]
    path = Path(times, *knots)
    time = np.linspace(0.0, 1.999, 50)
    np.testing.assert_allclose(path.at(time)[0][:, 0], polynomial(time), atol=1e-12)
    np.testing.assert_allclose(path.at(time)[2][:, 0], polynomial.deriv(2)(time), atol=1e-10)


def test_no_time_gives_nothing(path):
    assert [part.shape for part in path.at(np.empty(0))] == [(0, 2)] * 3


# Ramps ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(('start', 'end'), [(0.0, 10.0), (3.0, -7.0), (0.0, 0.05), (1.0, 1.0)])
@pytest.mark.parametrize('begin', [0.0, 3.0])
def test_ramp_goes_from_start_to_end_and_never_faster(start, end, begin):
    path = ramp(start, end, speed=2.0, ramp_time=0.5, begin=begin)
    time = np.linspace(-1.0, path.times[-1] + 1.0, 5001)
    value, rate, _ = (part[:, 0] for part in path.at(time))
    assert value[0] == start
    assert value[-1] == end
    assert np.abs(rate).max() <= 2.0 + 1e-12
    assert (rate * np.sign(end - start) >= -1e-12).all(), 'it never turns back'
    assert not rate[time < begin].any()
    if abs(end - start) > 1.0:
        assert np.abs(rate).max() == pytest.approx(2.0)
        assert path.times[-1] - begin == pytest.approx(abs(end - start) / 2.0 + 0.5)
    else:
        assert np.abs(rate).max() == pytest.approx(abs(end - start) / 0.5)
        assert path.times[-1] - begin == pytest.approx(1.0)


def test_crossing_times_are_when_the_level_is_passed():
    path = ramp(0.0, 20.0, speed=1.8, ramp_time=0.8, begin=3.0)
    levels = np.arange(20) + 0.5
    times = crossing_times(path, levels.tolist())
    assert (np.diff(times) > 0.0).all()
    np.testing.assert_allclose(path.at(times)[0][:, 0], levels, atol=1e-8)
