"""Services answer when the work is done, with the reason when it failed, and starve nothing."""

import re

import numpy as np
import pytest
from geometry_msgs.msg import AccelWithCovarianceStamped
from messages import (
    GRAVITY,
    NANOSECONDS,
    START_NS,
    Feed,
    acceleration_message,
    clock_message,
    imu_message,
)
from nav_msgs.msg import Odometry
from ros_harness import EXECUTORS, Ros, lossless
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu
from std_srvs.srv import Trigger

DURATION = 1.5
"""How many seconds of samples a calibration or levelling takes here."""
STEP = 1 / 64
"""Time [s] from one tick of /clock to the next: four samples."""
SLACK = 2 * STEP
PERIOD_NS = NANOSECONDS // 256
OFFSET = [0.3, -0.2, 0.4]
LEVEL = (0.0, 0.0, 0.0, 1.0)


@pytest.fixture(params=EXECUTORS)
def busy(request, ros):
    """The three nodes, nothing lost, on an uncalibrated sensor at rest with 256 Hz."""
    parameters = {
        **lossless('/imu/data_raw', '/imu/data', '/imu/linear_acceleration', '/odom'),
        'common.executor': request.param,
        'driver.motion': 'rest',
        'driver.samples_per_message': 25,
        'driver.calibrate_on_start': False,
        'driver.simulated.offset': OFFSET,
        'driver.calibration_samples': round(DURATION * 6400.0),
        'gravity.rest_duration': DURATION,
        'integrator.calibration_duration': DURATION,
        'integrator.movement_end': 'off',
    }
    for name in ('integrator', 'gravity_removal'):
        ros.start(name, parameters)
    ros.start('accelerometer_driver', {**parameters, 'use_sim_time': True})
    return Busy(ros)


class Busy:
    """Calls services while samples come, which they do as /clock goes on, and that as is asked."""

    def __init__(self, ros):
        self._ros = ros
        self._raw = ros.record('imu/data_raw', Imu)
        self._odom = ros.record('odom', Odometry)
        self._clock = ros.publisher('/clock', Clock)
        self._now_ns = START_NS

        def flows():
            if not self._raw or self._is_measured():
                self._tick()
            return self._odom

        ros.until(flows, 'odom')

    def run(self, duration):
        """Let a time [s] go by, and all that is measured in it pass the nodes."""
        for _ in range(round(duration / STEP)):
            self._tick()
            self._ros.until(self._has_passed, 'odom of the last sample')

    def _tick(self):
        self._now_ns += round(STEP * NANOSECONDS)
        self._clock.publish(clock_message(self._now_ns))

    def _is_measured(self):
        self._clock.publish(clock_message(self._now_ns))  # a node may miss any
        return self._now_ns - self._raw.latest_stamp < PERIOD_NS

    def _has_passed(self):
        return self._is_measured() and self._odom.latest_stamp == self._raw.latest_stamp

    def trigger(self, name):
        """Call a service that takes `DURATION` of samples, not less and not more.

        A request ends the one before it, unless that has its answer already.  While the clock
        stands, this shows when a request was taken, and that it was not done too early.
        """
        client = self._ros.client(Trigger, name)

        def superseded(answer):
            self._ros.until(answer.done, f'the answer of {name}')
            return 'asked for again' in answer.result().message

        first, second = [client.call_async(Trigger.Request()) for _ in range(2)]
        assert superseded(first)
        self.run(DURATION - SLACK)
        third = client.call_async(Trigger.Request())
        assert superseded(second), 'it answers when the work is done'
        self.run(DURATION + SLACK)
        self._ros.until(third.done, f'the answer of {name}')
        assert set(np.diff(self._odom.stamps)) == {PERIOD_NS}, 'no sample was left out'
        return third.result()

    def distance(self):
        """Return how far from the origin [m] the last odometry is."""
        point = self._odom.messages[-1].pose.pose.position
        return np.linalg.norm([point.x, point.y, point.z])

    def force(self):
        """Return the specific force [m/s²] of the next quarter of a second."""
        self.run(0.25)
        recent = [message.linear_acceleration for message in self._raw.messages[-64:]]
        return np.mean([[f.x, f.y, f.z] for f in recent], axis=0)


def test_calibration_levelling_and_reset_work_and_starve_nothing(ros, busy):
    """In the order in which a user would: sensor, attitude, integrator, origin."""
    assert busy.force() == pytest.approx([OFFSET[0], OFFSET[1], GRAVITY + OFFSET[2]], abs=0.1)

    answer = busy.trigger('accelerometer_driver/calibrate')
    assert answer.success, answer.message
    offsets = re.findall(r'[+-]0\.\d+', answer.message)
    assert [float(offset) * GRAVITY for offset in offsets] == pytest.approx(OFFSET, abs=0.1)
    assert answer.message.startswith('offset of x, y, z: ')
    assert 'level again' in answer.message
    assert busy.force() == pytest.approx([0.0, 0.0, GRAVITY], abs=0.02)

    answer = busy.trigger('gravity_removal/level')
    assert answer.success, answer.message
    assert 'gravity is 9.8' in answer.message
    assert 'roll' in answer.message
    assert 'pitch' in answer.message

    answer = busy.trigger('integrator/calibrate')
    assert answer.success, answer.message
    assert answer.message.startswith('offset along x, y, z: ')

    assert busy.distance() > 0.05, 'it drifted on the old attitude'
    answer = ros.trigger('integrator/reset')
    assert answer.success
    assert answer.message == 'position and velocity are zero'
    busy.run(STEP)
    assert busy.distance() < 0.01


