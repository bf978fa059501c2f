"""The inertial navigator over DDS: a foot that walks, services, switches, what can go wrong."""

from dataclasses import replace
from itertools import count

import numpy as np
import pytest
from messages import GRAVITY, NANOSECONDS, START_NS, Feed, imu_message
from nav_msgs.msg import Odometry
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from replays import odometry_of
from ros_harness import DEEP, EXECUTORS, figures, latest_taken, lossless, taken
from sensor_msgs.msg import Imu
from simulated_walks import measured, walk
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Trigger

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import quaternion_from_euler, yaw_from_quaternion
from dead_reckoning.core.stages import ODOMETRY, RAW, STATIONARY, STATISTIC, THRESHOLD
from dead_reckoning.live import NavigatorChain
from dead_reckoning.topics import topics

WARM_UP_NS = START_NS + 1_000 * NANOSECONDS
"""Stamps before the real ones; the step back makes everything start anew."""
ESTIMATORS = {'pipeline.estimators': ['inertial_navigator']}
MOUNTED = {
    'frames.mounting_translation': [0.3, -0.1, 0.2],
    'frames.mounting_rotation': [1.0, 0.2, 0.5],
}
ALL_OF_IT = QoSProfile(depth=DEEP, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


@pytest.fixture(scope='module')
def messages():
    """A foot's walk as bytes, and what can go wrong between."""
    block = measured(walk(), seed=3).block(START_NS)
    samples = [block.sample(k) for k in range(1600)]
    samples[900] = replace(samples[900], specific_force=(float('nan'), 0.0, 0.0))
    samples[950] = replace(samples[950], angular_velocity=None)
    samples[1000] = replace(samples[1000], stamp_ns=samples[998].stamp_ns)
    samples[1100:1250] = []  # a gap
    return [wire.encode_imu(sample) for sample in samples]


def rest_message(stamp_ns, force=(0.0, 0.0, GRAVITY), rate=(0.0, 0.0, 0.0)):
    message = imu_message(stamp_ns, force)
    message.angular_velocity_covariance[0] = 0.0
    message.angular_velocity.x, message.angular_velocity.y, message.angular_velocity.z = rate
    return message


def resting(ros, topic='imu/data_raw', start_ns=WARM_UP_NS):
    """Return a feed of samples at rest."""
    publisher = ros.publisher(topic, Imu)
    return Feed(ros, lambda *sample: publisher.publish(rest_message(*sample)), 200.0, start_ns)


@pytest.mark.parametrize(
    ('name', 'executor'), [('inertial_navigator', 'events'), ('pipeline', 'single')]
)
def test_node_gives_what_the_chain_gives(ros, messages, name, executor):
    """Bit for bit: odom with the stamp of each Imu, rest on change, what the detector goes by."""
    settings = {**ESTIMATORS, **MOUNTED}
    given = {ODOMETRY: Odometry, STATIONARY: Bool, STATISTIC: Float64, THRESHOLD: Float64}
    full = [f'/{topic}' for topic in (RAW, *given)]
    ros.start(name, {**settings, **lossless(*full), 'common.executor': executor})
    configuration = Configuration(settings)
    spoken, direct = topics(configuration[FrameSettings]), Pipeline(configuration).chain
    recordings = {
        topic: ros.record(topic, kind, ALL_OF_IT if topic == STATIONARY else DEEP, raw=True)
        for topic, kind in given.items()
    }
    expected = {topic: [] for topic in given}
    feed = resting(ros)

    def push(data):
        for topic, value in direct.push(RAW, wire.decode_imu(data)):
            if topic in expected:
                expected[topic].append(spoken[topic].encode(value))

    feed.send_until(lambda: all(recordings.values()), 'all outputs')
    publisher = ros.node.create_publisher(Imu, RAW, DEEP)
    ros.until(lambda: publisher.get_subscription_count(), 'the node')
    for data in messages:
        publisher.publish(data)
        push(data)
    assert len(expected[ODOMETRY]) > 1200
    for topic, wanted in expected.items():
        if topic == STATIONARY:
            wanted = wanted[1:]  # it rested before, too
        recording = recordings[topic]
        ros.until(lambda r=recording, w=wanted: r.messages[-len(w) :] == w, f'all of {topic}')


@pytest.mark.parametrize(
    ('settings', 'compiled'),
    [
        ({**ESTIMATORS, **MOUNTED}, False),
        (ESTIMATORS, True),
        ({'pipeline.estimators': ['inertial_navigator', 'pedometer']}, True),
    ],
    ids=['mounted', 'compiled', 'compiled, pedometer'],
)
def test_live_and_replay_give_the_same_odometry(ros, messages, tmp_path, settings, compiled):
    if compiled:
        pytest.importorskip('numba')
        NavigatorChain.compile()  # so that it is kept, and the node finds it
    ros.start('pipeline', {**settings, **lossless('/imu/data_raw', '/odom')})
    live = ros.record('odom', Odometry, DEEP, raw=True).connected()
    said = ros.diagnostics()
    feed = resting(ros)
    feed.send_until(lambda: live.messages, 'odometry')
    if compiled:
        feed.send_until(lambda: taken(said) > 0, 'compiled code')
    before = latest_taken(ros, said) if compiled else 0
    publisher = ros.publisher(RAW, Imu)
    for message in messages:
        publisher.publish(message)

    replayed = odometry_of(RAW, messages, settings, tmp_path)
    # At the end of a recording there is no sample that lacks: a live node waits for more.
    pipeline = Pipeline(Configuration(settings))
    for message in messages:
        pipeline.chain.push(RAW, wire.decode_imu(message))
    held_back = [name for name, _ in pipeline.chain.end()].count(ODOMETRY)
    assert 5 < held_back < 10
    replayed = replayed[:-held_back]

    assert len(replayed) > 1200
    last = replayed[-1][:12]
    ros.until(lambda: live.messages[-1][:12] == last, 'the last odometry')
    published = live.messages[-len(replayed) :]
    doubles = 8 * 85
    assert [data[:-doubles] for data in published] == [data[:-doubles] for data in replayed]
    np.testing.assert_allclose(
        [np.frombuffer(data[-doubles:]) for data in replayed],
        [np.frombuffer(data[-doubles:]) for data in published],
        rtol=1e-9,
        atol=1e-9,
    )
    if compiled:
        assert latest_taken(ros, said) - before > 0.7 * len(messages)


@pytest.mark.parametrize('executor', EXECUTORS)
def test_reset_begins_at_the_origin(ros, executor):
    ros.start('inertial_navigator', {'common.executor': executor, **lossless('/imu/data_raw')})
    odom = ros.record('odom', Odometry, DEEP)
    diagnostics = ros.diagnostics()
    feed = resting(ros)
    feed.send_until(lambda: odom.messages, 'odometry')
    aligned = diagnostics.until(
        'inertial_navigator', lambda s: 'gravity is 9.806' in figures(s)['aligned'], 'alignment'
    )
    shown = figures(aligned)
    assert shown['strides'] == '0'
    assert {'statistic', 'threshold', 'zero_velocity', 'floor', 'gap'} <= shown.keys()
    assert float(shown['gyro_bias'].split(', ')[2]) == 0.0
    assert shown['accelerometer_bias'].count(',') == 2
    for _ in range(200):
        feed.send((0.0, 0.0, GRAVITY), (0.0, 0.0, 1.0))
    feed.send_until(lambda: abs(odom.messages[-1].pose.pose.orientation.z) > 0.3, 'a turn')
    answer = ros.trigger('inertial_navigator/reset')
    assert answer.success
    assert 'looking for rest' in answer.message
    feed.send_until(lambda: abs(odom.messages[-1].pose.pose.orientation.z) < 1e-3, 'yaw 0')


def test_an_imu_without_a_gyro_is_said(ros):
    ros.start('inertial_navigator')
    diagnostics = ros.diagnostics()
    publisher = ros.publisher('imu/data_raw', Imu)
    feed = Feed(ros, lambda ns: publisher.publish(imu_message(ns, (0.0, 0.0, GRAVITY))))
    feed.send_until(
        lambda: any(
            'measures no angular velocity' in status.message
            for status in diagnostics.of('inertial_navigator')
        ),
        'MissingRateError',
    )


def test_its_input_is_a_parameter(ros):
    ros.start('inertial_navigator', {'navigator.input': 'imu/data'})
    odom = ros.record('odom', Odometry)
    resting(ros, 'imu/data').send_until(lambda: odom.messages, 'odometry')


def test_two_that_give_odom_exclude_each_other(ros):
    node = ros.start('pipeline', {'pipeline.estimators': ['integrator', 'inertial_navigator']})
    assert node.wait() == 2
    assert 'integrator and inertial_navigator exclude each other' in node.stderr
    assert 'Traceback' not in node.stderr


def test_a_log_of_a_while_and_then_the_end(ros, tmp_path):
    log = tmp_path / 'log.csv'
    settings = {'pipeline.log_csv': str(log), 'pipeline.duration': 1.0}
    node = ros.start('pipeline', {**ESTIMATORS, **settings, **lossless('/imu/data_raw')})
    feed = resting(ros)
    feed.send_until(lambda: not node.running, 'its end')
    assert node.wait() == 0
    stamps = [int(line.split(',')[0]) for line in log.read_text().splitlines()[1:]]
    assert stamps[-1] - stamps[0] == NANOSECONDS


@pytest.mark.parametrize('executor', EXECUTORS)
def test_level_takes_tilt_gravity_and_bias_from_rest_and_keeps_the_place(ros, executor):
    ros.start('inertial_navigator', {'common.executor': executor, **lossless('/imu/data_raw')})
    odom = ros.record('odom', Odometry, DEEP)
    feed = resting(ros)
    feed.send_until(lambda: odom.messages, 'odometry')
    for bad in (True, False):
        answer = ros.client(Trigger, 'inertial_navigator/level').call_async(Trigger.Request())
        wave = count()

        def push(bad=bad, answer=answer, wave=wave):
            k = next(wave)
            feed.send((0.0, 0.0, GRAVITY), (0.1 * bad * (k % 2 - 0.5), 0.0, 0.001))
            return answer.done()

        ros.until(push, 'the answer', Feed.PATIENCE)
        assert answer.result().success is not bad, answer.result().message
    assert 'gravity is 9.8' in answer.result().message
    assert '0.057 °/s' in answer.result().message
    assert set(np.diff(odom.stamps)) == {NANOSECONDS // 200}, 'no sample was left out'


def test_updates_are_switched_while_it_runs(ros):
    ros.start('inertial_navigator', lossless('/imu/data_raw'))
    odom = ros.record('odom', Odometry, DEEP)
    diagnostics = ros.diagnostics()
    feed = resting(ros)
    feed.send_until(lambda: odom.messages, 'odometry')
    name = 'inertial_navigator'
    refused = ros.set_at_once(name, navigator__zero_velocity=False, navigator__window=1.0)
    assert not refused.successful
    assert ros.get(name, 'navigator.zero_velocity') == [True]
    switched = ros.set_at_once(name, navigator__zero_velocity=False, navigator__zero_rate=False)
    assert switched.successful, switched.reason
    seen = len(diagnostics.of(name))

    def counted():
        feed.send()
        return len(diagnostics.of(name)) > seen + 2

    ros.until(counted, 'diagnostics', Feed.PATIENCE)
    before, after = (figures(status) for status in diagnostics.of(name)[-2:])
    assert int(after['samples']) > int(before['samples']) + 10
    assert after['zero_velocity'] == before['zero_velocity'] != '0'
    assert after['zero_rate'] == before['zero_rate']


def test_a_compass_gives_the_yaw(ros):
    ros.start('inertial_navigator', lossless('/imu/data_raw', '/compass/data'))
    odom = ros.record('odom', Odometry, DEEP)
    compass = ros.publisher('compass/data', Imu)
    north = quaternion_from_euler(0.0, 0.0, 1.2)
    feed = resting(ros)

    def turned():
        for _ in range(10):
            feed.send()
        message = imu_message(feed.stamp_ns, (0.0, 0.0, 0.0), north)
        message.linear_acceleration_covariance[0] = -1.0
        compass.publish(message)
        if not odom.messages:
            return False
        q = odom.messages[-1].pose.pose.orientation
        return abs(yaw_from_quaternion((q.x, q.y, q.z, q.w)) - 1.2) < 0.01

    ros.until(turned, 'the yaw of the compass', Feed.PATIENCE)
