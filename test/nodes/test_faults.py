"""What goes wrong is counted in /diagnostics, said once, with the remedy, and stops nothing."""

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import AccelWithCovarianceStamped
from messages import GRAVITY, Feed, acceleration_message, imu_message
from nav_msgs.msg import Odometry
from ros_harness import EXECUTORS, NODES, figures
from sensor_msgs.msg import Imu

LEVEL = (0.0, 0.0, 0.0, 1.0)
AT_REST = (0.0, 0.0, GRAVITY)
NAN = float('nan')


def levels(status):
    return {
        DiagnosticStatus.OK: 'ok',
        DiagnosticStatus.WARN: 'warning',
        DiagnosticStatus.ERROR: 'error',
    }[status.level]


def lines(node, *words):
    """Return the lines of a node's log that hold all words."""
    return [line for line in node.stderr.splitlines() if all(word in line for word in words)]


@pytest.mark.parametrize('executor', EXECUTORS)
def test_nodes_that_wait_say_so(ros, executor):
    diagnostics = ros.diagnostics()
    for name in NODES:
        parameters = {'common.executor': executor, 'driver.wait_for_subscribers': 100}
        ros.start(name, parameters, '-r', f'__ns:=/{name}_space')
    for name in NODES:
        status = diagnostics.until(f'{name}_space/{name}', lambda _: True, 'anything')
        assert levels(status) == 'ok'
        assert status.message.startswith('waiting for samples')
        if name != 'accelerometer_driver':
            assert f'/{name}_space/' in status.message
            assert 'no publisher: start ' in status.message
        assert status.hardware_id == 'dead_reckoning'
        assert figures(status)['samples'] == '0'


class Fed:
    """A node that the test feeds with Imu messages."""

    def __init__(self, ros, name, parameters, topic):
        self.ros = ros
        self.name = name
        self.node = ros.start(name, parameters)
        self.diagnostics = ros.diagnostics()
        self.publisher = ros.publisher(topic, Imu)
        self.feed = Feed(ros, lambda stamp_ns, *message: self._publish(stamp_ns, *message))

    def _publish(self, stamp_ns, force, orientation=None):
        self.publisher.publish(imu_message(stamp_ns, force, orientation))

    def until(self, key, count, *sample):
        """Feed a sample again and again until /diagnostics counts so many of something."""

        def find():
            for status in self.diagnostics.of(self.name):
                if int(figures(status).get(key, 0)) >= count:
                    return status
            return None

        def sent():
            self.feed.send(*sample)
            return find()

        return self.ros.until(sent, f'{count} of {key}', Feed.PATIENCE)


def test_an_imu_without_orientation_is_counted_with_the_remedy(ros):
    parameters = {'gravity.attitude': 'message'}
    fed = Fed(ros, 'gravity_removal', parameters, 'imu/data')
    status = fed.until('MissingAttitudeError', 20, AT_REST)
    assert levels(status) == 'warning'
    assert 'carries no orientation' in status.message
    assert 'set gravity.attitude to rest' in status.message
    assert len(lines(fed.node, 'carries no orientation', '[WARN]')) == 1, 'said once, not always'
    # The next Imu with an orientation is welcome.
    out = ros.record('imu/linear_acceleration', AccelWithCovarianceStamped)
    fed.feed.send_until(lambda: out.messages, 'linear acceleration', AT_REST, LEVEL)
    status = fed.diagnostics.until('gravity_removal', lambda s: levels(s) == 'ok', 'well again')
    assert int(figures(status)['MissingAttitudeError']) >= 20, 'the count stays'


def test_a_force_in_g_is_one_error_that_names_the_causes(ros):
    fed = Fed(ros, 'gravity_removal', {}, 'imu/data_raw')
    status = fed.until('GravityError', 3, (0.0, 0.0, 1.0))
    assert levels(status) == 'error'
    (line,) = lines(fed.node, '[ERROR]')
    assert 'at rest the specific force is 1 m/s²' in line
    assert 'most likely the unit is g instead of m/s² (multiply by 9.80665)' in line
    for cause in ('gravity is removed already', 'mg', 'driver.range_g'):
        assert cause in line
    assert int(figures(status)['NotLevelledError']) > 0, 'no sample passed before'


def test_upside_down_is_a_warning_and_goes_on(ros):
    fed = Fed(ros, 'gravity_removal', {}, 'imu/data_raw')
    out = ros.record('imu/linear_acceleration', AccelWithCovarianceStamped)
    status = fed.until('MountingError', 1, (0.0, 0.0, -GRAVITY))
    assert levels(status) == 'warning'
    (line,) = lines(fed.node, '180° off the up axis')
    assert '[WARN]' in line
    for cause in ('mounted that way', 'sign', 'upside down', 'NED'):
        assert cause in line
    linear = out.wait(1)[-1].accel.accel.linear
    assert (linear.x, linear.y, linear.z) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize('executor', EXECUTORS)
