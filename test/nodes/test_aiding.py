"""Aiding over DDS: as in the chain, its switches, its refusals; smoothing and path; the Jackal."""

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistWithCovarianceStamped
from messages import NANOSECONDS, START_NS, stamped
from moving_state import LEVEL_WALK
from nav_msgs.msg import Odometry, Path
from rclpy.serialization import serialize_message
from replays import odometry_of_all
from ros_harness import DEEP, LATCHED, figures, lossless
from sensor_msgs.msg import Imu
from simulated_walks import measured

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.stages import (
    AIDING_POSE,
    AIDING_TWIST,
    ODOMETRY,
    PATH,
    RAW,
    SET_POSE,
    SMOOTHED,
)
from dead_reckoning.topics import topics

BLOCK = measured(LEVEL_WALK, 1).block(START_NS)
SETTINGS = {'pipeline.estimators': ['inertial_navigator'], 'navigator.look_ahead': 0.0}
TOPICS = {'imu/data_raw', 'odom', 'odom_smoothed', 'aiding/twist', 'aiding/pose', 'set_pose'}


def twist(stamp_ns, velocity, variance=1e-3, frame_id='odom'):
    message = stamped(TwistWithCovarianceStamped(), stamp_ns, frame_id)
    linear = message.twist.twist.linear
    linear.x, linear.y, linear.z = map(float, velocity)
    message.twist.covariance[[0, 7, 14]] = variance
    return message


def pose(stamp_ns, position, variance=1e-2, frame_id='odom'):
    message = stamped(PoseWithCovarianceStamped(), stamp_ns, frame_id)
    at = message.pose.pose.position
    at.x, at.y, at.z = map(float, position)
    message.pose.covariance[[0, 7, 14]] = variance
    message.pose.covariance[[21, 28, 35]] = 1e6
    return message


class Walker:
    """Sends a walk to a node, and to the chain that is in it."""

    def __init__(self, ros, node='inertial_navigator', **settings):
        self.settings = {**SETTINGS, **settings}
        ros.start(node, {**self.settings, **lossless(*[f'/{topic}' for topic in TOPICS])})
        self.ros, self.node = ros, node
        self.chain = Pipeline(Configuration(self.settings)).chain
        self.spoken = topics(FrameSettings())
        self.odom = ros.record('odom', Odometry, DEEP, raw=True).connected()
        self.said = ros.diagnostics()
        self.imu = ros.publisher(RAW, Imu)
        self.publishers = {}
        self.outputs = []
        self.messages = []
        """All that was sent, with the names of the topics."""
        self.sent = 0

    def send(self, name, message):
        """Send a message, to the chain too."""
        if name not in self.publishers:
            self.publishers[name] = self.ros.publisher(name, type(message))
        self.publishers[name].publish(message)
        data = bytes(serialize_message(message))
        self.messages.append((name, data))
        self.outputs += self.chain.push(name, self.spoken[name].decode(data))

    def walk(self, count):
        """Send so many samples more, and wait for the odometry of the last."""
        for index in range(self.sent, self.sent + count):
            sample = BLOCK.sample(index)
            data = wire.encode_imu(sample)
            self.imu.publish(data)
            self.messages.append((RAW, data))
            self.outputs += self.chain.push(RAW, sample)
        self.sent += count
        stamp = wire.encode_imu(BLOCK.sample(self.sent - 1))[4:12]
        self.ros.until(
            lambda: self.odom.messages and bytes(self.odom.messages[-1][4:12]) == stamp,
            'the odometry of the last sample',
        )

    def all_taken(self, name, count):
        """Wait until the node has taken or refused so many measurements of a name."""
        node = self.node
        return figures(
            self.said.until(
                node,
                lambda s: int(figures(s)[name]) + int(figures(s)[f'{name}_refused']) == count,
                f'{count} of {name}',
            )
        )

    def same(self):
        """Say whether the last odometry is that of the chain, to the last bit."""
        state = [value for name, value in self.outputs if name == ODOMETRY][-1]
        return bytes(self.odom.messages[-1]) == self.spoken[ODOMETRY].encode(state)


def at(index):
    return int(BLOCK.stamp_ns[index])


