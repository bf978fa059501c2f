"""The preset for robot_localization over DDS: a twist that is never certain, and no transform."""

from pathlib import Path

import numpy as np
import pytest
from messages import GRAVITY, Feed, imu_message
from nav_msgs.msg import Odometry
from ros_harness import lossless
from sensor_msgs.msg import Imu

PRESET = Path(__file__).parents[2] / 'config' / 'robot_localization.yaml'
UNKNOWN = [0.0] * 9
FLOOR = 0.999e-9
"""robot_localization believes no variance below 1e-9; the velocity at the start has that."""


@pytest.mark.parametrize('said', [True, False], ids=['covariances given', 'all zero'])
def test_every_twist_has_a_covariance_and_nothing_is_broadcast(ros, said):
    """Rest and a push, of an IMU that says its noise, or leaves all covariances at zero."""
    ros.start('pipeline', lossless('/imu/data_raw', '/odom'), '--params-file', str(PRESET))
    raw = ros.publisher('imu/data_raw', Imu)
    odom = ros.record('odom', Odometry).connected()

    def publish(stamp_ns, push):
        message = imu_message(stamp_ns, (push, 0.0, GRAVITY))
        message.angular_velocity.z = 0.01
        message.angular_velocity_covariance = [1e-6, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1e-6]
        if not said:
            message.angular_velocity_covariance = UNKNOWN
            message.linear_acceleration_covariance = UNKNOWN
        raw.publish(message)

    feed = Feed(ros, publish)
    feed.send_until(lambda: len(odom) > 100, 'odometry at rest', 0.0)

    def pushed():
        return odom.messages[-1].twist.twist.linear.x > 0.1

    feed.send_until(pushed, 'odometry of a push', 1.0)
    for message in odom.messages:
        assert message.header.frame_id == 'odom'
        assert message.child_frame_id == 'base_link'
        covariance = np.reshape(message.twist.covariance, (6, 6))
        assert (np.linalg.eigvalsh(covariance) >= FLOOR).all()
        assert (covariance.diagonal() < 1.0).all()
    assert not {'/tf', '/tf_static'} & {name for name, _ in ros.node.get_topic_names_and_types()}