@pytest.fixture(params=EXECUTORS)
def executor(request):
    return request.param


def test_driver_refuses_to_calibrate_while_it_moves(ros, executor):
    ros.start(
        'accelerometer_driver',
        {
            'common.executor': executor,
            'driver.calibrate_on_start': False,
            'driver.calibration_samples': 6400,
            'driver.slide.start': 0.0,
            'driver.slide.distance': 200.0,
            'driver.slide.duration': 30.0,
        },
    )
    raw = ros.record('imu/data_raw', Imu)
    raw.wait(1)
    answer = ros.trigger('accelerometer_driver/calibrate')
    assert not answer.success
    assert 'the device moved while it was calibrated' in answer.message
    assert 'hold it still' in answer.message
    seen = len(raw)
    raw.wait(seen + 10)


def test_driver_refuses_to_calibrate_when_it_is_tilted(ros, executor):
    ros.start(
        'accelerometer_driver',
        {
            'common.executor': executor,
            'driver.motion': 'rest',
            'driver.calibrate_on_start': False,
            'driver.simulated.attitude': [0.2618, 0.0, 0.0],
            'driver.simulated.offset': [0.0, 0.0, 0.0],
        },
    )
    raw = ros.record('imu/data_raw', Imu)
    answer = ros.trigger('accelerometer_driver/calibrate')
    assert not answer.success
    assert 'axis y' in answer.message
    assert '15° would look like this' in answer.message
    for cause in ('driver.range_g', 'driver.supply', 'driver.adc_reference'):
        assert cause in answer.message
    assert raw.wait_next().linear_acceleration.y == pytest.approx(GRAVITY * 0.2588, abs=0.2)


def test_without_samples_a_service_answers_with_the_reason(ros, executor):
    parameters = {'common.executor': executor, 'common.service_timeout': 0.5}
    ros.start('gravity_removal', parameters)
    ros.start('integrator', parameters)
    for name in ('gravity_removal/level', 'integrator/calibrate'):
        answer = ros.trigger(name)
        assert not answer.success
        assert 'no samples to work with' in answer.message
        assert 'common.service_timeout' in answer.message
    # A node that waited in vain goes on; once there are samples, asking again helps.
    publisher = ros.publisher('imu/data_raw', Imu)
    feed = Feed(ros, lambda stamp_ns: publisher.publish(imu_message(stamp_ns, (0, 0, GRAVITY))))
    future = ros.ask(Trigger, 'gravity_removal/level', Trigger.Request())
    feed.send_until(future.done, 'the answer')
    assert future.result().success, future.result().message


def test_levelling_is_refused_while_it_moves_and_where_gravity_is_wrong(ros, executor):
    ros.start('gravity_removal', {'common.executor': executor})
    publisher = ros.publisher('imu/data_raw', Imu)
    feed = Feed(ros, lambda stamp_ns, *f: publisher.publish(imu_message(stamp_ns, f)))
    random = np.random.default_rng(5)

    def level_with(force):
        future = ros.ask(Trigger, 'gravity_removal/level', Trigger.Request())

        def sent():
            feed.send(*force())
            return future.done()

        ros.until(sent, 'the answer', Feed.PATIENCE)
        assert not future.result().success
        return future.result().message

    moving = level_with(lambda: random.normal([0.0, 0.0, GRAVITY], 1.0))
    assert 'not at rest' in moving
    assert 'hold the device still' in moving
    in_g = level_with(lambda: (0.0, 0.0, 1.0))
    assert 'the unit is g instead of m/s²' in in_g
    removed = level_with(lambda: (0.0, 0.0, 0.01))
    assert 'most likely gravity is removed already' in removed


@pytest.fixture(scope='module', params=EXECUTORS)
def fed(request, module_ros):
    """An integrator that gets what the tests feed it."""
    space = f'/fed_{request.param}'
    module_ros.start('integrator', {'common.executor': request.param}, '-r', f'__ns:={space}')
    return Fed(module_ros, space)


@pytest.fixture
def integrator(fed):
    """The same, with nothing of an earlier test in its queues."""
    fed.feed_until_odometry(1)
    return fed


