"""Transforms: odom → base_link, and how the sensor sits; or a clear word without tf2_ros."""

import math
from importlib.util import find_spec

import pytest
from geometry_msgs.msg import AccelWithCovarianceStamped, TransformStamped
from messages import GRAVITY, Feed, acceleration_message, fill, imu_message
from nav_msgs.msg import Odometry
from ros_harness import LATCHED, NodeProcess
from sensor_msgs.msg import Imu

from dead_reckoning.core.errors import MissingMountingError, NotFiniteError
from dead_reckoning.nodes.transforms import MountingsFromTransforms, mounting_from

HAS_TF = find_spec('tf2_ros') is not None


@pytest.mark.skipif(HAS_TF, reason='tf2_ros is installed here')
@pytest.mark.parametrize('name', ['integrator', 'inertial_navigator', 'pipeline'])
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


# How the sensor sits ------------------------------------------------------------------------


@pytest.mark.skipif(HAS_TF, reason='tf2_ros is installed here')
@pytest.mark.parametrize(
    'name', ['gravity_removal', 'inertial_navigator', 'integrator', 'pedometer', 'pipeline']
)
def test_a_mounting_from_tf_without_tf2_ros_is_refused_with_the_remedy(domain_id, tmp_path, name):
    node = NodeProcess(name, domain_id, tmp_path / 'node', {'frames.mounting': 'tf'})
    assert node.wait() == 2
    (line,) = node.stderr.splitlines()
    assert 'frames.mounting is tf, and tf2_ros is not installed' in line
    assert 'ros-jazzy-tf2-ros-py, or set frames.mounting to parameters' in line


@pytest.mark.parametrize('name', ['accelerometer_driver', 'compass_driver'])
def test_a_driver_takes_the_key_as_it_turns_nothing(ros, name):
    ros.start(name, {'frames.mounting': 'tf'})
    assert ros.get(name, 'frames.mounting') == ['tf']


def test_a_transform_is_read_as_tf2_looks_it_up():
    """From the sensor to the body: its rotation takes s into b, its translation is in b."""
    assert transform_to_body().child_frame_id == 'imu_link'
    mounting = mounting_from(transform_to_body())
    assert mounting.rotation == UPSIDE_DOWN
    assert mounting.translation == LEVER_ARM


def test_a_transform_is_asked_for_until_it_is_there_and_then_no_more():
    known, asked, said = {}, [], []

    def look_up(frame_id):
        asked.append(frame_id)
        if frame_id not in known:
            raise LookupError('tf2: two trees')
        return known[frame_id]

    mountings = MountingsFromTransforms('base_link', look_up, said.append)
    for _ in range(2):
        with pytest.raises(
            MissingMountingError,
            match=r"how 'imu_link' sits on 'base_link' \(tf2: two trees\): start",
        ):
            mountings('imu_link')
    known['imu_link'] = transform_to_body()
    found = mountings('imu_link')
    assert mountings('imu_link') is found
    assert found.translation == LEVER_ARM
    with pytest.raises(MissingMountingError, match='other_link'):
        mountings('other_link')
    assert asked == ['imu_link'] * 3 + ['other_link']
    assert said == ['imu_link sits on base_link at (0.1, -0.2, 0.3) m, as TF says']


@pytest.mark.parametrize('place', [math.inf, math.nan, -1e7])
def test_a_lever_arm_that_is_none_is_refused_until_it_is_mended(place):
    known = {'imu_link': transform_to_body()}
    said = []
    mountings = MountingsFromTransforms('base_link', known.__getitem__, said.append)
    known['imu_link'].transform.translation.y = place
    for _ in range(2):
        with pytest.raises(NotFiniteError, match=r'lever arm of imu_link is .* on /tf_static'):
            mountings('imu_link')
    assert said == []
    known['imu_link'] = transform_to_body()
    assert mountings('imu_link').translation == LEVER_ARM


UPSIDE_DOWN = (1.0, 0.0, 0.0, 0.0)
LEVER_ARM = (0.1, -0.2, 0.3)


def transform_to_body(child='imu_link'):
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = 'base_link'
    fill(transform.transform.translation, 'xyz', LEVER_ARM)
    fill(transform.transform.rotation, 'xyzw', UPSIDE_DOWN)
    return transform


def test_an_upside_down_sensor_is_level_by_its_parameters(ros):
    ros.start(
        'pipeline',
        {
            'frames.mounting_rotation': [math.pi, 0.0, 0.0],
            'frames.mounting_translation': list(LEVER_ARM),
        },
    )
    stands_level(ros)


@pytest.mark.skipif(not HAS_TF, reason='tf2_ros comes with ROS 2, not with its wheels on PyPI')
@pytest.mark.parametrize('executor', ['events', 'single'])
def test_an_upside_down_sensor_is_level_by_tf(ros, executor):
    from tf2_msgs.msg import TFMessage

    node = ros.start('pipeline', {'frames.mounting': 'tf', 'common.executor': executor})
    raw = ros.publisher('imu/data_raw', Imu)
    feed = Feed(ros, lambda stamp_ns: raw.publish(imu_message(stamp_ns, (0.0, 0.0, -GRAVITY))))
    feed.send_until(lambda: 'waiting on /tf_static' in node.stderr, 'the line that it waits')
    static = ros.node.create_publisher(TFMessage, '/tf_static', LATCHED)
    static.publish(TFMessage(transforms=[transform_to_body()]))
    stands_level(ros, feed)
    assert node.stderr.count('waiting on /tf_static') == 1
    assert '(tf2: ' in node.stderr


@pytest.mark.skipif(not HAS_TF, reason='tf2_ros comes with ROS 2, not with its wheels on PyPI')
def test_a_mounting_that_is_there_already_is_taken_without_a_warning(ros):
    from tf2_ros import StaticTransformBroadcaster

    broadcaster = StaticTransformBroadcaster(ros.node)
    mount = transform_to_body('mount')
    sensor = transform_to_body()
    sensor.header.frame_id = 'mount'
    fill(sensor.transform.translation, 'xyz', (0.0, 0.0, 0.1))
    fill(sensor.transform.rotation, 'xyzw', (0.0, 0.0, 0.0, 1.0))
    broadcaster.sendTransform([mount, sensor])
    node = ros.start('pipeline', {'frames.mounting': 'tf'})
    stands_level(ros)
    assert 'imu_link sits on base_link at (0.1, -0.2, 0.2) m, as TF says' in node.stderr
    assert 'waiting' not in node.stderr


def stands_level(ros, feed=None):
    """Feed an upside-down sensor at rest; the body is level, and not warned of."""
    odom = ros.record('odom', Odometry).connected()
    attitude = ros.record('imu/data', Imu).connected()
    if feed is None:
        raw = ros.publisher('imu/data_raw', Imu)
        feed = Feed(ros, lambda stamp_ns: raw.publish(imu_message(stamp_ns, (0, 0, -GRAVITY))))
    feed.send_until(lambda: len(odom) > 20 and len(attitude) > 20, 'odometry and attitude')
    assert attitude.messages[-1].header.frame_id == 'imu_link'
    seen = attitude.messages[-1].orientation
    assert [abs(seen.x), seen.y, seen.z, seen.w] == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-6)
    pose = odom.messages[-1].pose.pose
    assert pose.orientation.w == pytest.approx(1.0)
    assert pose.position.x == pytest.approx(0.0, abs=1e-6)
    assert odom.messages[-1].child_frame_id == 'base_link'
