"""A hand trembles and sways as it is told, and its truth is exact."""

import numpy as np
import pytest

from dead_reckoning.sources.hand import FADE, HandSettings, Held
from dead_reckoning.sources.motions.rest import Rest, RestSettings
from dead_reckoning.sources.motions.slide import Slide, SlideSettings

RATE = 1000.0
TIME = np.arange(0.0, 60.0, 1.0 / RATE)


def held(motion=None, seed=1, **settings):
    return Held(motion or Rest(RestSettings()), HandSettings(**settings), seed)


@pytest.mark.parametrize('motion', [Rest(RestSettings()), Slide(SlideSettings())])
def test_each_is_the_derivative_of_the_one_before(motion):
    truth = held(motion, tremor=1.0, sway=0.01, release=20.0).at(TIME)
    for lower, upper, largest in (
        (truth.position, truth.velocity, 1e-4),
        (truth.velocity, truth.acceleration, 2e-2),
    ):
        slope = (lower[2:] - lower[:-2]) * (0.5 * RATE)
        assert np.abs(slope - upper[1:-1]).max() < largest


def test_it_is_as_large_as_told_between_its_frequencies():
    random = [held(seed=seed, tremor=0.1, sway=0.0).at(TIME[2000:]) for seed in range(20)]
    pushes = np.array([truth.acceleration for truth in random])
    assert pushes.std() == pytest.approx(0.1, rel=0.05)
    power = (np.abs(np.fft.rfft(pushes, axis=1)) ** 2).sum(axis=(0, 2))
    frequency = np.fft.rfftfreq(pushes.shape[1], 1.0 / RATE)
    inside = (frequency > 5.8) & (frequency < 12.2)
    assert power[inside].sum() > 0.99 * power.sum()
    swaying = [held(seed=seed, tremor=0.0, sway=0.002).at(TIME[2000:]) for seed in range(20)]
    assert np.array([truth.position for truth in swaying]).std() == pytest.approx(0.002, rel=0.2)


def test_it_begins_at_the_origin_at_rest_and_lets_go():
    truth = held(release=5.0).at(TIME)
    for values in (truth.position, truth.velocity, truth.acceleration):
        assert np.abs(values[0]).max() == 0.0
        assert np.abs(values[TIME > 5.0 + FADE]).max() == 0.0
        assert np.abs(values[(TIME > 1.0) & (TIME < 5.0)]).max() > 0.0


def test_seeds_differ_and_repeat():
    first, again, other = (held(seed=seed).at(TIME[:2000]).position for seed in (1, 1, 2))
    assert (first == again).all()
    assert np.abs(first - other).max() > 1e-4
