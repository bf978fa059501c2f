"""Where gravity_removal takes the attitude from, over DDS."""

import math

import pytest
from messages import GRAVITY, Feed, fill, imu_message, stamped
from ros_harness import RELIABLE
from sensor_msgs.msg import Imu

from dead_reckoning.core.rotation import quaternion_from_euler, yaw_from_quaternion

LEVEL = (0.0, 0.0, GRAVITY)


def heading_message(stamp_ns, yaw, deviation=0.05):
    """Return what a compass says: a yaw with its variance, and nothing else."""
    message = stamped(Imu(), stamp_ns, 'compass_link')
    fill(message.orientation, 'xyzw', quaternion_from_euler(0.0, 0.0, yaw))
    message.orientation_covariance = [1e6, 0.0, 0.0, 0.0, 1e6, 0.0, 0.0, 0.0, deviation**2]
    message.angular_velocity_covariance[0] = -1.0
    message.linear_acceleration_covariance[0] = -1.0
    return message


class Sensor:
    """A board with a compass, and maybe a gyro, and what gravity_removal makes of it."""

    def __init__(self, ros, attitude, rate=None):
        process = ros.start('gravity_removal', {'gravity.attitude': attitude})
        self.process = process
        self.yaw = 0.7
        self._rate = rate
        self._raw = ros.publisher('imu/data_raw', Imu)
        self._compass = ros.publisher('compass/data', Imu)
        self.levelled = ros.record('imu/data', Imu, RELIABLE).connected()
        self.feed = Feed(ros, self._publish)

    def _publish(self, stamp_ns):
        message = imu_message(stamp_ns, LEVEL)
        if self._rate is not None:
            fill(message.angular_velocity, 'xyz', self._rate)
            message.angular_velocity_covariance = [1e-6, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1e-6]
        if stamp_ns // self.feed.step_ns % 10 == 0:
            self._compass.publish(heading_message(stamp_ns, self.yaw))
        self._raw.publish(message)

    def last_yaw(self):
        if not self.levelled.messages:
            return math.nan
        q = self.levelled.messages[-1].orientation
        return yaw_from_quaternion((q.x, q.y, q.z, q.w))

    def until_yaw_is(self, yaw):
        self.feed.send_until(lambda: abs(self.last_yaw() - yaw) < 1e-3, f'a yaw of {yaw}')


def test_rest_takes_its_yaw_from_the_compass(ros):
    sensor = Sensor(ros, 'rest')
    sensor.until_yaw_is(0.7)
    sensor.yaw = -2.0
    sensor.until_yaw_is(-2.0)
    covariance = sensor.levelled.messages[-1].orientation_covariance
    assert math.sqrt(covariance[8]) == pytest.approx(0.05)


def test_estimate_starts_with_the_yaw_of_the_compass(ros):
    sensor = Sensor(ros, 'estimate', rate=(0.01, -0.02, 0.0))
    sensor.until_yaw_is(0.7)
    said = 'gyro bias 0.573, -1.146, 0.000'
    sensor.feed.send_until(lambda: said in sensor.process.stderr, 'the bias in the log')
    rate = sensor.levelled.messages[-1].angular_velocity
    assert [rate.x, rate.y, rate.z] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


def test_estimate_without_a_gyro_says_what_to_do(ros):
    sensor = Sensor(ros, 'estimate')
    sensor.feed.send_until(
        lambda: 'set gravity.attitude to rest' in sensor.process.stderr, 'the remedy'
    )
    assert not sensor.levelled.messages
