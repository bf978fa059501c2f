"""Every node meets every fault of a stream: counted by its name, and the next samples pass."""

from dataclasses import dataclass, field

import pytest
from geometry_msgs.msg import AccelWithCovarianceStamped
from messages import GRAVITY, NANOSECONDS, START_NS, acceleration_message, fill, imu_message
from nav_msgs.msg import Odometry
from rclpy.qos import QoSProfile
from ros_harness import LATCHED, figures, lossless
from sensor_msgs.msg import Imu
from std_msgs.msg import Float64, UInt32

STEP_NS = NANOSECONDS // 100
AT_REST = (0.0, 0.0, GRAVITY)
LEVEL = (0.0, 0.0, 0.0, 1.0)
NAN = float('nan')
STAMPS = {'ZeroStampError': 1, 'RepeatedStampError': 1, 'LateSampleError': 1}


@dataclass
class Case:
    """A node, what it takes and gives, and which faults it must count, each so often."""

    node: str
    inputs: tuple[str, ...]
    output: tuple[str, type] | tuple[str, type, QoSProfile]
    counts: dict[str, int]
    parameters: dict[str, object] = field(default_factory=dict)


ONCE = {**STAMPS, 'NotFiniteError': 1, 'RestartError': 1}
CASES = {
    'gravity from a message': Case(
        'gravity_removal',
        ('imu/data',),
        ('imu/linear_acceleration', AccelWithCovarianceStamped),
        ONCE,
        {'gravity.attitude': 'message'},
    ),
    'gravity at rest': Case(
        'gravity_removal',
        ('imu/data_raw',),
        ('imu/linear_acceleration', AccelWithCovarianceStamped),
        ONCE,
        {'gravity.attitude': 'rest'},
    ),
    'gravity estimated': Case(
        'gravity_removal',
        ('imu/data_raw',),
        ('imu/linear_acceleration', AccelWithCovarianceStamped),
        {**ONCE, 'GapError': 1},
        {'gravity.attitude': 'estimate'},
    ),
    'integrator': Case(
        'integrator',
        ('imu/data', 'imu/linear_acceleration'),
        ('odom', Odometry),
        {**ONCE, 'GapError': 1},
    ),
    'integrator with filterpy': Case(
        'integrator',
        ('imu/data', 'imu/linear_acceleration'),
        ('odom', Odometry),
        {**ONCE, 'GapError': 1},
        {'integrator.method': 'kalman'},
    ),
    'pedometer': Case(
        'pedometer',
        ('imu/data_raw',),
        ('pedometer/cadence', Float64, LATCHED),  # may have come before the recording
        {**ONCE, 'GapError': 1},
    ),
    'inertial navigator': Case(
        'inertial_navigator',
        ('imu/data_raw',),
        ('odom', Odometry),
        {**ONCE, 'GapError': 1},
    ),
    'compass': Case(
        'compass_driver',
        ('ground_truth/odom',),
        ('compass/data', Imu),
        ONCE,
        {'compass.rate': 1000.0},
    ),
    'pipeline': Case(
        'pipeline',
        ('imu/data',),
        ('odom', Odometry),
        {**ONCE, 'GapError': 1, 'RestartError': 2},  # of gravity removal and integrator
        {'gravity.attitude': 'message'},
    ),
    'pipeline estimated': Case(
        'pipeline',
        ('imu/data_raw',),
        ('odom', Odometry),
        {**ONCE, 'GapError': 2, 'RestartError': 2},  # each with its own remedy
        {'gravity.attitude': 'estimate'},
    ),
}


def whole_imu(stamp_ns, force=AT_REST):
    """Return an Imu with force, rate and orientation."""
    message = imu_message(stamp_ns, force, LEVEL)
    message.angular_velocity_covariance = [1e-6, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1e-6]
    return message


def bad_imu(stamp_ns):
    message = whole_imu(stamp_ns, (0.0, NAN, GRAVITY))
    message.angular_velocity.z = NAN
    return message


def truth(stamp_ns, orientation=LEVEL):
    message = Odometry()
    sec, nanosec = divmod(stamp_ns, NANOSECONDS)
    message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
    fill(message.pose.pose.orientation, 'xyzw', orientation)
    return message


MESSAGES = {
    'imu/data': (Imu, whole_imu, bad_imu),
    'imu/data_raw': (Imu, whole_imu, bad_imu),
    'imu/linear_acceleration': (
        AccelWithCovarianceStamped,
        lambda stamp_ns: acceleration_message(stamp_ns, (0.0, 0.0, 0.0)),
        None,
    ),
    'ground_truth/odom': (Odometry, truth, lambda stamp_ns: truth(stamp_ns, (NAN, 0.0, 0.0, 1.0))),
}


class Stream:
    """Feeds all inputs of a node, steadily; a fault comes on the first of them alone."""

    def __init__(self, ros, case):
        self._ros = ros
        self._publishers = {name: ros.publisher(name, MESSAGES[name][0]) for name in case.inputs}
        self._first = case.inputs[0]
        self.stamp_ns = START_NS

    def run(self, count):
        for _ in range(count):
            self.stamp_ns += STEP_NS
            for name, publisher in self._publishers.items():
                publisher.publish(MESSAGES[name][1](self.stamp_ns))
            self._ros.for_seconds(0.001)

    def say(self, stamp_ns):
        """Publish what is only wrong by its stamp."""
        self._publishers[self._first].publish(MESSAGES[self._first][1](stamp_ns))

    def say_nan(self):
        self.stamp_ns += STEP_NS
        self._publishers[self._first].publish(MESSAGES[self._first][2](self.stamp_ns))


@pytest.mark.parametrize('case', CASES.values(), ids=CASES)
def test_faults_are_counted_by_name_and_the_next_samples_pass(ros, case):
    topics = [f'/{name}' for name in (*case.inputs, case.output[0])]
    # A test that is kept waiting itself is no silent input.
    patient = {'common.input_timeout': 30.0}
    node = ros.start(case.node, {**lossless(*topics), **patient, **case.parameters})
    diagnostics = ros.diagnostics()
    stream = Stream(ros, case)
    out = ros.record(*case.output).connected()
    stream.run(150)
    ros.until(lambda: len(out), 'an output')
    stream.say(0)
    stream.run(100)
    stream.say(stream.stamp_ns)
    stream.run(100)
    stream.say(stream.stamp_ns - 50 * STEP_NS)
    stream.run(100)
    stream.say_nan()
    stream.run(100)
    stream.stamp_ns += 3 * NANOSECONDS
    stream.run(200)
    ended = stream.stamp_ns
    stream.stamp_ns = START_NS  # the bag loops
    seen = len(out)
    stream.run(200)

    def counted():
        stream.run(5)
        latest = diagnostics.of(case.node)[-1:]
        found = {name: value for status in latest for name, value in figures(status).items()}
        return found if int(found.get('RestartError', 0)) else None

    ros.until(counted, 'a restart')
    ros.for_seconds(1.2)
    found = counted()
    kinds = {name: int(value) for name, value in found.items() if name.endswith('Error')}
    kinds.pop('NotLevelledError', None)
    assert kinds == case.counts
    if case.output[1] not in (Float64, UInt32):
        ros.until(lambda: len(out) > seen and out.latest_stamp < ended, 'outputs anew')
    assert 'Traceback' not in node.stderr
    said = [line for line in node.stderr.splitlines() if '[WARN]' in line or '[ERROR]' in line]
    assert len(said) == len(case.counts), 'each said once'
    for line in said:
        assert ': ' in line, 'the cause, and after it the remedy'