def test_what_no_sample_may_be_is_dropped_and_counted(ros, executor):
    """NaN, infinity, stamps that are none, bytes that are no message: the others go on."""
    fed = Fed(ros, 'gravity_removal', {'common.executor': executor}, 'imu/data_raw')
    out = ros.record('imu/linear_acceleration', AccelWithCovarianceStamped).connected()
    fed.feed.send_until(lambda: out.messages, 'linear acceleration', AT_REST)
    fed.until('NotFiniteError', 5, (0.0, NAN, GRAVITY))
    fed.until('NotFiniteError', 10, (0.0, 0.0, float('-inf')))
    fed.feed.send(AT_REST)
    stamp_ns = fed.feed.stamp_ns
    for message in (
        imu_message(0, AT_REST),
        imu_message(stamp_ns - 5_000_000, AT_REST),
        b'\0\1\0\0 no message',
        b'\0\0\0\0',
        b'',
    ):
        fed.publisher.publish(message)
    for message in [imu_message(stamp_ns + 5_000_000, AT_REST)] * 2:
        fed.publisher.publish(message)
    fed.feed.stamp_ns += 5_000_000
    seen = len(out)
    fed.feed.send_until(lambda: len(out) > seen + 50, 'linear acceleration', AT_REST)
    status = fed.until('WireError', 1, AT_REST)
    counts = figures(status)
    assert int(counts['NotFiniteError']) >= 10
    assert int(counts['ZeroStampError']) == 1
    assert int(counts['LateSampleError']) == 1
    assert int(counts['RepeatedStampError']) >= 1
    assert int(counts['samples']) > 50
    for message in out.messages:
        linear = message.accel.accel.linear
        assert (linear.x, linear.y, linear.z) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert len(lines(fed.node, 'nan')) == 1
    assert 'Traceback' not in fed.node.stderr


def test_gaps_restarts_and_lost_partners_are_counted(ros):
    node = ros.start('integrator')
    diagnostics = ros.diagnostics()
    attitude = ros.publisher('imu/data', Imu)
    acceleration = ros.publisher('imu/linear_acceleration', AccelWithCovarianceStamped)
    odom = ros.record('odom', Odometry).connected()

    def publish(stamp_ns, with_attitude=True):
        if with_attitude:
            attitude.publish(imu_message(stamp_ns, AT_REST, LEVEL))
        acceleration.publish(acceleration_message(stamp_ns, (0.0, 0.0, 0.0)))

    feed = Feed(ros, publish)
    feed.send_until(lambda: len(odom) > 10, 'odom')
    variance = odom.messages[-1].pose.covariance[0]
    feed.stamp_ns += 3_000_000_000
    after = feed.stamp_ns
    feed.send_until(lambda: odom.latest_stamp > after, 'odom after the gap')
    assert odom.messages[-1].pose.covariance[0] > variance + 1.0, 'a gap may hide motion'
    feed.send(False)
    feed.stamp_ns -= 60_000_000_000
    seen = len(odom)
    feed.send_until(lambda: len(odom) > seen + 5 and odom.latest_stamp < after, 'odom anew')
    assert odom.messages[-1].pose.covariance[0] < 1e-3

    def counted(status):
        counts = figures(status)
        return (
            counts.get('GapError') == '1'
            and counts.get('RestartError') == '1'
            and int(counts.get('UnpairedError', 0)) >= 1
        )

    diagnostics.until('integrator', counted, 'a gap, a restart, a lost partner')
    (line,) = lines(node, 'found no partner')
    assert 'qos_overrides' in line


def test_the_driver_says_when_it_cannot_calibrate_at_the_start(ros):
    """Samples come all the same, with the offsets of the data sheet."""
    node = ros.start(
        'accelerometer_driver',
        {'driver.motion': 'rest', 'driver.simulated.attitude': [0.2618, 0.0, 0.0]},
    )
    raw = ros.record('imu/data_raw', Imu)
    diagnostics = ros.diagnostics()
    status = diagnostics.until(
        'accelerometer_driver', lambda s: 'CalibrationError' in figures(s), 'a failed calibration'
    )
    assert 'clipped_conversions' in figures(status)
    assert raw.wait(10)[-1].linear_acceleration.z == pytest.approx(9.47 + 0.4, abs=0.3)
    (line,) = lines(node, '[ERROR]')
    assert 'is not level' in line


def test_clipping_shows_in_the_covariance_and_is_counted(ros):
    ros.start(
        'accelerometer_driver',
        {
            'driver.wait_for_subscribers': 1,
            'driver.slide.start': 0.3,
            'driver.slide.distance': 100.0,
            'driver.slide.duration': 2.0,
        },
    )
    raw = ros.record('imu/data_raw', Imu)
    diagnostics = ros.diagnostics()
    diagnostics.until(
        'accelerometer_driver',
        lambda s: int(figures(s)['clipped_conversions']) > 100,
        'clipped conversions',
    )
    worst = max(message.linear_acceleration_covariance[0] for message in raw.messages)
    assert worst == pytest.approx((1.5 * GRAVITY) ** 2)
