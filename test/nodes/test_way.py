"""The way of a sample through three processes over DDS: driver, gravity removal, integrator."""

import math
from itertools import pairwise

import numpy as np
import pytest
from geometry_msgs.msg import AccelWithCovarianceStamped
from nav_msgs.msg import Odometry
from ros_harness import BEST_EFFORT, LATCHED, RELIABLE, lossless, stamp_ns
from sensor_msgs.msg import Imu
from std_msgs.msg import Bool

DISTANCE = 0.5
SLIDE = {'driver.slide.start': 1.5, 'driver.slide.duration': 1.0}
PITCH = 0.2
TOPICS = {
    'imu/data_raw': Imu,
    'imu/data': Imu,
    'imu/linear_acceleration': AccelWithCovarianceStamped,
    'odom': Odometry,
    'ground_truth/odom': Odometry,
}
CLOCK_SLACK = 0.2
"""Nodes look for rest half a second; so long [s] a first message may be missing."""


class Slide(dict):
    """Recordings by topic, and the names of all ``topics`` that there were."""

    topics: frozenset[str]


def slide(ros, parameters, *arguments, space=''):
    """Run the three nodes over a slide, all found before it starts; return what was recorded."""
    for name in ('gravity_removal', 'integrator'):
        ros.start(name, parameters, *arguments)
    # The driver waits for gravity removal, and for this test on both of its topics.
    waiting = {**parameters, 'driver.wait_for_subscribers': 3}
    ros.start('accelerometer_driver', waiting, *arguments)
    recordings = Slide()
    for topic, message in TOPICS.items():
        if topic != 'imu/data_raw':
            recordings[topic] = ros.record(f'{space}/{topic}', message).connected()
    recordings['stationary'] = ros.record(f'{space}/stationary', Bool, LATCHED).connected()
    recordings['best effort'] = ros.record(f'{space}/odom', Odometry, BEST_EFFORT).connected()
    recordings['imu/data_raw'] = ros.record(f'{space}/imu/data_raw', Imu)
    truth = recordings['ground_truth/odom']
    truth.wait(1)
    ros.until(lambda: truth.stamps[-1] - truth.stamps[0] > 3.0e9, 'the end of the slide')
    last = truth.stamps[-1]
    ros.until(lambda: recordings['odom'].stamps[-1] >= last, 'the last odometry')
    ros.until(lambda: recordings['imu/data'].stamps[-1] >= last, 'the last attitude')
    late = ros.record(f'{space}/stationary', Bool, LATCHED)
    late.wait(1)
    recordings['late'] = late
    recordings.topics = frozenset(name for name, _ in ros.node.get_topic_names_and_types())
    ros.end_all()
    for recording in recordings.values():
        recording.stop()
    return recordings


@pytest.fixture(scope='module')
def plain(module_ros):
    """The slide with everything at its default."""
    return slide(module_ros, SLIDE)


@pytest.fixture(scope='module')
def tilted(module_ros):
    """The slide on a tilted table, in a namespace, over queues that lose nothing."""
    parameters = {
        **SLIDE,
        **lossless(*(f'/robot/{topic}' for topic in TOPICS)),
        'driver.simulated.attitude': [0.0, PITCH, 0.0],
        'driver.simulated.offset': [0.0, 0.0, 0.0],
        'driver.calibrate_on_start': False,
    }
    return slide(module_ros, parameters, '-r', '__ns:=/robot', space='/robot')


def position(message):
    point = message.pose.pose.position
    return np.array([point.x, point.y, point.z])


def velocity(message):
    """Velocity in the child frame."""
    linear = message.twist.twist.linear
    return np.array([linear.x, linear.y, linear.z])


def test_the_slide_ends_where_it_should(plain):
    end = position(plain['odom'].messages[-1])
    truth = position(plain['ground_truth/odom'].messages[-1])
    assert truth == pytest.approx([DISTANCE, 0.0, 0.0])
    assert np.linalg.norm(end - truth) < 0.05 * DISTANCE
    assert velocity(plain['odom'].messages[-1]) == pytest.approx([0.0, 0.0, 0.0])


def test_the_true_end_is_within_what_the_covariance_says(plain):
    message = plain['odom'].messages[-1]
    error = position(message) - position(plain['ground_truth/odom'].messages[-1])
    deviation = np.sqrt(np.reshape(message.pose.covariance, (6, 6)).diagonal()[:3])
    assert (np.abs(error) < 3.0 * deviation).all()


def test_frames_are_the_ones_of_the_design(plain):
    for topic, frame_id in [
        ('imu/data_raw', 'imu_link'),
        ('imu/data', 'imu_link'),
        ('imu/linear_acceleration', 'odom'),
        ('odom', 'odom'),
        ('ground_truth/odom', 'odom'),
    ]:
        assert {message.header.frame_id for message in plain[topic].messages} == {frame_id}
    for topic in ('odom', 'ground_truth/odom'):
        assert {message.child_frame_id for message in plain[topic].messages} == {'base_link'}


def test_the_raw_imu_says_what_it_does_not_measure(plain):
    for message in plain['imu/data_raw'].messages:
        assert message.orientation_covariance[0] == -1.0
        assert message.angular_velocity_covariance[0] == -1.0
        assert message.linear_acceleration_covariance[0] > 0.0
    resting = plain['imu/data_raw'].messages[:50]
    assert np.mean([m.linear_acceleration.z for m in resting]) == pytest.approx(9.80665, abs=0.1)


