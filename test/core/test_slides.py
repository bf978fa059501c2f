"""A phone slid by a trembling hand over a tilted table, no gyro, all settings default."""

import numpy as np
import pytest

from benchmarks.slides import slide

SEEDS = range(100)


@pytest.fixture(scope='module')
def slides():
    """Slide 100 times; in half of them the hand stays on the phone, in half it lets go."""
    return [slide(seed, lets_go=seed % 2 == 0) for seed in SEEDS]


def test_displacement_is_within_ten_percent_in_the_median(slides):
    shares = [result.share for result in slides]
    assert np.median(shares[::2]) <= 0.10
    assert np.median(shares[1::2]) <= 0.10


def test_rest_is_found_under_a_hand_too(slides):
    assert np.mean([result.stationary for result in slides]) >= 0.95


def test_error_is_within_three_deviations(slides):
    assert np.mean([result.covered for result in slides]) >= 0.95


def test_covariance_says_so_where_no_rest_is_found():
    results = [slide(seed, **{'integrator.movement_end': 'off'}) for seed in SEEDS[:20]]
    assert not any(result.stationary for result in results)
    assert np.mean([result.covered for result in results]) >= 0.95


@pytest.mark.parametrize(('method', 'seeds'), [('trapezoid', SEEDS), ('kalman', SEEDS[:20])])
def test_covariance_says_so_where_strong_tremor_is_no_rest(method, seeds):
    """All is integrated freely then, with what the tremor has left in the levelling."""
    results = [
        slide(seed, **{'integrator.method': method, 'driver.hand.tremor': 0.25}) for seed in seeds
    ]
    assert not any(result.stationary for result in results)
    assert np.mean([result.covered for result in results]) >= 0.95
    heights = [result.error[2] / result.deviation[2] for result in results]
    assert 0.6 <= np.sqrt(np.mean(np.square(heights))) <= 1.2, 'and no more than that'


def test_wide_range_is_no_excuse():
    """At ±6 g a third of the noise is as wide as the window: a sample alone shows no rest."""
    results = [
        slide(seed, **{'driver.hand.enabled': False, 'driver.range_g': 6.0}) for seed in range(20)
    ]
    assert all(result.stationary for result in results)
    assert np.median([result.share for result in results]) <= 0.05
