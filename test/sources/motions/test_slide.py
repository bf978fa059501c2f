"""A slide goes where it is told, when it is told."""

import numpy as np
import pytest

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.sources.motions.slide import Slide, SlideSettings


def slide(**settings):
    return Slide(SlideSettings(**settings))


@pytest.mark.parametrize('distance', [0.5, -0.5, 10.0, 0.0])
@pytest.mark.parametrize('axis', ['x', 'y', 'z'])
def test_it_ends_at_the_distance_along_its_axis(distance, axis):
    body = slide(distance=distance, axis=axis, start=2.0, duration=4.0)
    before, end = body.at(np.array([2.0, 6.0])).position
    expected = distance * np.eye(3)['xyz'.index(axis)]
    np.testing.assert_array_equal(before, np.zeros(3))
    np.testing.assert_allclose(end, expected, rtol=1e-15)


def test_it_lasts_as_long_as_it_is_told():
    body = slide(start=2.0, duration=4.0)
    assert body.duration == 6.0
    moving = body.at(np.array([1.99, 2.01, 4.0, 5.99, 6.01])).velocity[:, 0] != 0.0
    assert moving.tolist() == [False, True, True, True, False]


def test_middle_is_half_the_way_at_the_highest_speed():
    body = slide(distance=0.5, start=3.0, duration=1.0)
    middle = body.at(np.array([3.5]))
    assert middle.position[0, 0] == pytest.approx(0.25)
    assert middle.velocity[0, 0] == pytest.approx(30.0 / 16.0 * 0.5)
    assert middle.acceleration[0, 0] == pytest.approx(0.0, abs=1e-12)


def test_acceleration_flips_once_and_ends_as_in_an3397():
    push = slide().at(np.linspace(2.9, 4.1, 1201)).acceleration[:, 0]
    signs = np.sign(push[push != 0.0])
    assert (np.diff(signs) != 0.0).sum() == 1
    assert push.max() == pytest.approx(10.0 / np.sqrt(3.0) * 0.5, rel=1e-4)
    assert push.min() == pytest.approx(-push.max(), rel=1e-6)


@pytest.mark.parametrize('settings', [{'axis': 'w'}, {'duration': 0.0}, {'start': -1.0}])
def test_what_is_no_slide_is_refused(settings):
    (name,) = settings
    with pytest.raises(SettingsError, match=rf'driver\.slide\.{name}'):
        SlideSettings(**settings)
