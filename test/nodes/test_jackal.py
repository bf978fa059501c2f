"""A recorded robot with its wheel odometry over DDS, where the recordings are."""

import os
from pathlib import Path

import numpy as np
import pytest
from nav_msgs.msg import Odometry
from ros_harness import DEEP, figures, lossless
from sensor_msgs.msg import Imu

from benchmarks.accuracy import jackal
from benchmarks.accuracy.aided import parameters
from benchmarks.accuracy.played import played
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import matrix_from_quaternion
from dead_reckoning.core.stages import AIDING_ODOMETRY, IMU, ODOMETRY
from dead_reckoning.sources.bags import read_imu
from dead_reckoning.topics import topics

DATA = os.environ.get('DEAD_RECKONING_DATA', '')
BAG = Path(DATA) / 'robot_bags/jackal_test2.bag'
BATCH = 25
"""Samples, half a second, that are sent before it is seen that they were taken."""

pytestmark = pytest.mark.skipif(
    not (DATA and BAG.exists()),
    reason='DEAD_RECKONING_DATA names no folder with robot_bags/jackal_test2.bag',
)


@pytest.mark.parametrize('node', ['inertial_navigator', 'pipeline'])
def test_wheels_aid_a_node_as_they_aid_the_chain(ros, node):
    messages = played(BAG, {IMU: jackal.TOPIC, AIDING_ODOMETRY: jackal.WHEELS})
    settings = parameters({})
    chain = Pipeline(Configuration(settings))
    spoken = topics(FrameSettings())
    reliable = lossless(jackal.TOPIC, jackal.WHEELS, '/odom')
    ros.start(node, {**settings, **reliable}, '-r', f'{AIDING_ODOMETRY}:={jackal.WHEELS}')
    odometry = ros.record('odom', Odometry, DEEP, raw=True).connected()
    said = ros.diagnostics()
    publishers = {
        IMU: ros.publisher(jackal.TOPIC, Imu),
        AIDING_ODOMETRY: ros.publisher(jackal.WHEELS, Odometry),
    }
    last_aid = max(k for k, (_, name, _) in enumerate(messages) if name == AIDING_ODOMETRY)
    states, counts = [], {IMU: 0, AIDING_ODOMETRY: 0}

    def catch_up():
        ros.until(lambda: len(odometry.messages) == len(states), f'{len(states)} odometries')

    def taken(status):
        told = figures(status)
        return int(told['aiding_odom']) + int(told['aiding_odom_refused'])

    for number, (_, name, data) in enumerate(messages):
        first = name == AIDING_ODOMETRY and not counts[name]
        if first:
            catch_up()
        publishers[name].publish(data)
        outputs = chain.chain.push(name, spoken[name].decode(data))
        states += [value for made, value in outputs if made == ODOMETRY]
        counts[name] += 1
        if first:
            ros.for_seconds(0.3)  # it keeps what it takes from now on
        if number == last_aid + BATCH:  # those of its look-ahead are taken, too
            aids = counts[AIDING_ODOMETRY]
            said.until(node, lambda s, aids=aids: taken(s) == aids, f'{aids} wheel odometries')
        if counts[IMU] % BATCH == 0:
            catch_up()
    catch_up()

    assert counts[IMU] == 3061
    assert counts[AIDING_ODOMETRY] > 2900
    assert bytes(odometry.messages[-1]) == spoken[ODOMETRY].encode(states[-1])
    assert chain.navigator.counts['aiding_odom'] > 2000, 'most of them are believed'
    assert np.linalg.norm(states[-1].velocity) < 0.05, 'it stands in the end'
    imu = next(one for one in read_imu(BAG, jackal.TOPIC) if one.stamp_ns == states[-1].stamp_ns)
    up, found = (matrix_from_quaternion(q)[6:] for q in (imu.orientation, states[-1].attitude))
    assert np.degrees(np.arccos(np.dot(up, found))) < 3.0
