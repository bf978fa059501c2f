"""Detectors of rest against their formulas, and the laws that all of them keep."""

import math

import numpy as np
import pytest

from dead_reckoning.core import stationarity
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.movement_end import MovementEnd
from dead_reckoning.core.navigation.detection import detector_of
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.stationarity import Watch, detector_class

NAMES = stationarity.names()
GRAVITY = 9.8
WATCH = Watch(3, 2, 4, 1.0, 30, 1.5, GRAVITY)
WIDTH = 6


def samples(seed=0, count=400):
    """Return steps, forces and rates of rests and movements in turn."""
    random = np.random.default_rng(seed)
    size = np.where(np.sin(np.arange(count) / 12.0) > 0.0, 1.0, 0.02)[:, None]
    force = size * random.normal(0.0, 3.0, (count, 3)) + [0.0, 0.6 * GRAVITY, 0.8 * GRAVITY]
    rate = size * random.normal(0.0, 2.0, (count, 3))
    return np.column_stack([np.full(count, 0.01), force, rate])


def judged(name, rows, watch=WATCH, chunks=(), **settings):
    """Return what a detector says of each sample, shape (n − delay, 3)."""
    kind = detector_class(name)
    detector = kind(kind.Settings(**settings), watch)
    verdicts = np.full((len(rows), 3), 7.0)
    for part in np.split(np.arange(len(rows)), chunks):
        part_verdicts = np.full((len(part), 3), 7.0)
        detector.take(rows[part], part_verdicts)
        verdicts[part] = part_verdicts
    assert np.isnan(verdicts[: detector.delay, :2]).all()
    assert not verdicts[: detector.delay, 2].any()
    return verdicts[detector.delay :]


def shoe(force, rate, weight=0.25):
    mean = force.mean(axis=0)
    excess = force - GRAVITY * mean / np.linalg.norm(mean)
    return math.sqrt((rate**2).sum(axis=1).mean() + weight**2 * (excess**2).sum(axis=1).mean())


def angular_rate(force, rate):
    return math.sqrt((rate**2).sum(axis=1).mean())


def acceleration_variance(force, rate):
    return math.sqrt(force.var(axis=0).sum())


def magnitude(force, rate):
    return math.sqrt(((np.linalg.norm(force, axis=1) - GRAVITY) ** 2).mean())


FORMULAS = {
    'shoe': shoe,
    'angular_rate': angular_rate,
    'acceleration_variance': acceleration_variance,
    'magnitude': magnitude,
}


@pytest.mark.parametrize('name', FORMULAS)
def test_statistic_is_the_formula_over_the_window(name):
    rows = samples()
    found = judged(name, rows)[:, 0]
    for k in range(len(found)):
        window = rows[max(0, k - WATCH.behind) : k + WATCH.ahead + 1]
        expected = FORMULAS[name](window[:, 1:4], window[:, 4:7])
        assert found[k] == pytest.approx(expected, rel=1e-9, abs=1e-7)


@pytest.mark.parametrize('name', FORMULAS)
def test_threshold_is_a_share_of_the_greatest_statistic_that_lasted(name):
    statistic, threshold, _ = judged(name, samples(), least=0.2, share=0.3).T
    lasted = np.zeros(len(statistic))
    for k in range(2 * WIDTH - 1, len(statistic)):
        lasted[k] = statistic[k - 2 * WIDTH + 1 : k + 1].min()
    for k in range(len(statistic)):
        swing = lasted[max(0, k - WATCH.memory) : k + 1].max()
        assert threshold[k] == pytest.approx(max(0.2, 0.3 * swing))
    assert 0.2 < np.mean(threshold > 0.2) < 0.9


def noise(random, count, force=0.02, rate=0.002):
    """Return samples of a sensor at rest, with noises of [m/s²] and [rad/s]."""
    rows = np.zeros((count, 7))
    rows[:, 0] = 0.01
    rows[:, 1:4] = random.normal(0.0, force, (count, 3))
    rows[:, 4:7] = random.normal(0.0, rate, (count, 3))
    rows[:, 3] += GRAVITY
    return rows


