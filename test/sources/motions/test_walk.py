"""A walk has the steps it was asked for, and shakes as walks do."""

import numpy as np
import pytest

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.sources.motions.walk import Walk, WalkSettings

RATE = 200.0


def walk(**settings):
    return Walk(WalkSettings(**settings))


def force(body, begin, end):
    """Return the specific force, shape (n, 3), frame of the body."""
    truth = body.at(np.arange(begin, end, 1.0 / RATE))
    lifted = truth.acceleration + np.array([0.0, 0.0, GRAVITY])
    return np.einsum('nji,nj->ni', truth.rotation, lifted)


def steady(**settings):
    """Return the norm of the force while the cadence is steady, whole steps of it."""
    body = walk(steps=60, **settings)
    first, last = body.steps.times[[10, 50]]
    return np.linalg.norm(force(body, first, last), axis=1)


@pytest.mark.parametrize('heading', [0.0, 2.0, -1.0])
@pytest.mark.parametrize('steps', [1, 2, 7, 60])
def test_it_ends_after_its_steps_in_its_direction(steps, heading):
    body = walk(steps=steps, step_length=0.7, heading=heading)
    end = body.at(np.array([body.duration]))
    expected = 0.7 * steps * np.array([np.cos(heading), np.sin(heading), 0.0])
    np.testing.assert_allclose(end.position[0], expected, atol=1e-12)
    np.testing.assert_allclose(end.euler[0], [0.0, 0.0, heading], atol=1e-12)


@pytest.mark.parametrize('cadence', [0.8, 1.8, 3.3])
def test_steps_are_as_many_and_as_long_as_told_at_their_cadence(cadence):
    body = walk(steps=60, step_length=0.6, cadence=cadence)
    steps = body.steps
    assert len(steps.times) == 60
    assert steps.lengths.sum() == pytest.approx(body.at(np.array([1e6])).position[0, 0])
    assert (np.diff(steps.times) > 0.0).all()
    np.testing.assert_allclose(np.diff(steps.times)[3:-3], 1.0 / cadence)


@pytest.mark.parametrize('cadence', [1.4, 2.0, 2.8])
def test_trunk_is_lowest_and_pushed_hardest_about_when_the_foot_lands(cadence):
    body = walk(cadence=cadence, asymmetry=0.0, step_length=0.6)
    for landed in body.steps.times[10:20]:
        time = landed + np.linspace(-0.5, 0.5, 401) / cadence
        truth = body.at(time)
        at_lowest, at_hardest = (
            (time[index] - landed) * cadence
            for index in (np.argmin(truth.position[:, 2]), np.argmax(truth.acceleration[:, 2]))
        )
        assert abs(at_lowest) < 0.1
        assert abs(at_hardest) < 0.1


def test_trunk_slows_down_after_the_foot_has_landed():
    body = walk()
    after = body.at(body.steps.times[10:50] + 0.2 / 1.8)
    before = body.at(body.steps.times[10:50] - 0.2 / 1.8)
    assert (after.acceleration[:, 0] < -1.0).all()
    assert (before.acceleration[:, 0] > 1.0).all()


def test_bounce_is_that_of_a_leg_that_swings_over():
    body = walk(asymmetry=0.0)
    height = body.at(np.linspace(*body.steps.times[[10, 50]], 5001)).position[:, 2]
    assert np.ptp(height) == pytest.approx(0.6 * (0.9 - np.sqrt(0.9**2 - 0.35**2)), rel=0.05)


@pytest.mark.parametrize('step_length', [0.5, 0.8, 1.2, 1.6])
@pytest.mark.parametrize('cadence', [0.8, 1.8, 2.5, 3.3, 4.0])
def test_nothing_but_gravity_pulls_the_trunk_down(cadence, step_length):
    body = walk(steps=40, cadence=cadence, step_length=step_length)
    acceleration = body.at(np.arange(0.0, body.duration, 1.0 / RATE)).acceleration[:, 2]
    assert acceleration.min() > -GRAVITY


@pytest.mark.parametrize(
    ('cadence', 'step_length', 'deviation', 'peak'),
    [
        (0.8, 0.45, (0.1, 0.4), (0.2, 1.0)),
        (1.4, 0.6, (0.6, 1.5), (1.5, 3.5)),
        (1.7, 0.6, (1.0, 2.0), (2.5, 5.0)),  # mobgap's belt: 1.1 … 1.2, 4
        (1.9, 0.72, (1.8, 4.2), (4.0, 8.5)),  # the phones of Oxford: 1.9 … 4.1, 4.1 … 8.2
        (3.3, 1.2, (5.0, 9.0), (12.0, 22.0)),  # running: 2 to 3 times the weight
    ],
)
def test_shaking_is_as_large_as_that_of_people(cadence, step_length, deviation, peak):
    """Standard deviation and 99th percentile of the norm, against its mean."""
    norm = steady(cadence=cadence, step_length=step_length)
    assert deviation[0] < norm.std() < deviation[1]
    assert peak[0] < np.percentile(norm, 99) - norm.mean() < peak[1]


def test_spectrum_has_the_step_its_harmonics_and_a_little_of_the_stride():
    """As the phones in hands have it: 1, 0.1 … 0.4, 0.1 … 0.3; strides 0.05 … 0.25."""
    norm = steady(cadence=1.9, step_length=0.72)
    size = np.abs(np.fft.rfft(norm - norm.mean())) / len(norm) * 2.0
    share = {part: size[round(part * 40)] / size[40] for part in (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)}
    assert 2.0 < size[40] < 5.0
    assert 0.1 < share[2.0] < 0.45
    assert 0.1 < share[3.0] < 0.45
    assert share[4.0] < 0.3
    assert 0.03 < share[0.5] < 0.25
    assert 0.03 < share[1.5] < 0.25


def test_without_asymmetry_every_step_is_alike():
    norm = steady(asymmetry=0.0, sway=0.0)
    size = np.abs(np.fft.rfft(norm - norm.mean()))
    assert size[20] < 0.03 * size[40]


def test_trunk_rolls_and_turns_as_far_as_told():
    body = walk(sway=0.1, heading=0.5)
    euler = body.at(np.linspace(5.0, 30.0, 5000)).euler - np.array([0.0, 0.0, 0.5])
    assert np.abs(euler).max(axis=0) == pytest.approx([0.1, 0.05, 0.1], rel=1e-3)
    level = walk(sway=0.0).at(np.linspace(0.0, 30.0, 100))
    assert not level.euler.any()


def test_legs_too_short_for_the_step_are_refused():
    with pytest.raises(SettingsError, match=r'driver\.walk\.step_length: 1.8 m is more than'):
        WalkSettings(step_length=1.8)
    WalkSettings(step_length=1.8, leg_length=1.0)
