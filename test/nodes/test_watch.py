"""What does not come is said on /diagnostics as long as it lacks, with the remedy."""

from itertools import count

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
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
from rclpy.duration import Duration
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from ros_harness import BEST_EFFORT, figures
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64

LEVEL = (0.0, 0.0, 0.0, 1.0)
AT_REST = (0.0, 0.0, GRAVITY)
QUICK = {'common.input_timeout': 1.0}


def names(status, kind, *words):
    """Say whether a status is a warning or error of a kind whose message holds all words."""
    return (
        status.level != DiagnosticStatus.OK
        and kind in figures(status)
        and all(word in status.message for word in words)
    )


def well(status):
    return status.level == DiagnosticStatus.OK


def lines(node, word=''):
    """Return the lines of a node's log that hold a word."""
    return [line for line in node.stderr.splitlines() if word in line]


class Said:
    """The latest thing that one node says on /diagnostics."""

    def __init__(self, ros, node):
        self._ros = ros
        self._node = node
        self._recording = ros.diagnostics()

    def until(self, condition, what, send=lambda: None):
        """Wait until the next status meets a condition, sending meanwhile."""
        seen = len(self._recording.of(self._node))

        def found():
            send()
            return next(filter(condition, self._recording.of(self._node)[seen:]), None)

        return self._ros.until(found, f'{self._node}: {what}', Feed.PATIENCE)


def imu_feed(ros, topic):
    publisher = ros.publisher(topic, Imu)
    return Feed(ros, lambda stamp_ns: publisher.publish(imu_message(stamp_ns, AT_REST, LEVEL)))


@pytest.mark.parametrize(
    ('name', 'parameters', 'topic'),
    [
        ('gravity_removal', {}, 'imu/data_raw'),
        ('pedometer', {}, 'imu/data_raw'),
        ('pipeline', {'gravity.attitude': 'message'}, 'imu/data'),
    ],
)
def test_an_imu_that_stops_is_a_warning_until_it_is_back(ros, name, parameters, topic):
    node = ros.start(name, {**QUICK, **parameters})
    said = Said(ros, name)
    feed = imu_feed(ros, topic)
    said.until(lambda s: well(s) and s.message == 'running', 'running', feed.send)
    words = (f'no message on /{topic} for ', ' s: its publisher /test is silent', 'paused bag')
    said.until(lambda s: names(s, 'SilentInputError', *words), 'silence')
    again = said.until(lambda s: names(s, 'SilentInputError', *words), 'silence that lasts')
    assert figures(again)['SilentInputError'] == '1', 'counted once'
    said.until(well, 'well again', feed.send)
    begun, ended = lines(node, topic)
    assert '[WARN]' in begun
    assert f'/{topic}: SilentInputError is over' in ended


def test_a_topic_that_is_too_slow_is_said_once(ros):
    """A single message does not end a silence, or each would begin another."""
    node = ros.start('gravity_removal', {'common.input_timeout': 0.5})
    said = Said(ros, 'gravity_removal')
    feed = imu_feed(ros, 'imu/data_raw')
    said.until(lambda s: well(s) and s.message == 'running', 'running', feed.send)
    words = ('no message on', 'raise common.input_timeout')
    begun = said.until(lambda s: names(s, 'SilentInputError', *words), 'silence')
    log = lines(node)
    for _ in range(3):
        feed.send()
        for _ in range(2):  # so that the next message comes more than a second later
            status = said.until(lambda _: True, 'anything')
            assert names(status, 'SilentInputError', *words)
    assert figures(status)['SilentInputError'] == figures(begun)['SilentInputError']
    assert lines(node) == log
    said.until(well, 'well', feed.send)


def test_an_imu_whose_driver_is_gone_is_told_apart(ros):
    node = ros.start('gravity_removal', QUICK)
    said = Said(ros, 'gravity_removal')
    driver = ros.start('accelerometer_driver', {'driver.motion': 'rest'})
    said.until(lambda s: well(s) and s.message == 'running', 'running')
    driver.end(2)
    status = said.until(
        lambda s: names(s, 'SilentInputError', '/imu/data_raw', 'it has no publisher'), 'silence'
    )
    assert 'start the driver of the sensor' in status.message
    assert status.level == DiagnosticStatus.WARN
    (line,) = lines(node, 'no message on')
    assert '[WARN]' in line


def test_a_partner_that_never_comes_is_said_with_both_topics(ros):
    ros.start('integrator', QUICK)
    said = Said(ros, 'integrator')
    feed = imu_feed(ros, 'imu/data')
    status = said.until(
        lambda s: names(s, 'SilentInputError', 'nothing on /imu/linear_acceleration so far'),
        'nothing',
        feed.send,
    )
    assert status.message.startswith('/imu/data came, but')
    assert 'no publisher: start gravity_removal' in status.message
    publisher = ros.publisher('imu/linear_acceleration', AccelWithCovarianceStamped)

    def both():
        publisher.publish(acceleration_message(feed.stamp_ns + feed.step_ns, (0.0, 0.0, 0.0)))
        feed.send()

    said.until(well, 'well', both)
    said.until(
        lambda s: names(s, 'SilentInputError', 'no message on /imu/linear_acceleration for'),
        'one that stops',
        feed.send,
    )


