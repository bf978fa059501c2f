"""The compass driver over DDS: headings of the very body that the accelerometer is on."""

import math

import numpy as np
import pytest
from nav_msgs.msg import Odometry
from ros_harness import EXECUTORS, RELIABLE, lossless, stamp_ns
from sensor_msgs.msg import Imu

TURNING = {
    'driver.motion': 'turntable',
    'driver.turntable.start': 0.0,
    'driver.turntable.angle': 1000.0,
    'driver.turntable.rate': 3.0,
    'driver.calibrate_on_start': False,
    **lossless('/ground_truth/odom', '/compass/data'),
}
PLAIN = {
    'compass.simulated.noise': False,
    'compass.simulated.quantise': False,
    'compass.simulated.iron': [0.0, 0.0],
}


def yaw_of(q):
    return 2.0 * math.atan2(q.z, q.w)


def errors(compass, truth):
    """Return how far the yaws are from the true ones of their stamps [rad]."""
    true = {stamp_ns(message): yaw_of(message.pose.pose.orientation) for message in truth.messages}
    return np.array(
        [
            math.remainder(yaw_of(message.orientation) - true[stamp_ns(message)], 2.0 * math.pi)
            for message in compass.messages
            if stamp_ns(message) in true
        ]
    )


@pytest.mark.parametrize('executor', EXECUTORS)
@pytest.mark.parametrize('source', ['accelerometer_driver', 'pipeline'])
def test_it_tells_the_yaw_of_the_simulated_body(ros, source, executor):
    """Whichever node moves the body, and though the compass comes later."""
    parameters = {**TURNING, 'pipeline.source': 'simulated', 'common.executor': executor}
    ros.start(source, parameters)
    truth = ros.record('ground_truth/odom', Odometry, RELIABLE)
    truth.wait(20)
    ros.start('compass_driver', {**parameters, **PLAIN})
    compass = ros.record('compass/data', Imu)
    compass.wait(60)
    found = errors(compass, truth)
    assert len(found) >= 40
    assert found == pytest.approx(0.0, abs=1e-6)
    yaws = [yaw_of(message.orientation) for message in compass.messages]
    assert np.ptp(yaws) > 5.0, 'it turns'


def test_message_says_what_it_measures_and_what_not(ros):
    ros.start('accelerometer_driver', {'driver.motion': 'rest'})
    ros.start('compass_driver', {'compass.deviation': 0.1, 'frames.sensor': 'mast'})
    for message in ros.record('compass/data', Imu).wait(20):
        assert message.header.frame_id == 'mast'
        assert message.angular_velocity_covariance[0] == -1.0
        assert message.linear_acceleration_covariance[0] == -1.0
        covariance = np.reshape(message.orientation_covariance, (3, 3))
        assert covariance[0, 0] == covariance[1, 1] == 1e6
        assert math.sqrt(covariance[2, 2]) == pytest.approx(0.1, rel=0.01)
        assert yaw_of(message.orientation) == pytest.approx(0.0, abs=0.15)


def test_headings_come_at_their_rate(ros):
    ros.start('accelerometer_driver', {**TURNING, 'driver.motion': 'rest'})
    ros.start('compass_driver', {**TURNING, 'compass.rate': 10.0})
    compass = ros.record('compass/data', Imu)
    compass.wait(15)
    apart = np.diff(compass.stamps[2:])
    np.testing.assert_allclose(apart, 1e8, atol=1.1e7)


@pytest.mark.parametrize('executor', EXECUTORS)
def test_calibration_takes_the_iron_off_after_a_full_turn(ros, executor):
    iron = {'compass.simulated.iron': [0.3, -0.2], 'common.executor': executor}
    ros.start('accelerometer_driver', TURNING)
    ros.start('compass_driver', {**TURNING, **PLAIN, **iron})
    truth = ros.record('ground_truth/odom', Odometry, RELIABLE)
    compass = ros.record('compass/data', Imu)
    truth.wait(1)
    compass.wait(len(compass) + 60)  # some were taken before their truth came
    found = errors(compass, truth)
    assert len(found) > 40
    assert np.abs(found).max() > 0.3
    answer = ros.trigger('compass_driver/calibrate')
    assert answer.success, answer.message
    assert (
        answer.message == 'iron adds +0.300, -0.200 of the horizontal field along x, y: taken off'
    )
    known = len(compass)
    compass.wait(known + 50)
    ros.until(lambda: truth.latest_stamp >= compass.stamps[known + 49], 'the truth')
    compass.messages = compass.messages[known + 5 :]
    found = errors(compass, truth)
    assert len(found) > 40
    assert found == pytest.approx(0.0, abs=1e-6)


def test_calibration_without_a_turn_fails_with_the_reason(ros):
    ros.start('accelerometer_driver', {'driver.motion': 'rest'})
    ros.start('compass_driver', {'compass.calibration_time': 1.0})
    compass = ros.record('compass/data', Imu)
    compass.wait(5)
    answer = ros.trigger('compass_driver/calibrate')
    assert not answer.success
    assert 'turned by 0° in 1 s' in answer.message or 'turned by 1° in 1 s' in answer.message
    assert 'turn it level once around' in answer.message
    known = len(compass)
    compass.wait(known + 5)


def test_without_a_simulated_body_it_waits_and_says_so(ros):
    ros.start('compass_driver')
    compass = ros.record('compass/data', Imu).connected()
    ros.diagnostics().until(
        'compass_driver',
        lambda status: status.message.startswith('waiting for samples on /ground_truth/odom: '),
        'that it waits',
    )
    assert len(compass) == 0