@pytest.mark.parametrize('name', FORMULAS)
def test_the_least_threshold_is_so_many_times_the_statistic_of_a_rest(name):
    rest = noise(np.random.default_rng(8), 60, force=1.0, rate=0.1)
    kind = detector_class(name)
    detector = kind(kind.Settings(share=0.0), WATCH)
    verdicts = np.zeros((60, 3))
    detector.take(rest, verdicts)
    assert set(verdicts[detector.delay :, 1]) == {kind.Settings().least}
    detector.learn(rest)
    detector.take(rest, verdicts)  # after the others, which it has not forgotten
    windows = [rest[k : k + WIDTH] for k in range(len(rest) - WIDTH + 1)]
    expected = [FORMULAS[name](window[:, 1:4], window[:, 4:7]) for window in windows]
    np.testing.assert_allclose(verdicts[WATCH.minimum - 1 :, 1], 1.5 * np.median(expected))
    quiet = kind(kind.Settings(share=0.0), WATCH)
    quiet.learn(noise(np.random.default_rng(8), 3, force=1e-3, rate=1e-4))  # less than a window
    quiet.take(rest, verdicts)
    assert verdicts[-1, 1] == kind.Settings().least


@pytest.mark.parametrize('times', [1.0, 3.0, 10.0, 30.0])
@pytest.mark.parametrize('name', NAMES)
def test_noise_that_was_learnt_is_rest_and_much_more_is_not(name, times):
    random = np.random.default_rng(9)
    make = detector_class(name)
    detector = make(make.Settings(), WATCH._replace(behind=10, ahead=10))
    detector.learn(noise(random, 100, 0.02 * times, 0.002 * times))
    verdicts = np.zeros((2000, 3))
    detector.take(noise(random, 2000, 0.02 * times, 0.002 * times), verdicts)
    assert verdicts[60:, 2].mean() > 0.97
    if times == 30.0:  # less is a rest in any case
        detector.take(noise(random, 2000, 2.5 * 0.02 * times, 2.5 * 0.002 * times), verdicts)
        assert verdicts[60:, 2].mean() < 0.02


def test_votes_are_learnt_by_each():
    rest = noise(np.random.default_rng(10), 60, force=1.0, rate=0.1)
    settings = NavigatorSettings(detector=('shoe', 'magnitude'), window=0.2, look_ahead=0.0)
    both = detector_of(settings, (), GRAVITY, 100.0)
    both.learn(rest)
    verdicts = np.zeros((60, 3))
    both.take(rest, verdicts)
    assert verdicts[30:, 2].mean() > 0.9


def test_a_knock_is_no_swing():
    rows = noise(np.random.default_rng(11), 200)
    rows[100:103, 1:4] += 200.0
    assert set(judged('shoe', rows)[:, 1]) == {detector_class('shoe').Settings().least}


@pytest.mark.parametrize('minimum', [1, 4, 9])
@pytest.mark.parametrize('hysteresis', [1.0, 1.5])
def test_rest_is_a_long_enough_run_below_the_threshold(minimum, hysteresis):
    watch = WATCH._replace(minimum=minimum, hysteresis=hysteresis)
    rows = samples(3)
    statistic, threshold, stationary = judged('shoe', rows, watch).T
    low = []
    for value, limit in zip(statistic, threshold, strict=True):
        low.append(value < limit * (hysteresis if low and low[-1] else 1.0))
    edges = np.flatnonzero(np.diff([0, *low, 0]))
    expected = np.zeros(len(low))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if end - begin >= minimum and end < len(low):
            expected[begin:end] = 1.0
    decided = edges[-1] if edges[-1] < len(low) else edges[-2]  # the last run goes on
    np.testing.assert_array_equal(stationary[:decided], expected[:decided])
    assert 0.2 < stationary.mean() < 0.8


@pytest.mark.parametrize('name', NAMES)
def test_one_by_one_or_many_at_once_is_the_same(name):
    rows = samples(1)
    whole = judged(name, rows)
    for chunks in (range(1, len(rows)), [1, 5, 6, 150]):
        np.testing.assert_array_equal(judged(name, rows, chunks=list(chunks)), whole)