@pytest.mark.parametrize('node', ['inertial_navigator', 'pipeline'])
def test_node_takes_what_aids_it_as_chain_and_replay_do(ros, tmp_path, node):
    """However topics overtake each other: what is late is taken at its stamp, bit for bit."""
    walker = Walker(ros, node)
    walker.walk(200)
    walker.send(AIDING_TWIST, twist(at(210), LEVEL_WALK.velocity[210]))  # it keeps from now on
    walker.send(AIDING_POSE, pose(at(215), LEVEL_WALK.position[215]))
    walker.ros.for_seconds(0.2)
    for k in range(4):
        walker.walk(75)
        for told in range(walker.sent - 60, walker.sent, 20):
            walker.send(AIDING_TWIST, twist(at(told), LEVEL_WALK.velocity[told]))
            walker.send(AIDING_POSE, pose(at(told + 3), LEVEL_WALK.position[told + 3]))
        walker.all_taken('aiding_twist', 1 + 3 * (k + 1))
        walker.all_taken('aiding_pose', 3 * (k + 1))
    walker.walk(20)
    assert walker.same()
    assert int(walker.all_taken('aiding_twist', 13)['placed']) == 1

    replayed = odometry_of_all(walker.messages, walker.settings, tmp_path)[-1]
    doubles, last = 8 * 85, bytes(walker.odom.messages[-1])
    assert replayed[:-doubles] == last[:-doubles]
    np.testing.assert_allclose(
        np.frombuffer(replayed[-doubles:]), np.frombuffer(last[-doubles:]), rtol=1e-9, atol=1e-9
    )


def test_switches_refusals_and_set_pose(ros):
    walker = Walker(ros)
    walker.walk(200)
    walker.send(AIDING_TWIST, twist(at(150), LEVEL_WALK.velocity[150]))
    walker.ros.for_seconds(0.2)  # nothing is kept yet: it is taken with the next sample
    walker.walk(5)
    walker.all_taken('aiding_twist', 1)
    (result,) = ros.set('inertial_navigator', navigator__aiding_twist=False)
    assert result.successful
    for variance, frame_id, stamp_ns, why in (
        (0.0, 'odom', at(200), 'each axis needs a variance above 0'),
        (1e-3, 'map', at(200), "'map'"),
        (1e-3, 'odom', at(200) - 2 * NANOSECONDS, 'behind the Imu'),
    ):
        walker.send(AIDING_POSE, pose(stamp_ns, (0.0, 0.0, 0.0), variance, frame_id))
        status = walker.said.until(
            'inertial_navigator', lambda s, why=why: why in s.message, f'why not: {why}'
        )
        assert int(figures(status)['placed']) == 0
        assert 'aiding/pose: ' in status.message
    status = figures(status)
    assert [status[f'{t}_dropped'] for t in ('aiding_pose', 'aiding_twist')] == ['3', '0']
    walker.send(AIDING_TWIST, twist(at(190), (9.0, 9.0, 9.0)))
    there = pose(0, (7.0, -3.0, 0.0))
    there.pose.covariance[[21, 28]] = 0.0
    there.pose.covariance[[14, 35]] = 0.0, 0.01
    there.pose.pose.orientation.z, there.pose.pose.orientation.w = np.sin(0.5), np.cos(0.5)
    walker.send(SET_POSE, there)
    status = walker.said.until(
        'inertial_navigator', lambda s: figures(s)['placed'] == '1', 'a pose that is set'
    )
    assert figures(status)['aiding_twist'] == '1'  # the second came when the switch was off
    walker.walk(2)
    state = wire.decode_odometry(bytes(walker.odom.messages[-1]))
    assert state.position[:2] == pytest.approx((7.0, -3.0), abs=0.2)


def test_smoothing_gives_each_state_again_and_a_path(ros):
    walker = Walker(ros, **{'navigator.smoothing': True})
    smoothed = ros.record(SMOOTHED, Odometry, DEEP, raw=True).connected()
    walker.walk(1400)
    spoken = walker.spoken[SMOOTHED]
    expected = [spoken.encode(value) for name, value in walker.outputs if name == SMOOTHED]
    assert len(expected) > 800
    ros.until(lambda: len(smoothed.messages) == len(expected), 'all smoothed states')
    assert [bytes(message) for message in smoothed.messages] == expected
    late = ros.record(PATH, Path, LATCHED)  # whoever comes late gets the last one
    (path,) = late.wait(1)
    poses = [value for name, value in walker.outputs if name == PATH][-1].poses
    assert len(path.poses) == len(poses) > 5
    assert path.header.frame_id == path.poses[0].header.frame_id == 'odom'
    end = path.poses[-1].pose.position
    assert (end.x, end.y, end.z) == poses[-1][1]
