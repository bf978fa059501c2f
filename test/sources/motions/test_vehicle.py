"""A vehicle drives nose ahead, and stops on its way."""

import numpy as np
import pytest

from dead_reckoning.sources.motions.vehicle import Vehicle, VehicleSettings


@pytest.fixture(params=[{}, {'stops': 1}, {'stops': 7, 'loops': 3, 'length': 100.0}], ids=str)
def settings(request):
    return VehicleSettings(**request.param)


def drive(body, rate=100.0):
    return body.at(np.arange(0.0, body.duration, 1.0 / rate))


def test_it_never_slips_and_never_reverses(settings):
    truth = drive(Vehicle(settings))
    velocity_b = np.einsum('nji,nj->ni', truth.rotation, truth.velocity)
    np.testing.assert_allclose(velocity_b[:, 1:], 0.0, atol=1e-9)
    assert (velocity_b[:, 0] >= -1e-9).all()
    assert velocity_b[:, 0].max() > 1.0


def test_it_stops_as_often_as_told(settings):
    truth = drive(Vehicle(settings))
    moving = np.linalg.norm(truth.velocity, axis=1) > 1e-6
    assert np.count_nonzero(np.diff(moving.astype(int)) == 1) == settings.stops * settings.loops


def test_it_stands_still_for_the_time_of_a_stop():
    settings = VehicleSettings(stops=2, loop_time=30.0, pause=5.0, start=3.0)
    truth = Vehicle(settings).at(np.linspace(18.0 + 1e-6, 23.0, 100))
    assert not truth.velocity.any()
    assert not truth.angular_velocity.any()
    np.testing.assert_array_equal(truth.position, truth.position[:1].repeat(100, 0))


def test_eight_is_as_long_and_as_wide_as_told(settings):
    position = drive(Vehicle(settings)).position
    assert np.ptp(position[:, 0]) == pytest.approx(settings.length, rel=1e-3)
    assert np.ptp(position[:, 1]) == pytest.approx(settings.width, rel=1e-3)
    assert not position[:, 2].any()


def test_it_returns_to_where_it_began(settings):
    body = Vehicle(settings)
    start, end = body.at(np.array([0.0, body.duration])).position
    np.testing.assert_allclose(end, start, atol=1e-9)


def test_default_drives_as_a_car_in_a_yard():
    truth = drive(Vehicle(VehicleSettings()))
    assert 5.0 < np.linalg.norm(truth.velocity, axis=1).max() < 12.0
    assert 1.0 < np.abs(truth.acceleration).max() < 4.0
    assert 0.2 < np.abs(truth.angular_velocity[:, 2]).max() < 1.0
