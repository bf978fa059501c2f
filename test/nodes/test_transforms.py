"""The transform odom → base_link, or a clear word where tf2_ros is missing."""

from importlib.util import find_spec

import pytest
from geometry_msgs.msg import AccelWithCovarianceStamped
from messages import GRAVITY, Feed, acceleration_message, imu_message
from nav_msgs.msg import Odometry
from ros_harness import NodeProcess
from sensor_msgs.msg import Imu

HAS_TF = find_spec('tf2_ros') is not None


@pytest.mark.skipif(HAS_TF, reason='tf2_ros is installed here')
@pytest.mark.parametrize('name', ['integrator', 'pipeline'])
def test_a_transform_without_tf2_ros_is_refused_with_the_remedy(domain_id, tmp_path, name):
    node = NodeProcess(name, domain_id, tmp_path / 'node', {'frames.publish_tf': True})
    assert node.wait() == 2
    (line,) = node.stderr.splitlines()
    assert 'frames.publish_tf is true, and tf2_ros is not installed' in line
    assert 'ros-jazzy-tf2-ros-py' in line


@pytest.mark.skipif(HAS_TF, reason='tf2_ros is installed here')
def test_a_node_that_broadcasts_nothing_takes_the_key(ros):
    ros.start('gravity_removal', {'frames.publish_tf': True})
    assert ros.get('gravity_removal', 'frames.publish_tf') == [True]


@pytest.mark.skipif(not HAS_TF, reason='tf2_ros comes with ROS 2, not with its wheels on PyPI')
def test_the_transform_is_what_the_odometry_says(ros):
    from tf2_msgs.msg import TFMessage

    ros.start('integrator', {'frames.publish_tf': True, 'integrator.movement_end': 'off'})
    attitude = ros.publisher('imu/data', Imu)
    acceleration = ros.publisher('imu/linear_acceleration', AccelWithCovarianceStamped)
    odom = ros.record('odom', Odometry).connected()
    broadcast = ros.record('/tf', TFMessage).connected()

    def publish(stamp_ns):
        attitude.publish(imu_message(stamp_ns, (0.0, 0.0, GRAVITY), (0.0, 0.0, 0.6, 0.8)))
        acceleration.publish(acceleration_message(stamp_ns, (1.0, 0.5, 0.0)))

    feed = Feed(ros, publish)
    feed.send_until(lambda: len(odom) > 50 and len(broadcast) > 50, 'odom and its transform')
    by_stamp = dict(zip(odom.stamps, odom.messages, strict=True))
    compared = 0
    for message in broadcast.messages:
        (transform,) = message.transforms
        stamp = transform.header.stamp
        state = by_stamp.get(stamp.sec * 1_000_000_000 + stamp.nanosec)
        if state is None:
            continue
        compared += 1
        assert transform.header.frame_id == 'odom'
        assert transform.child_frame_id == 'base_link'
        moved, place = transform.transform.translation, state.pose.pose.position
        assert (moved.x, moved.y, moved.z) == (place.x, place.y, place.z)
        assert transform.transform.rotation == state.pose.pose.orientation
    assert compared > 30
