"""Laws that every motion keeps: its truth is exact."""

import numpy as np
import pytest

from dead_reckoning.sources import motions

STEP = 1e-5


def motion(name):
    kind = motions.motion_class(name)
    return kind(kind.Settings())


def times(body):
    """Cover the motion and the rest after it, beside the switching points."""
    return np.linspace(0.0, body.duration + 1.0, 2003)[1:]


@pytest.fixture(params=motions.names())
def body(request):
    return motion(request.param)


def test_velocity_is_the_derivative_of_position(body):
    time = times(body)
    before, after = body.at(time - STEP), body.at(time + STEP)
    derivative = (after.position - before.position) / (2.0 * STEP)
    np.testing.assert_allclose(body.at(time).velocity, derivative, atol=1e-6)


def test_acceleration_is_the_derivative_of_velocity(body):
    time = times(body)
    before, after = body.at(time - STEP), body.at(time + STEP)
    derivative = (after.velocity - before.velocity) / (2.0 * STEP)
    np.testing.assert_allclose(body.at(time).acceleration, derivative, atol=1e-3)


def test_it_rests_for_good_after_its_duration(body):
    after = body.at(body.duration + np.array([0.0, 0.001, 1.0, 1e6]))
    assert not after.velocity.any()
    assert not after.acceleration.any()
    np.testing.assert_array_equal(after.position, np.broadcast_to(after.position[0], (4, 3)))


def test_it_starts_at_rest(body):
    start = body.at(np.array([0.0]))
    assert not start.velocity.any()


def test_shapes(body):
    for count in (0, 1, 7):
        truth = body.at(np.linspace(0.0, 5.0, count))
        for part in (truth.position, truth.velocity, truth.acceleration):
            assert part.shape == (count, 3)


@pytest.mark.parametrize('name', motions.names())
def test_settings_carry_the_name(name):
    assert motions.motion_class(name).Settings.prefix == f'driver.{name}'
