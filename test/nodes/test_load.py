"""No fault of a topic makes a node spin: it uses little of a core whatever comes, or does not.

The bound is a law, not a benchmark: a node that spins uses a whole core.
"""

import os
import time
from pathlib import Path

import pytest
from messages import GRAVITY, NANOSECONDS, START_NS, imu_message
from nav_msgs.msg import Odometry
from ros_harness import EXECUTORS, NODES, figures, lossless
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu

SECONDS = 2.0
SHARE = 0.5
"""Of a core: many times what is needed, half of what spinning takes."""

NAN = float('nan')


def busy(node):
    """Return the time [s] that a node has used so far, in user mode and in the kernel."""
    fields = Path(f'/proc/{node.process.pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def require_calm(ros, nodes, send=None):
    """Assert that nodes use little time over `SECONDS`, while ``send`` is called at 500 Hz."""
    before = [busy(node) for node in nodes]
    start = time.monotonic()
    sent = 0
    while (passed := time.monotonic() - start) < SECONDS:
        if send is not None and sent < 500 * passed:
            send()
            sent += 1
        else:
            ros.for_seconds(0.002)
    share = {node.name: (busy(node) - b) / passed for node, b in zip(nodes, before, strict=True)}
    assert max(share.values()) < SHARE, share


@pytest.fixture(autouse=True)
def _there_is_proc():
    if not Path('/proc/self/stat').exists():
        pytest.skip('/proc is not there to tell the time a process used')


@pytest.mark.parametrize('executor', EXECUTORS)
def test_nodes_that_wait_rest(ros, executor):
    diagnostics = ros.diagnostics()
    parameters = {'common.executor': executor, 'driver.wait_for_subscribers': 100}
    nodes = [ros.start(name, parameters) for name in NODES]
    for name in NODES:
        diagnostics.until(name, lambda _: True, 'anything')
    require_calm(ros, nodes)


@pytest.mark.parametrize(
    ('kind', 'executor'),
    [
        ('nan', 'events'),
        ('nan', 'single'),
        ('one stamp', 'events'),
        ('back and forth', 'events'),
        ('years ahead', 'events'),
    ],
)
def test_nothing_but_faults_at_500_hz_is_calm(ros, kind, executor):
    message = imu_message(START_NS, (0.0, 0.0, GRAVITY), (0.0, 0.0, 0.0, 1.0))
    if kind == 'nan':
        message.linear_acceleration.x = NAN

    publishers = []

    def send():
        if kind == 'back and forth':
            message.header.stamp.sec = 1_000 if message.header.stamp.sec == 2_000 else 2_000
        elif kind == 'years ahead':
            message.header.stamp.sec += 1_000_000
        elif kind == 'nan':
            message.header.stamp.nanosec = (message.header.stamp.nanosec + 2_000_000) % NANOSECONDS
            message.header.stamp.sec += not message.header.stamp.nanosec
        for publisher in publishers:
            publisher.publish(message)

    common = {'common.executor': executor, 'gravity.attitude': 'message'}
    nodes = [
        ros.start('pedometer', {**common, 'pedometer.input': 'imu/data'}),
        ros.start(
            'pipeline', {**common, 'pipeline.estimators': ['integrator'], **lossless('/imu/data')}
        ),
        ros.start('integrator', {'common.executor': executor}),
        ros.start('gravity_removal', common),
    ]
    diagnostics = ros.diagnostics()
    publishers.append(ros.publisher('imu/data', Imu, len(nodes)))
    require_calm(ros, nodes, send)
    for node in nodes:
        status = diagnostics.until(node.name, lambda s: int(figures(s)['samples']) > 50, 'samples')
        assert status is not None


@pytest.mark.parametrize('executor', EXECUTORS)
def test_a_clock_that_stands_is_waited_for_calmly(ros, executor):
    driver = ros.start(
        'accelerometer_driver',
        {'use_sim_time': True, 'common.executor': executor, 'driver.motion': 'rest'},
    )
    compass = ros.start('compass_driver', {'use_sim_time': True, 'common.executor': executor})
    clock = ros.publisher('/clock', Clock, 2)
    truth = ros.record('ground_truth/odom', Odometry)
    message = Clock()
    message.clock.sec = 100

    def tick():
        message.clock.nanosec += 10_000_000
        message.clock.sec += message.clock.nanosec // NANOSECONDS
        message.clock.nanosec %= NANOSECONDS
        clock.publish(message)
        return len(truth) > 10

    ros.until(tick, 'the driver')
    require_calm(ros, [driver, compass])
