"""Sensor and front end as the settings ask for: from a motion to samples."""

import numpy as np
import pytest

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings

START_NS = 1_700_000_000_000_000_000


def samples(seconds, **values):
    """Run a driver; keys are those of the driver with `__` for the dots."""
    given = {f'driver.{key.replace("__", ".")}': value for key, value in values.items()}
    configuration = Configuration(given)
    source, end = simulated_sensor(configuration, START_NS), front_end(configuration)
    made = end.add(source.read(round(seconds * configuration[DriverSettings].sample_rate)))
    return made, source, end


def test_samples_carry_force_and_rate_of_one_moment():
    """On the turning table, off its axis: both say how fast it turns."""
    made, _, _ = samples(7.0, motion='turntable', turntable__angle=20.0, gyro__enabled=True)
    steady = [sample for sample in made if 4.0e9 < sample.stamp_ns - START_NS < 6.9e9]
    rate = np.mean([sample.angular_velocity for sample in steady], axis=0)
    force = np.mean([sample.specific_force for sample in steady], axis=0)
    assert rate == pytest.approx([0.0, 0.0, np.pi / 2.0], abs=0.02)
    assert force == pytest.approx([0.0, 0.1 * rate[2] ** 2, GRAVITY], abs=0.05)


def test_without_a_gyroscope_there_is_no_rate():
    made, _, _ = samples(0.5)
    assert {sample.angular_velocity for sample in made} == {None}


def test_rate_has_the_covariance_of_its_mean():
    """A hundred seconds at rest: what the samples show is what they say."""
    made, _, _ = samples(
        100.0,
        motion='rest',
        sample_rate=800.0,
        samples_per_message=8,
        calibrate_on_start=False,
        gyro__enabled=True,
        gyro__bias_walk=0.0,
        gyro__noise=0.001,
    )
    rates = np.array([sample.angular_velocity for sample in made])
    said = made[0].angular_velocity_covariance
    assert said[1:4] == said[5:8] == (0.0, 0.0, 0.0)
    assert rates.var(axis=0) == pytest.approx(said[::4], rel=0.05)
    assert rates.mean(axis=0) == pytest.approx(np.radians([0.3, -0.2, 0.1]), abs=3e-4)


def test_saturated_rate_is_counted_and_shows_in_the_covariance():
    made, _, end = samples(
        7.0,
        motion='turntable',
        turntable__rate=6.0,
        turntable__angle=60.0,
        gyro__enabled=True,
        gyro__range=5.0,
    )
    steady = [sample for sample in made if 4.0e9 < sample.stamp_ns - START_NS < 6.9e9]
    for sample in steady:
        x, y, z = sample.angular_velocity_covariance[::4]
        assert z == 25.0
        assert x == y < 1e-3
        assert sample.angular_velocity[2] == pytest.approx(5.0, abs=0.01)
    assert len(steady) * 64 <= end.saturated < len(made) * 64
    assert end.clipped == 0


@pytest.mark.parametrize('sensor', ['mma7260qt', 'adxl330', 'adxl345'])
def test_every_sensor_rests_at_one_g_once_calibrated(sensor):
    made, _, end = samples(3.0, motion='rest', sensor=sensor)
    force = np.mean([sample.specific_force for sample in made], axis=0)
    assert force == pytest.approx([0.0, 0.0, GRAVITY], abs=0.05)
    assert end.finding is None
    deviation = np.sqrt(made[0].specific_force_covariance[0])
    assert 0.001 < deviation < 0.05


@pytest.mark.parametrize('name', motions.names())
def test_force_is_the_true_one_within_the_faults_of_the_sensor(name):
    made, source, _ = samples(
        8.0,
        motion=name,
        sensor='adxl345',
        range_g=16.0,
        gyro__enabled=True,
        simulated__axis_delay=0.0,
    )
    kind = motions.motion_class(name)
    body = kind(kind.Settings())
    assert len(made) > 700
    for sample in made[::7]:
        moments = (sample.stamp_ns - START_NS) / 1e9 + np.linspace(-0.005, 0.005, 64)
        truth = body.at(moments)
        lifted = truth.acceleration + np.array([0.0, 0.0, GRAVITY])
        force = np.einsum('nji,nj->ni', truth.rotation, lifted).mean(axis=0)
        allowed = 0.08 + 0.015 * np.linalg.norm(force)
        np.testing.assert_allclose(sample.specific_force, force, atol=allowed)
        rate = truth.angular_velocity.mean(axis=0)
        allowed = 0.02 + 0.005 * np.linalg.norm(rate)
        np.testing.assert_allclose(sample.angular_velocity, rate, atol=allowed)
        state = source.truth(sample.stamp_ns)
        np.testing.assert_allclose(state.angular_velocity, truth.angular_velocity[32], atol=0.1)


def test_start_of_the_motion_is_the_stamp_given():
    made, source, _ = samples(1.0, calibrate_on_start=False)
    assert made[0].stamp_ns == START_NS + 31_500_000_000 // 6400
    assert source.truth(START_NS + 3_500_000_000).position[0] == pytest.approx(0.25)