@pytest.mark.parametrize('name', NAMES)
def test_after_a_reset_it_is_as_new(name):
    kind = detector_class(name)
    detector = kind(kind.Settings(), WATCH)
    rows = samples(2)
    first, second = np.zeros((2, len(rows), 3))
    detector.take(rows, first)
    detector.reset()
    detector.take(rows, second)
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize('name', NAMES)
def test_a_sensor_in_noise_rests(name):
    rows = noise(np.random.default_rng(4), 300)
    assert judged(name, rows)[30:, 2].all()


@pytest.mark.parametrize('name', NAMES)
def test_settings_carry_the_name(name):
    assert detector_class(name).Settings.prefix == f'navigator.{name}'


def test_movement_end_is_that_of_the_integrator():
    rows = samples(5)
    rules = IntegratorSettings(
        window_minimum=-0.4,
        window_maximum=0.4,
        movement_end_samples=6,
        movement_end_deviation=0.15,
    )
    count = MovementEnd()
    found = judged('movement_end', rows, window=0.4, samples=6)
    for row, (statistic, threshold, stationary) in zip(rows, found, strict=True):
        excess = float(np.linalg.norm(row[1:4])) - GRAVITY
        count.add((excess, 0.0, 0.0), rules)
        assert statistic == pytest.approx(abs(excess))
        assert threshold == 0.4
        assert stationary == count.ended(0, rules)
    assert 0.1 < found[:, 2].mean() < 0.9


def voted(names, votes, rows, chunks=()):
    settings = NavigatorSettings(
        detector=names, votes=votes, window=0.05, minimum=0.04, look_ahead=0.05, memory=0.3
    )
    found = detector_of(settings, (), GRAVITY, 100.0)
    verdicts = np.zeros((len(rows), 3))
    for part in np.split(np.arange(len(rows)), chunks):
        said = np.zeros((len(part), 3))
        found.take(rows[part], said)
        verdicts[part] = said
    return found, verdicts


@pytest.mark.parametrize('votes', [1, 2, 3, 0])
def test_so_many_detectors_make_a_rest(votes):
    rows, names = samples(6), ('shoe', 'movement_end', 'acceleration_variance')
    vote, verdicts = voted(names, votes, rows)
    alone = []
    for name in names:
        found, said = voted((name,), 0, rows)
        assert found.delay <= vote.delay
        alone.append(said[found.delay : len(rows) - vote.delay + found.delay])
    counted = sum(said[:, 2] for said in alone)
    np.testing.assert_array_equal(verdicts[vote.delay :, 2], counted >= (votes or 3))
    np.testing.assert_array_equal(verdicts[vote.delay :, :2], alone[0][:, :2])
    assert np.isnan(verdicts[: vote.delay, 0]).all()
    assert not verdicts[: vote.delay, 2].any()
    assert len({tuple(said[:, 2]) for said in alone}) == 3  # they are not of one mind
    for chunks in (list(range(1, len(rows))), [1, 3, 200]):
        np.testing.assert_array_equal(voted(names, votes, rows, chunks)[1], verdicts)
    vote.reset()
    said = np.zeros_like(verdicts)
    vote.take(rows, said)
    np.testing.assert_array_equal(said, verdicts)


def test_more_votes_than_detectors_are_refused():
    with pytest.raises(SettingsError, match=r'navigator\.votes: 3 of 2'):
        NavigatorSettings(detector=('shoe', 'magnitude'), votes=3)


def test_the_detector_of_the_default_looks_as_far_as_it_may():
    """Half the window and the shortest rest: 45 ms; with 0 all of it is behind."""
    for rate, delay in ((1000.0, 45 - 1), (200.0, 5 + 4 - 1), (100.0, 2 + 2 - 1)):
        assert detector_of(NavigatorSettings(), (), GRAVITY, rate).delay <= delay
        none = NavigatorSettings(look_ahead=0.0)
        assert detector_of(none, (), GRAVITY, rate).delay == 0
