"""A sensor on a turning table feels what goes round with it."""

import numpy as np
import pytest

from dead_reckoning.sources.motions.turntable import Turntable, TurntableSettings

STEADY = np.array([5.0, 5.5, 6.0])


def turntable(**settings):
    return Turntable(TurntableSettings(**settings))


def in_body(truth, part):
    return np.einsum('nji,nj->ni', truth.rotation, getattr(truth, part))


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_at_a_steady_rate_it_is_drawn_to_the_axis(sign):
    rate, radius = 1.5, 0.2
    truth = turntable(angle=sign * 20.0, rate=rate, radius=radius, ramp=0.5).at(STEADY)
    np.testing.assert_allclose(truth.angular_velocity, [[0.0, 0.0, sign * rate]] * 3)
    np.testing.assert_allclose(
        in_body(truth, 'acceleration'), [[0.0, rate**2 * radius, 0.0]] * 3, atol=1e-12
    )
    np.testing.assert_allclose(
        in_body(truth, 'velocity'), [[sign * rate * radius, 0.0, 0.0]] * 3, atol=1e-12
    )


def test_it_stays_on_the_circle():
    body = turntable(radius=0.2)
    position = body.at(np.linspace(0.0, body.duration, 500)).position
    centre = np.array([0.0, 0.2, 0.0])
    np.testing.assert_allclose(np.linalg.norm(position - centre, axis=1), 0.2)


@pytest.mark.parametrize('angle', [2.0 * np.pi, -1.0, 0.0, 30.0])
def test_it_ends_at_its_angle(angle):
    body = turntable(angle=angle)
    end = body.at(np.array([body.duration]))
    assert end.euler[0, 2] == angle
    assert np.arctan2(end.rotation[0, 1, 0], end.rotation[0, 0, 0]) == pytest.approx(
        np.arctan2(np.sin(angle), np.cos(angle))
    )


def test_on_the_axis_it_only_turns():
    truth = turntable(radius=0.0).at(STEADY)
    assert not truth.acceleration.any()
    assert truth.angular_velocity.any()
