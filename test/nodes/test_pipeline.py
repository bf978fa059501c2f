"""The whole chain in one process: the same numbers as the chain itself, bit for bit."""

from pathlib import Path

import pytest
from messages import GRAVITY, NANOSECONDS, START_NS, Feed, imu_message, realistic_samples
from nav_msgs.msg import Odometry
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message
from ros_harness import DEEP, LATCHED, RELIABLE, lossless
from sensor_msgs.msg import Imu
from std_msgs.msg import UInt32

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.stages import gravity_input
from dead_reckoning.nodes.topics import message_class
from dead_reckoning.topics import topics

RATE = 200.0
TAKEN = {'rest': 'imu/data_raw', 'message': 'imu/data'}
GIVEN = {
    'rest': ['odom', 'imu/data', 'imu/linear_acceleration'],
    'message': ['odom', 'imu/linear_acceleration'],
}
ALL_OF_IT = QoSProfile(depth=DEEP, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
WARM_UP_NS = START_NS + 1_000 * NANOSECONDS
"""Stamps before the real ones; the step back makes everything start anew."""


@pytest.mark.parametrize(('attitude', 'executor'), [('rest', 'events'), ('message', 'single')])
def test_pipeline_over_dds_equals_the_chain_called_directly(ros, attitude, executor):
    taken, given = TAKEN[attitude], GIVEN[attitude]
    settings = {'gravity.attitude': attitude, 'integrator.window_maximum': 0.07}
    ros.start(
        'pipeline',
        {
            **settings,
            **lossless(*(f'/{topic}' for topic in [taken, *given, 'stationary'])),
            'pipeline.source': 'topic',
            'common.executor': executor,
        },
    )
    configuration = Configuration(settings)
    direct = Pipeline(configuration).chain
    assert gravity_input(attitude) == taken
    spoken = topics(configuration[FrameSettings])
    kinds = {name: message_class(topic) for name, topic in spoken.items()}
    recordings = {name: ros.record(name, kinds[name], raw=True).connected() for name in given}
    stationary = ros.record('stationary', kinds['stationary'], ALL_OF_IT, raw=True)
    publisher = ros.publisher(taken, Imu)
    expected = {topic: [] for topic in [*given, 'stationary']}

    def publish(message):
        publisher.publish(message)
        for topic, value in direct.push(taken, wire.decode_imu(serialize_message(message))):
            if topic in expected:
                expected[topic].append(spoken[topic].encode(value))

    # Until the first outputs arrive, some may be lost: what counts comes after.
    warm_up = Feed(
        ros,
        lambda stamp_ns: publish(imu_message(stamp_ns, (0, 0, GRAVITY), (0, 0, 0, 1))),
        RATE,
        WARM_UP_NS,
    )
    warm_up.send_until(lambda: stationary.messages and all(recordings.values()), 'outputs')
    before = {topic: len(outputs) for topic, outputs in expected.items()}
    for message in realistic_samples():
        publish(message)
    for topic in given:
        wanted = expected[topic][before[topic] :]
        assert len(wanted) > 300
        recording = recordings[topic]
        ros.until(lambda r=recording, w=wanted: w[-1] in r.messages, f'the last of {topic}')
        assert recording.messages[-len(wanted) :] == wanted
    assert len(expected['stationary']) >= 3
    assert stationary.wait(len(expected['stationary'])) == expected['stationary']


@pytest.fixture(scope='module')
def sliding(module_ros):
    """A pipeline with its own simulated sensor, over a slide."""
    ros = module_ros
    ros.start(
        'pipeline',
        {
            **lossless('/odom', '/ground_truth/odom'),
            'pipeline.source': 'simulated',
            'driver.wait_for_subscribers': 2,
            'driver.slide.start': 1.0,
        },
    )
    odom = ros.record('odom', Odometry).connected()
    truth = ros.record('ground_truth/odom', Odometry).connected()
    ros.record('imu/data_raw', Imu)
    truth.wait(1)
    ros.until(lambda: truth.stamps[-1] - truth.stamps[0] > 2.5e9, 'the end of the slide')
    ros.until(lambda: odom.stamps[-1] >= truth.stamps[0] + 2.5e9, 'the last odometry')
    return odom, truth


def test_pipeline_with_a_simulated_sensor_slides(sliding):
    odom, truth = sliding
    end = odom.messages[-1]
    assert truth.messages[-1].pose.pose.position.x == pytest.approx(0.5)
    assert end.pose.pose.position.x == pytest.approx(0.5, abs=0.025)
    assert end.pose.pose.position.y == pytest.approx(0.0, abs=0.025)
    assert end.pose.pose.position.z == pytest.approx(0.0, abs=0.025)
    assert end.header.frame_id == 'odom'
    assert end.child_frame_id == 'base_link'


@pytest.mark.parametrize('topic', ['imu/data_raw', 'imu/data', 'ground_truth/odom'])
def test_topics_between_come_while_someone_subscribes(module_ros, sliding, topic):
    odom, _ = sliding
    message = Odometry if topic == 'ground_truth/odom' else Imu
    for _ in range(2):
        recording = module_ros.record(topic, message, RELIABLE)
        first = recording.wait_next()
        assert first.header.frame_id in ('odom', 'imu_link')
        recording.wait(20)
        odom.wait_next()
        assert set(recording.stamps[5:-5]) <= set(odom.stamps)
        recording.stop()


def test_own_sensor_that_can_not_give_what_is_counted_on_is_refused(ros):
    file = Path(__file__).parents[2] / 'config' / 'pedestrian.yaml'
    settings = ('--params-file', str(file), '-p', 'pipeline.source:=simulated')
    node = ros.start('pipeline', None, *settings)
    assert node.wait() == 2
    assert 'gives imu/data_raw, and the estimators take imu/data;' in node.stderr
    ros.start('pipeline', None, *settings, '-p', 'pedometer.input:=imu/data_raw')
    assert ros.record('pedometer/steps', UInt32, LATCHED).wait(1)[0].data == 0


def test_a_log_of_a_while_and_then_the_end(ros, tmp_path):
    """The mbed page's program: 15 s into a file, and it ends by itself; here 1.5 s."""
    log = tmp_path / 'log.csv'
    node = ros.start(
        'pipeline',
        {'pipeline.source': 'simulated', 'pipeline.log_csv': str(log), 'pipeline.duration': 1.5},
    )
    assert node.wait() == 0
    stamps = [int(line.split(',')[0]) for line in log.read_text().splitlines()[1:]]
    assert (stamps[-1] - stamps[0]) / 1e9 == pytest.approx(1.5, abs=0.02)
    assert len(stamps) == 151
