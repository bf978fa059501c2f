"""The driver over DDS: its sensors, its gyroscope and its motions."""

import numpy as np
import pytest
from nav_msgs.msg import Odometry
from ros_harness import NodeProcess, figures, stamp_ns
from sensor_msgs.msg import Imu

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.stages import RAW
from dead_reckoning.nodes.driver import driver_of
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver_settings import DriverSettings

QUICK = {'driver.calibrate_on_start': False, 'driver.simulated.offset': [0.0, 0.0, 0.0]}


def vector(message):
    return np.array([message.x, message.y, message.z])


def test_gyroscope_goes_out_with_the_force(ros):
    ros.start(
        'accelerometer_driver',
        {
            **QUICK,
            'driver.motion': 'turntable',
            'driver.turntable.start': 0.0,
            'driver.turntable.angle': -500.0,
            'driver.turntable.rate': 2.0,
            'driver.gyro.enabled': True,
        },
    )
    raw = ros.record('imu/data_raw', Imu)
    truth = ros.record('ground_truth/odom', Odometry)
    raw.wait(200)
    truth.wait(200)
    true = {stamp_ns(m): vector(m.twist.twist.angular) for m in truth.messages}
    compared = 0
    for message in raw.messages:
        x, y, z = np.reshape(message.angular_velocity_covariance, (3, 3)).diagonal()
        assert 0.0 < x == y == z < 1e-3
        assert message.orientation_covariance[0] == -1.0
        if stamp_ns(message) in true:
            compared += 1
            rate = vector(message.angular_velocity)
            assert rate == pytest.approx(true[stamp_ns(message)], abs=0.03)
    assert compared > 100
    assert vector(raw.messages[-1].angular_velocity)[2] == pytest.approx(-2.0, abs=0.03)


def test_saturated_gyroscope_shows_in_covariance_and_diagnostics(ros):
    ros.start(
        'accelerometer_driver',
        {
            **QUICK,
            'driver.motion': 'turntable',
            'driver.turntable.start': 0.0,
            'driver.turntable.angle': 500.0,
            'driver.turntable.rate': 2.0,
            'driver.gyro.enabled': True,
            'driver.gyro.range': 1.0,
        },
    )
    raw = ros.record('imu/data_raw', Imu)
    raw.wait(150)
    last = np.reshape(raw.messages[-1].angular_velocity_covariance, (3, 3)).diagonal()
    assert last[2] == 1.0
    assert last[0] < 1e-3
    ros.diagnostics().until(
        'accelerometer_driver',
        lambda status: int(figures(status)['saturated_rates']) > 1000,
        'saturated rates',
    )


@pytest.mark.parametrize(('sensor', 'noise'), [('adxl330', 0.02), ('adxl345', 0.06)])
def test_other_sensors_rest_at_one_g(ros, sensor, noise):
    ros.start('accelerometer_driver', {**QUICK, 'driver.motion': 'rest', 'driver.sensor': sensor})
    messages = ros.record('imu/data_raw', Imu).wait(60)
    force = np.array([vector(message.linear_acceleration) for message in messages])
    assert force.mean(axis=0) == pytest.approx([0.0, 0.0, GRAVITY], abs=0.1)
    assert (force.std(axis=0) < noise).all()


def test_every_motion_runs(ros):
    """All of them at once, each in a namespace of its own."""
    spaces = {}
    for name in motions.names():
        parameters = {
            **QUICK,
            'driver.motion': name,
            'driver.sample_rate': 400.0,
            'driver.samples_per_message': 40,
            'driver.wait_for_subscribers': 2,
        }
        if name != 'rest':
            parameters[f'driver.{name}.start'] = 0.0
        ros.start('accelerometer_driver', parameters, '-r', f'__ns:=/{name}')
        spaces[name] = ros.record(f'/{name}/ground_truth/odom', Odometry)
    for name, truth in spaces.items():
        truth.connected()
        ros.record(f'/{name}/imu/data_raw', Imu)  # what the driver waits for
    for name, truth in spaces.items():
        truth.wait(10)
        moved = np.array([vector(message.pose.pose.position) for message in truth.messages])
        assert np.ptp(moved, axis=0).any() == (name != 'rest'), name


def test_every_source_has_a_driver_that_publishes_samples():
    (source,) = (p for p in DriverSettings.parameters() if p.name == 'source')
    for name in source.choices:
        configuration = Configuration({'driver.source': name})
        driver = driver_of(configuration)
        assert driver.__name__ == f'{name.title()}Driver'
        assert RAW in driver.outputs(configuration)


def test_range_that_the_sensor_has_not_stops_the_driver_with_those_it_has(domain_id, tmp_path):
    parameters = {'driver.sensor': 'adxl345', 'driver.range_g': 6.0}
    node = NodeProcess('accelerometer_driver', domain_id, tmp_path / 'node', parameters)
    assert node.wait() == 2
    (line,) = node.stderr.splitlines()
    assert 'driver.range_g: 6 is not allowed; the adxl345 has 2, 4, 8, 16 [g]' in line