class Fed:
    """An integrator, the samples it is fed with, its services and its odometry."""

    def __init__(self, ros, space):
        self.ros = ros
        self.service = f'{space}/integrator'
        self.odom = ros.record(f'{space}/odom', Odometry).connected()
        attitude = ros.publisher(f'{space}/imu/data', Imu)
        acceleration = ros.publisher(
            f'{space}/imu/linear_acceleration', AccelWithCovarianceStamped
        )

        def publish(stamp_ns, *values):
            attitude.publish(imu_message(stamp_ns, (0.0, 0.0, GRAVITY), LEVEL))
            acceleration.publish(acceleration_message(stamp_ns, values))

        self.feed = Feed(ros, publish)

    def ask(self, name):
        """Send a request and return the future of its answer."""
        return self.ros.ask(Trigger, f'{self.service}/{name}', Trigger.Request())

    def feed_until(self, condition, what, acceleration=lambda: (0.0, 0.0, 0.0)):
        """Feed samples until a condition."""

        def sent():
            self.feed.send(*acceleration())
            return condition()

        self.ros.until(sent, what, Feed.PATIENCE)

    def feed_until_odometry(self, count, acceleration=lambda: (0.0, 0.0, 0.0)):
        """Feed samples until the one that comes so many later has come out."""
        wanted = self.feed.stamp_ns + count * self.feed.step_ns
        self.feed_until(lambda: self.odom.latest_stamp >= wanted, 'odom', acceleration)


def test_integrator_refuses_to_calibrate_while_it_moves(integrator):
    answer = integrator.ask('calibrate')
    random = np.random.default_rng(5)
    integrator.feed_until(answer.done, 'the answer', lambda: random.normal([0.0, 0.0, 0.0], 1.0))
    assert not answer.result().success
    assert 'not at rest' in answer.result().message


def test_a_calibrated_offset_is_taken_off(integrator):
    def offset():
        return (0.125, -0.25, 0.0)

    answer = integrator.ask('calibrate')
    integrator.feed_until(answer.done, 'the answer', offset)
    assert answer.result().message == 'offset along x, y, z: 0.1250, -0.2500, 0.0000 m/s²'
    assert integrator.ros.trigger(f'{integrator.service}/reset').success
    integrator.feed_until_odometry(200, offset)
    speed = integrator.odom.messages[-1].twist.twist.linear
    assert (speed.x, speed.y, speed.z) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def test_who_asks_again_gets_the_answer_and_the_first_the_reason(integrator):
    answers = [integrator.ask('calibrate') for _ in range(2)]
    integrator.ros.until(lambda: any(answer.done() for answer in answers), 'an answer')
    integrator.feed_until(lambda: all(answer.done() for answer in answers), 'both answers')
    refused, done = sorted((a.result() for a in answers), key=lambda answer: answer.success)
    assert not refused.success
    assert 'asked for again' in refused.message
    assert done.success


def test_a_reset_ends_a_calibration_with_the_reason(integrator):
    answer = integrator.ask('calibrate')
    while not answer.done():  # which request is heard of first is not said
        assert integrator.ros.trigger(f'{integrator.service}/reset').success
    assert not answer.result().success
    assert 'reset' in answer.result().message


def test_every_request_is_answered(integrator):
    answers = [integrator.ask('reset') for _ in range(10)]
    integrator.ros.until(lambda: all(answer.done() for answer in answers), 'all answers')
    assert all(answer.result().success for answer in answers)


def test_a_client_that_left_does_no_harm(integrator, tmp_path):
    ros, service = integrator.ros, f'{integrator.service}/calibrate'
    known = ros.node.count_clients(service)
    with Ros(ros.domain, tmp_path) as other:
        other.ask(Trigger, service, Trigger.Request())
        ros.until(lambda: ros.node.count_clients(service) > known, 'the client')
        other.for_seconds(0.3)  # until the request is taken
    ros.until(lambda: ros.node.count_clients(service) == known, 'the client gone')
    integrator.feed_until_odometry(300)  # more than the calibration takes
    assert ros.trigger(f'{integrator.service}/reset').success


def test_pipeline_offers_the_services_of_its_parts(ros, executor):
    ros.start(
        'pipeline',
        {'common.executor': executor, 'pipeline.source': 'simulated', 'driver.motion': 'rest'},
    )
    odom = ros.record('odom', Odometry)
    odom.wait(1)
    answer = ros.trigger('pipeline/calibrate')
    assert answer.success, answer.message
    sensor, _, integrator = answer.message.partition('; offset along x, y, z: ')
    assert sensor.startswith('offset of x, y, z: ')
    assert integrator.endswith(' m/s²')
    answer = ros.trigger('pipeline/level')
    assert answer.success, answer.message
    assert 'gravity is 9.8' in answer.message
    assert ros.trigger('pipeline/reset').message == 'position and velocity are zero'


def test_pipeline_calibrates_no_integrator_if_the_sensor_refuses(ros):
    ros.start(
        'pipeline',
        {
            'pipeline.source': 'simulated',
            'driver.motion': 'rest',
            'driver.calibrate_on_start': False,
            'driver.simulated.attitude': [0.2618, 0.0, 0.0],
        },
    )
    answer = ros.trigger('pipeline/calibrate')
    assert not answer.success
    assert 'would look like this' in answer.message
    assert 'offset along' not in answer.message
