"""The pedometer over DDS: totals, the way, services; alone, behind a driver, in the pipeline."""

import itertools
import math
import os
import random
import signal
from pathlib import Path

import numpy as np
import pytest
from messages import GRAVITY, NANOSECONDS, START_NS, imu_message
from nav_msgs.msg import Odometry
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message
from ros_harness import DEEP, EXECUTORS, LATCHED, RELIABLE, figures, lossless, stamp_ns
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64, UInt32
from std_srvs.srv import SetBool, Trigger

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.pedometer import Totals
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.stages import PEDOMETER_OUTPUTS
from dead_reckoning.nodes.totals_file import decode

RATE = 100
YAW = 0.7
LEVEL = (0.0, 0.0, math.sin(YAW / 2.0), math.cos(YAW / 2.0))
STEPS, DISTANCE, LENGTH, CADENCE, ODOM = PEDOMETER_OUTPUTS
TYPES = {STEPS: UInt32, DISTANCE: Float64, LENGTH: Float64, CADENCE: Float64, ODOM: Odometry}
ALL_OF_IT = QoSProfile(depth=DEEP, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
AN900 = Path(__file__).parents[2] / 'config' / 'an900.yaml'


def walk(steps, start_ns=START_NS, orientation=None, cadence=1.8, rest=3.0):
    """Return messages of a rest, a walk and a rest."""
    quiet = np.full(round(rest * RATE), GRAVITY)
    turn = 2.0 * np.pi * cadence * np.arange(round(RATE * steps / cadence)) / RATE
    walked = GRAVITY - 2.5 * np.sin(turn) + 0.8 * np.sin(2.0 * turn)
    forces = np.concatenate([quiet, walked, quiet])
    return [
        imu_message(start_ns + k * NANOSECONDS // RATE, (0.1, -0.2, force), orientation)
        for k, force in enumerate(forces)
    ]


class Walker:
    """A node that counts, fed by the test, and all that it published."""

    def __init__(self, ros, executor='events', topic='imu/data_raw', name='pedometer', **settings):
        self.ros = ros
        self.name = name
        topics = (topic, 'compass/data', *TYPES)
        parameters = {key.replace('__', '.'): value for key, value in settings.items()}
        self.process = ros.start(
            name,
            {
                **lossless(*(f'/{each}' for each in topics)),
                'common.executor': executor,
                'pedometer.input': topic,
                **parameters,
            },
        )
        self.recordings = {
            each: ros.record(each, kind, RELIABLE if each == ODOM else ALL_OF_IT).connected()
            for each, kind in TYPES.items()
        }
        self.publisher = ros.publisher(topic, Imu)
        self.stamp_ns = START_NS

    def walk(self, steps, **how):
        """Send a walk; the next one begins long after it."""
        messages = walk(steps, self.stamp_ns, **how)
        self.send(messages)
        return messages

    def send(self, messages):
        for number, message in enumerate(messages):
            self.publisher.publish(message)
            if number % 10 == 0:
                self.ros.spin(0.001)
        self.stamp_ns = stamp_ns(messages[-1]) + 100 * NANOSECONDS

    def values(self, topic):
        return [message.data for message in self.recordings[topic].messages]

    def wait(self, steps):
        """Wait for a number of steps, and the distance that belongs to it."""

        def complete():
            counted, walked = self.values(STEPS), self.values(DISTANCE)
            return counted[-1:] == [steps] and len(counted) == len(walked)

        self.ros.until(complete, f'{steps} steps')

    def wait_for_rest(self):
        """Wait for the end of a walk."""
        said = self.recordings[CADENCE]
        self.ros.until(lambda: len(said) > 1 and said.messages[-1].data == 0.0, 'the end')

    def calibrate(self, walking):
        service = 'calibrate' if self.name == 'pedometer' else 'pedometer/calibrate'
        return self.ros.call(SetBool, f'{self.name}/{service}', SetBool.Request(data=walking))


@pytest.fixture(params=EXECUTORS)
def executor(request):
    return request.param


def test_totals_come_on_change_and_stay_for_those_who_come_late(ros, executor):
    walker = Walker(ros, executor)
    walker.walk(12)
    walker.wait(12)
    walker.wait_for_rest()
    assert walker.values(STEPS) == list(range(13))
    distances = walker.values(DISTANCE)
    assert distances == sorted(set(distances))
    assert walker.values(LENGTH)[-1] == pytest.approx(distances[-1] - distances[-2])
    assert max(walker.values(CADENCE)) == pytest.approx(1.8, rel=0.1)
    late = {topic: ros.record(topic, TYPES[topic], LATCHED) for topic in (STEPS, DISTANCE)}
    # Queues that lose nothing keep older values for them, too.
    for topic, value in ((STEPS, 12), (DISTANCE, distances[-1])):
        ros.until(
            lambda topic=topic, value=value: (
                late[topic].messages and late[topic].messages[-1].data == value
            ),
            f'{value} on {topic}',
        )
    assert len(walker.recordings[ODOM]) == 0, 'no heading'


def test_steps_lead_along_the_orientation(ros, executor):
    walker = Walker(ros, executor, 'imu/data')
    walker.walk(12, orientation=LEVEL)
    walker.wait(12)
    message = walker.recordings[ODOM].wait(12)[-1]
    point, turned = message.pose.pose.position, message.pose.pose.orientation
    assert message.header.frame_id == 'odom'
    assert message.child_frame_id == 'base_link'
    assert math.hypot(point.x, point.y) == pytest.approx(walker.values(DISTANCE)[-1])
    assert math.atan2(point.y, point.x) == pytest.approx(YAW)
    assert 2.0 * math.atan2(turned.z, turned.w) == pytest.approx(YAW)
    linear = message.twist.twist.linear
    assert linear.x == pytest.approx(walker.values(LENGTH)[-1] * 1.8, rel=0.05)
    assert linear.y == pytest.approx(0.0, abs=1e-9)
    covariance = np.reshape(message.pose.covariance, (6, 6))
    assert covariance[2, 2] == 1e6, 'height is not measured'
    assert 0.0 < covariance[0, 0] < 10.0


def test_steps_lead_along_the_compass(ros, executor):
    walker = Walker(ros, executor)
    compass = ros.publisher('compass/data', Imu)
    messages = walk(12)
    for message in messages[::5]:
        north = imu_message(stamp_ns(message), (0.0, 0.0, 0.0), (0.0, 0.0, 0.5**0.5, 0.5**0.5))
        north.linear_acceleration_covariance[0] = -1.0
        compass.publish(north)
        ros.spin(0.001)
    walker.send(messages)
    walker.wait(12)
    point = walker.recordings[ODOM].wait(12)[-1].pose.pose.position
    assert (point.x, point.y) == pytest.approx((0.0, walker.values(DISTANCE)[-1]), abs=1e-6)


def test_steps_lead_along_a_navigator(ros):
    settings = {'pedometer.heading': 'navigator'}
    walker = Walker(ros, **settings, **lossless('/odom'))
    odom = ros.publisher('odom', Odometry)
    messages = walk(12)
    for message in messages[::5]:
        state = Odometry(header=message.header)
        state.pose.pose.orientation.z, state.pose.pose.orientation.w = LEVEL[2:]
        state.pose.covariance[35] = 0.04
        odom.publish(state)
        ros.spin(0.001)
    walker.send(messages)
    walker.wait(12)
    pose = walker.recordings[ODOM].wait(12)[-1].pose
    assert math.atan2(pose.pose.position.y, pose.pose.position.x) == pytest.approx(YAW)
    assert pose.covariance[35] == pytest.approx(0.04 + 0.1**2)


def test_navigator_that_gives_nothing_is_missed(ros):
    walker = Walker(ros, **{'pedometer.heading': 'navigator', 'common.input_timeout': 0.2})
    diagnostics = ros.diagnostics()
    walker.walk(6)
    shown = diagnostics.until('pedometer', lambda s: 'SilentInputError' in figures(s), 'silence')
    assert 'nothing on /odom so far' in shown.message
    assert 'start inertial_navigator' in shown.message


def test_start_stop_and_reset(ros, executor):
    walker = Walker(ros, executor, 'imu/data')
    walker.walk(6, orientation=LEVEL)
    walker.wait(6)
    answer = ros.trigger('pedometer/stop')
    assert (answer.success, answer.message) == (True, 'stopped: the totals are held')
    walker.walk(6, orientation=LEVEL)
    answer = ros.trigger('pedometer/start')
    assert (answer.success, answer.message) == (True, 'counting from zero')
    walker.wait(0)
    assert max(walker.values(STEPS)) == 6, 'nothing was counted while it stood'
    walker.walk(8, orientation=LEVEL)
    walker.wait(8)
    point = walker.recordings[ODOM].wait(14)[-1].pose.pose.position
    assert math.hypot(point.x, point.y) == pytest.approx(walker.values(DISTANCE)[-1])
    answer = ros.trigger('pedometer/reset')
    assert (answer.success, answer.message) == (True, 'steps and distance are zero')
    walker.wait(0)
    assert walker.values(DISTANCE)[-1] == 0.0


def test_steps_that_a_stop_brings_are_walked_too(ros):
    walker = Walker(ros, topic='imu/data')
    messages = walk(12, orientation=LEVEL)
    walker.send(messages[: RATE * 7])  # in a step, of which there are 7
    ros.until(lambda: walker.values(STEPS)[-1:] > [4], 'some steps')
    assert ros.trigger('pedometer/stop').success
    point = walker.recordings[ODOM].wait(walker.values(STEPS)[-1])[-1].pose.pose.position
    assert math.hypot(point.x, point.y) == pytest.approx(walker.values(DISTANCE)[-1])


def test_calibration_sets_k(ros, executor):
    walker = Walker(ros, executor, pedometer__calibration_distance=9.0)
    answer = walker.calibrate(False)
    assert not answer.success
    assert 'no calibration was begun' in answer.message
    answer = walker.calibrate(True)
    assert answer.success
    assert answer.message == 'walk 9 m, then call this with false'
    answer = walker.calibrate(False)
    assert not answer.success
    assert '0 steps since the start' in answer.message
    walker.walk(12)
    walker.wait(12)
    (before,) = ros.get('pedometer', 'pedometer.k')
    expected = before * 9.0 / walker.values(DISTANCE)[-1]
    answer = walker.calibrate(False)
    assert answer.success, answer.message
    assert answer.message.startswith(f'pedometer.k is {expected:.4f} √m: 12 steps over 9 m')
    assert ros.get('pedometer', 'pedometer.k') == [pytest.approx(expected)]
    ros.trigger('pedometer/reset')
    walker.wait(0)
    walker.walk(12)
    walker.wait(12)
    assert walker.values(DISTANCE)[-1] == pytest.approx(9.0)


def test_settings_of_pedometer_and_method_change_while_it_runs(ros):
    walker = Walker(ros, pedometer__length_model='constant')
    assert ros.get('pedometer', 'pedometer.k') == [0.7]
    (result,) = ros.set('pedometer', pedometer__k=2)
    assert result.successful
    (result,) = ros.set('pedometer', pedometer__rhythm__rise=50.0)
    assert result.successful
    walker.walk(6)
    walker.wait(0)
    (result,) = ros.set('pedometer', pedometer__rhythm__rise=0.25)
    assert result.successful
    walker.walk(6)
    walker.wait(6)
    assert walker.values(DISTANCE)[-1] == 12.0
    (result,) = ros.set('pedometer', pedometer__shortest_step=3.0)
    assert not result.successful
    assert 'pedometer.longest_step: 2 s is not longer' in result.reason
    (result,) = ros.set('pedometer', pedometer__axes=['x'])
    assert not result.successful


def test_faults_are_counted_and_said(ros):
    walker = Walker(ros)
    diagnostics = ros.diagnostics()
    messages = walk(6)
    messages[500].linear_acceleration.y = math.nan
    messages.insert(550, messages[520])
    messages.insert(560, messages[558])
    walker.send(messages)
    walker.wait(6)

    def counted(status):
        shown = figures(status)
        names = ('NotFiniteError', 'LateSampleError', 'RepeatedStampError')
        return all(shown.get(name) == '1' for name in names)

    shown = figures(diagnostics.until('pedometer', counted, 'one fault of each kind'))
    assert shown['steps'] == '6'
    assert shown['counting'] == 'yes'
    assert shown['k'].endswith('√m')


def test_an900_counts_the_walk_of_its_simulated_sensor(ros):
    """Driver and pedometer in the time of the wall, both from the committed file."""
    file = ('--params-file', str(AN900))
    ros.start('pedometer', None, *file)
    steps = ros.record(STEPS, UInt32, ALL_OF_IT).connected()
    distance = ros.record(DISTANCE, Float64, ALL_OF_IT).connected()
    shorter = {'walk.steps': 10, 'walk.cadence': 2.2, 'walk.start': 1.0, 'wait_for_subscribers': 2}
    changes = [word for key, value in shorter.items() for word in ('-p', f'driver.{key}:={value}')]
    ros.start('accelerometer_driver', None, *file, *changes)
    raw = ros.record('imu/data_raw', Imu)
    raw.wait(30 * 8)
    ros.until(lambda: len(steps) > 10 and len(distance) > 10, 'ten steps')
    assert [message.data for message in steps.messages] == list(range(11))
    assert distance.messages[-1].data == pytest.approx(7.0, rel=0.12)
    assert np.diff(raw.stamps).mean() == pytest.approx(NANOSECONDS / 30, rel=1e-3)


def test_pipeline_counts_beside_the_integrator_and_like_the_chain(ros, executor):
    settings = {
        'pipeline.estimators': ['integrator', 'pedometer'],
        'pedometer.heading': 'orientation',
        'pedometer.calibration_distance': 9.0,
    }
    with_dots = {key.replace('.', '__'): value for key, value in settings.items()}
    walker = Walker(ros, executor, 'imu/data_raw', 'pipeline', **with_dots)
    odom = ros.record('odom', Odometry).connected()
    assert walker.calibrate(True).success
    messages = walker.walk(12)
    walker.wait(12)
    walker.wait_for_rest()
    chain = Pipeline(Configuration(settings)).chain
    expected = {}
    for message in messages:
        for name, value in chain.push(
            'imu/data_raw', wire.decode_imu(bytes(serialize_message(message)))
        ):
            expected.setdefault(name, []).append(value)
    for topic in (STEPS, DISTANCE, LENGTH, CADENCE):
        assert walker.values(topic) == expected[topic]
    assert len(odom.wait(100)) >= 100
    assert '12 steps over 9 m' in walker.calibrate(False).message
    answer = ros.trigger('pipeline/reset')
    assert answer.success
    assert answer.message.endswith('steps and distance are zero')
    walker.wait(0)
    assert ros.trigger('pipeline/stop').success
    assert ros.trigger('pipeline/start').success


# Totals that outlast the node ------------------------------------------------------------------


def kept(path):
    return decode(path.read_bytes())


@pytest.fixture
def slow_disk(tmp_path, monkeypatch):
    """A disk that takes far longer than a node waits for it."""
    code = 'plain = os.fsync\nos.fsync = lambda file: time.sleep(0.2) or plain(file)\n'
    (tmp_path / 'sitecustomize.py').write_text(f'import os, time\n{code}')
    path = os.pathsep.join([str(tmp_path), os.environ.get('PYTHONPATH', '')])
    monkeypatch.setenv('PYTHONPATH', path)


def test_totals_outlast_a_killed_node(ros, executor, tmp_path):
    path = tmp_path / 'totals'
    walker = Walker(ros, executor, pedometer__state_file=str(path))
    walker.walk(6)
    walker.wait(6)
    before = kept(path)
    assert (before.steps, before.distance) == (6, walker.values(DISTANCE)[-1])
    walker.process.end(signal.SIGKILL)
    again = Walker(ros, executor, pedometer__state_file=str(path))
    again.wait(6)  # before it has taken a sample
    assert again.values(DISTANCE) == [before.distance]
    assert again.recordings[LENGTH].wait(1)[0].data == before.step_length
    reset(ros)
    again.wait(0)
    assert kept(path) == Totals()


def reset(ros):
    """Have the totals cleared; what was killed looks alive for a while, and answers nothing."""
    asked, asks = [], itertools.count()

    def answered():
        if next(asks) % 100 == 0:
            asked.append(ros.ask(Trigger, 'pedometer/reset', Trigger.Request()))
        return any(answer.done() for answer in asked)

    ros.until(answered, 'an answer of the node that lives')


def test_totals_outlast_a_pipeline_that_is_told_to_end(ros, tmp_path):
    path = tmp_path / 'totals'
    settings = {'pipeline.estimators': ['pedometer'], 'pedometer.state_file': str(path)}
    walker = Walker(ros, 'events', 'imu/data_raw', 'pipeline', **settings)
    walker.walk(6)
    walker.wait(6)
    assert walker.process.end(signal.SIGTERM) == 0
    assert kept(path).steps == 6
    steps = ros.record(STEPS, UInt32, LATCHED)
    ros.start('pipeline', settings)
    assert steps.wait(1)[0].data == 6


@pytest.mark.parametrize('disk', ['quick', 'slow'])
def test_node_killed_at_any_moment_of_a_walk_loses_no_step_that_it_said(
    ros, tmp_path, request, disk
):
    if disk == 'slow':
        request.getfixturevalue('slow_disk')
    chance, path = random.Random(3), tmp_path / 'totals'
    publisher = ros.node.create_publisher(Imu, 'imu/data_raw', RELIABLE)
    endless = itertools.count()

    def walk_on():
        for number in itertools.islice(endless, 10):
            force = GRAVITY - 2.5 * math.sin(2.0 * math.pi * 1.8 * number / RATE)
            stamp = START_NS + number * NANOSECONDS // RATE
            publisher.publish(imu_message(stamp, (0.1, -0.2, force)))

    total = 0
    for _ in range(6):
        steps = ros.record(STEPS, UInt32, ALL_OF_IT)
        node = ros.start('pedometer', {'pedometer.state_file': str(path)})
        assert steps.wait(1)[0].data == total
        more = total + chance.randint(5, 40)

        def walked(steps=steps, more=more):
            walk_on()
            return steps.messages[-1].data >= more

        ros.until(walked, f'{more} steps', patience=0.001)
        node.end(signal.SIGKILL)
        ros.for_seconds(0.1)  # what is on its way
        total = kept(path).steps
        assert total >= steps.messages[-1].data
        steps.stop()
    assert not list(tmp_path.glob('*damaged*'))


def test_damaged_totals_are_set_aside_with_a_word(ros, tmp_path):
    path = tmp_path / 'totals'
    path.write_text('{"steps": 12')
    diagnostics = ros.diagnostics()
    walker = Walker(ros, pedometer__state_file=str(path))
    walker.wait(0)
    aside = tmp_path / 'totals.damaged1'
    assert aside.read_text() == '{"steps": 12'
    assert f'counting from zero, the file is {aside} now' in walker.process.stderr
    diagnostics.until('pedometer', lambda s: figures(s).get('DamagedStateError') == '1', 'that')


def test_file_of_another_node_and_one_that_can_not_be_kept_end_the_node(ros, tmp_path):
    path = tmp_path / 'totals'
    Walker(ros, pedometer__state_file=str(path))
    for wrong, why in ((path, 'another node keeps'), (tmp_path / 'no' / 'totals', 'No such file')):
        second = ros.start(
            'pedometer', {'pedometer.state_file': str(wrong)}, '-r', '__node:=other'
        )
        assert second.wait() == 2
        assert f"pedometer.state_file: '{wrong}' can not be kept" in second.stderr
        assert why in second.stderr


def test_disk_that_fails_later_is_said_once_while_counting_goes_on(ros, tmp_path):
    folder = tmp_path / 'kept'
    folder.mkdir()
    walker = Walker(ros, pedometer__state_file=str(folder / 'totals'))
    walker.wait(0)
    diagnostics = ros.diagnostics()
    folder.rename(tmp_path / 'gone')
    walker.walk(6)
    walker.wait(6)
    shown = diagnostics.until('pedometer', lambda s: 'StateFileError' in figures(s), 'failure')
    assert shown.level == shown.ERROR
    assert figures(shown)['StateFileError'] == '1'
    (tmp_path / 'gone').rename(folder)
    walker.walk(6)
    walker.wait(12)
    ros.until(lambda: 'StateFileError is over' in walker.process.stderr, 'the end of it')
    assert walker.process.stderr.count('can not be written') == 1
    assert kept(folder / 'totals').steps == 12


def test_calibrate_is_a_switch(ros):
    Walker(ros)
    kinds = {'start': 'Trigger', 'stop': 'Trigger', 'reset': 'Trigger', 'calibrate': 'SetBool'}
    expected = {f'/pedometer/{name}': [f'std_srvs/srv/{kinds[name]}'] for name in kinds}
    ros.until(
        lambda: expected.items() <= dict(ros.node.get_service_names_and_types()).items(),
        f'{expected}',
    )