def test_a_compass_need_not_come_but_may_not_stop(ros):
    ros.start('gravity_removal', QUICK)
    said = Said(ros, 'gravity_removal')
    feed = imu_feed(ros, 'imu/data_raw')
    out = ros.record('imu/data', Imu)
    feed.send_until(lambda: len(out) > 500, 'samples')
    said.until(well, 'well without a compass', feed.send)
    compass = imu_feed(ros, 'compass/data')
    compass.stamp_ns = feed.stamp_ns
    imus = (feed.stamp_ns - START_NS) // feed.step_ns
    said.until(lambda s: int(figures(s)['samples']) > imus, 'the compass is heard', compass.send)
    said.until(
        lambda s: names(s, 'SilentInputError', 'no message on /compass/data', 'input_timeout'),
        'silence of the compass',
        feed.send,
    )


def test_a_publisher_that_can_not_be_heard_is_said_once_with_the_policy(ros):
    """Only qos_overrides make a subscription so demanding."""
    node = ros.start(
        'gravity_removal', {'qos_overrides./imu/data_raw.subscription.reliability': 'reliable'}
    )
    said = Said(ros, 'gravity_removal')
    publisher = ros.node.create_publisher(Imu, 'imu/data_raw', BEST_EFFORT)
    status = said.until(
        lambda s: names(s, 'MismatchError', 'from /test to /gravity_removal'), 'mismatch'
    )
    assert status.level == DiagnosticStatus.ERROR
    assert 'best effort publisher and reliable subscription' in status.message
    assert 'qos_overrides./imu/data_raw' in status.message
    said.until(lambda s: names(s, 'MismatchError'), 'mismatch that lasts')
    assert len(lines(node)) == 1, 'said once'
    ros.node.destroy_publisher(publisher)
    said.until(well, 'well again')
    assert 'to /gravity_removal: MismatchError is over' in lines(node)[1]


@pytest.mark.parametrize(
    ('demand', 'reason'),
    [
        (
            {'durability': QoSDurabilityPolicy.TRANSIENT_LOCAL},
            'volatile publisher and transient local subscription',
        ),
        ({'deadline': Duration(seconds=1)}, 'deadline'),
    ],
)
def test_a_subscriber_that_hears_nothing_is_said_with_the_policy(ros, demand, reason):
    ros.start('integrator')
    said = Said(ros, 'integrator')
    ros.record('odom', Odometry, QoSProfile(depth=1, **demand))
    status = said.until(
        lambda s: names(s, 'MismatchError', '/odom', 'from /integrator to /test'), 'mismatch'
    )
    assert reason in status.message


def test_another_type_on_a_topic_is_said(ros):
    ros.node.create_publisher(Float64, 'imu/data_raw', 10)
    ros.start('gravity_removal')
    status = Said(ros, 'gravity_removal').until(
        lambda s: names(s, 'MismatchError', '/imu/data_raw'), 'mismatch'
    )
    assert 'std_msgs/msg/Float64 is published, sensor_msgs/msg/Imu subscribed' in status.message


def test_two_publishers_of_one_input_are_noticed(ros):
    ros.start('gravity_removal')
    said = Said(ros, 'gravity_removal')
    feed = imu_feed(ros, 'imu/data_raw')
    said.until(well, 'one is well', feed.send)
    second = ros.node.create_publisher(Imu, 'imu/data_raw', 10)
    status = said.until(lambda s: names(s, 'SeveralPublishersError', '/imu/data_raw'), 'two')
    assert 'has 2 publishers, /test, /test: their samples mix' in status.message
    ros.node.destroy_publisher(second)
    said.until(lambda s: not names(s, 'SeveralPublishersError', 'publishers'), 'one again')


def test_a_clock_that_lacks_or_stands_is_said(ros):
    ros.start('accelerometer_driver', {**QUICK, 'use_sim_time': True, 'driver.motion': 'rest'})
    said = Said(ros, 'accelerometer_driver')
    status = said.until(lambda s: names(s, 'ClockError', 'no /clock came'), 'no clock')
    assert 'play the bag with --clock' in status.message
    clock = ros.publisher('/clock', Clock)
    times = count(100 * NANOSECONDS, 5_000_000)

    def tick():
        clock.publish(clock_message(next(times)))

    said.until(lambda s: well(s) and s.message == 'running', 'running', tick)
    said.until(lambda s: names(s, 'ClockError', '/clock has stood at 10'), 'a clock that stands')
    said.until(well, 'running again', tick)