def test_imu_data_carries_the_attitude_that_was_used(tilted):
    for message in tilted['imu/data'].messages:
        q = message.orientation
        assert message.orientation_covariance[0] > 0.0
        assert [q.x, q.y, q.z, q.w] == pytest.approx(
            [0.0, math.sin(PITCH / 2), 0.0, math.cos(PITCH / 2)], abs=0.01
        )


def test_covariances_are_symmetric_and_not_zero(plain):
    for message in plain['odom'].messages:
        for matrix in (message.pose.covariance, message.twist.covariance):
            covariance = np.reshape(matrix, (6, 6))
            assert np.isfinite(covariance).all()
            assert covariance == pytest.approx(covariance.T, rel=1e-9)
            assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    for message in plain['imu/linear_acceleration'].messages:
        covariance = np.reshape(message.accel.covariance, (6, 6))[:3, :3]
        assert covariance == pytest.approx(covariance.T, rel=1e-9)
        assert (np.linalg.eigvalsh(covariance) > 0.0).all()


def test_stationary_is_said_on_change_and_to_those_who_come_late(plain):
    said = [message.data for message in plain['stationary'].messages]
    # Rest before the slide, motion, rest after it; a pause in the middle of it may count too.
    assert said[0] is False
    assert said[-1] is True
    assert all(a is not b for a, b in pairwise(said))
    assert 4 <= len(said) <= 6
    assert [message.data for message in plain['late'].messages] == [True]


def test_best_effort_and_reliable_subscribers_both_get_odometry(plain):
    assert len(plain['best effort']) > 100
    assert set(plain['best effort'].stamps) <= set(plain['odom'].stamps)


def test_nothing_is_lost_on_the_way(tilted):
    """One of each for each sample, all with its stamp, from the first that all were heard of."""
    raw = tilted['imu/data_raw'].stamps
    assert raw == sorted(set(raw))
    assert np.ptp(np.diff(raw)) <= 1, 'a steady rate'
    first = max(recording.stamps[0] for topic, recording in tilted.items() if topic in TOPICS)
    last = tilted['odom'].stamps[-1]
    assert (first - raw[0]) * 1e-9 < 0.5 + CLOCK_SLACK
    expected = [stamp for stamp in raw if first <= stamp <= last]
    assert len(expected) > 200
    for topic in TOPICS:
        stamps = [stamp for stamp in tilted[topic].stamps if first <= stamp <= last]
        assert stamps == expected, topic


def test_twist_is_in_the_child_frame(tilted):
    """On a tilted table the body moves along its own x, and so in the world along x and −z."""
    for topic in ('odom', 'ground_truth/odom'):
        fastest = max(tilted[topic].messages, key=lambda m: np.linalg.norm(velocity(m)))
        assert velocity(fastest) == pytest.approx([0.9375, 0.0, 0.0], abs=0.06)
        moved = position(tilted[topic].messages[-1])
        along = np.array([math.cos(PITCH), 0.0, -math.sin(PITCH)])
        assert moved == pytest.approx(DISTANCE * along, abs=0.05 * DISTANCE)


def test_truth_and_estimate_agree_along_the_way(tilted):
    truth = {stamp_ns(message): message for message in tilted['ground_truth/odom'].messages}
    for message in tilted['odom'].messages:
        beside = truth[stamp_ns(message)]
        assert position(message) == pytest.approx(position(beside), abs=0.05 * DISTANCE)


def test_topics_follow_the_namespace(tilted):
    names = {*TOPICS, 'stationary'}
    assert {f'/robot/{name}' for name in names} <= tilted.topics
    assert not {f'/{name}' for name in names} & tilted.topics
    assert '/diagnostics' in tilted.topics


def test_the_other_executor_does_as_well(ros):
    recordings = slide(ros, {**SLIDE, 'common.executor': 'single'})
    end = position(recordings['odom'].messages[-1])
    assert end == pytest.approx([DISTANCE, 0.0, 0.0], abs=0.05 * DISTANCE)


def test_best_effort_publishers_can_be_had(ros):
    """qos_overrides of a YAML file take effect: a reliable subscriber then gets nothing."""
    ros.start(
        'accelerometer_driver',
        {'qos_overrides./imu/data_raw.publisher.reliability': 'best_effort'},
    )
    heard = ros.record('imu/data_raw', Imu, BEST_EFFORT)
    reliable = ros.record('imu/data_raw', Imu, RELIABLE)
    truth = ros.record('ground_truth/odom', Odometry, RELIABLE)
    heard.wait(20)
    truth.wait(20)
    (publisher,) = ros.node.get_publishers_info_by_topic('/imu/data_raw')
    assert publisher.qos_profile.reliability.name == 'BEST_EFFORT'
    assert len(reliable) == 0


def test_a_remapped_topic_is_the_one_that_counts(ros):
    """The driver waits for subscribers of the topic it does publish."""
    ros.start(
        'accelerometer_driver',
        {'driver.wait_for_subscribers': 1},
        *('-r', 'imu/data_raw:=/sensors/imu'),
    )
    recording = ros.record('/sensors/imu', Imu).connected()
    assert recording.wait(20)[0].header.frame_id == 'imu_link'
