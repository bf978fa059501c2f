"""Rest must show in the force and, where a gyro matters, in the rate."""

import numpy as np
import pytest

from dead_reckoning.core.errors import NotAtRestError
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest_search import RestSearch
from dead_reckoning.core.samples import ImuSample

STEP_NS = 10_000_000


def search(with_rate=True, **settings):
    return RestSearch(GravitySettings(**settings), with_rate)


def fill(looking, forces, rates):
    for step, (force, rate) in enumerate(zip(forces, rates, strict=True)):
        still = looking.add(
            ImuSample((step + 1) * STEP_NS, 'imu_link', tuple(force), angular_velocity=tuple(rate))
        )
        if still is not None:
            return still, step + 1
    return None, len(forces)


def signals(count=51, force_noise=0.01, rate_noise=0.001):
    random = np.random.default_rng(1)
    force = random.normal((0.1, 0.2, 9.8), force_noise, (count, 3))
    rate = random.normal((0.01, -0.02, 0.03), rate_noise, (count, 3))
    return force, rate


def test_rest_shows_the_mean_of_force_and_rate():
    force, rate = signals()
    still, taken = fill(search(), force, rate)
    assert taken == 51
    assert still.force.mean == pytest.approx(force.mean(axis=0))
    assert still.rate.mean == pytest.approx(rate.mean(axis=0))
    assert still.rate.deviation == pytest.approx(rate.std(axis=0))


def test_without_a_gyro_only_the_force_counts():
    force, rate = signals(rate_noise=1.0)
    still, _ = fill(search(with_rate=False), force, rate)
    assert still.rate is None


@pytest.mark.parametrize(
    ('noises', 'unit'), [({'rate_noise': 0.1}, 'rad/s'), ({'force_noise': 1.0}, 'm/s²')]
)
def test_motion_in_either_is_no_rest_and_the_search_begins_anew(noises, unit):
    looking = search()
    with pytest.raises(NotAtRestError, match=unit):
        fill(looking, *signals(**noises))
    still, taken = fill(looking, *signals())
    assert taken == 51
    assert still.rate.count == still.force.count == 51
