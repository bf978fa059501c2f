"""Compiled code comes in beside the traffic, and nothing waits for it."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

import pytest
from geometry_msgs.msg import AccelWithCovarianceStamped
from messages import GRAVITY, NANOSECONDS, Feed, imu_message
from nav_msgs.msg import Odometry
from ros_harness import NODES, lossless, taken
from sensor_msgs.msg import Imu

from dead_reckoning.live import IntegratorChain
from dead_reckoning.nodes.loading import COMPILE

SETTINGS = {
    'gravity.attitude': 'message',
    'pipeline.estimators': ['integrator', 'pedometer'],
    'pedometer.input': 'imu/data',
    'pedometer.method': 'an900',  # for which nothing has to be compiled
}


@pytest.mark.parametrize('name', [name for name in NODES if name != 'pipeline'])
def test_other_nodes_do_not_import_numba(name):
    code = (
        'import sys\n'
        f'import dead_reckoning.nodes.{name}\n'
        "print([module for module in sys.modules if module.startswith(('numba', 'llvmlite'))])"
    )
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    found = subprocess.run([sys.executable, '-c', code], env=environment, stdout=subprocess.PIPE)
    assert found.stdout.split() == [b'[]']


@pytest.fixture
def running(ros):
    """A pipeline that gets samples at rest, and what it says."""
    node = ros.start('pipeline', {**SETTINGS, **lossless('/odom', '/imu/data')})
    odom, said = ros.record('odom', Odometry).connected(), ros.diagnostics()
    publisher = ros.publisher('imu/data', Imu)
    feed = Feed(
        ros,
        lambda stamp_ns, push=0.0: publisher.publish(
            imu_message(stamp_ns, (push, 0.0, GRAVITY), (0.0, 0.0, 0.0, 1.0))
        ),
    )
    feed.send_until(lambda: odom.messages, 'odometry')
    return node, odom, said, feed


def test_services_and_parameters_act_on_what_compiled_code_has_reached(ros, running):
    pytest.importorskip('numba')
    IntegratorChain.compile()
    _, odom, said, feed = running
    feed.send_until(lambda: taken(said) > 100, 'compiled code')
    begun = odom.messages[-1].pose.pose.position.x
    for _ in range(200):
        feed.send(1.0)
    ros.until(lambda: odom.latest_stamp == feed.stamp_ns, 'the last odometry')
    moved = odom.messages[-1]
    assert moved.pose.pose.position.x == pytest.approx(begun + 0.5, rel=0.02)
    assert moved.twist.twist.linear.x == pytest.approx(1.0, rel=0.02)

    (result,) = ros.set('pipeline', integrator__window_maximum=2.0)
    assert result.successful
    for _ in range(200):
        feed.send(1.0)  # inside the window now, so the speed stays until the movement ends
    ros.until(lambda: odom.latest_stamp == feed.stamp_ns, 'the last odometry')
    assert odom.messages[-1].twist.twist.linear.x == 0.0

    assert ros.trigger('pipeline/reset').success
    feed.send()
    ros.until(lambda: odom.latest_stamp == feed.stamp_ns, 'the first odometry after the reset')
    assert odom.messages[-1].pose.pose.position.x == 0.0


def test_a_subscriber_between_gets_its_topic_and_the_odometry_goes_on(ros, running):
    pytest.importorskip('numba')
    IntegratorChain.compile()
    _, odom, said, feed = running
    feed.send_until(lambda: taken(said) > 0, 'compiled code')
    between = ros.record('imu/linear_acceleration', AccelWithCovarianceStamped)
    feed.send_until(lambda: between.messages, 'what lies between')
    between.stop()
    count = taken(said)
    feed.send_until(lambda: taken(said) > count + 100, 'compiled code again')
    ros.until(lambda: odom.latest_stamp == feed.stamp_ns, 'the last odometry')
    steps = {b - a for a, b in pairwise(odom.stamps)}
    assert steps == {NANOSECONDS // 200}


def command(process):
    """Return the command line of a process, of one that ended nothing: numpy asks lscpu."""
    with suppress(OSError):
        return (process / 'cmdline').read_bytes()
    return b''


def test_where_nothing_is_kept_it_starts_at_once_and_ends_while_compiling(
    ros, tmp_path, monkeypatch, request
):
    pytest.importorskip('numba')
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path / 'empty'))
    node, _, said, feed = request.getfixturevalue('running')

    def compilers():
        tasks = Path(f'/proc/{node.process.pid}/task').glob('*/children')
        children = [Path(f'/proc/{pid}') for each in tasks for pid in each.read_text().split()]
        return [child for child in children if COMPILE.encode() in command(child)]

    feed.send_until(compilers, 'the compiler')
    feed.send_until(lambda: said.of('pipeline'), 'figures')
    assert taken(said) == 0
    (compiler,) = compilers()
    assert node.end(signal.SIGINT) == 0
    assert 'Traceback' not in node.stderr
    assert not compiler.exists()


@pytest.mark.parametrize('name', ['inertial_navigator', 'pedometer', 'pipeline'])
def test_what_has_to_compile_first_hears_a_signal(ros, tmp_path, monkeypatch, name):
    pytest.importorskip('numba')
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path / 'empty'))
    node = ros.start(name, {'pipeline.estimators': ['pedometer']} if name == 'pipeline' else None)
    ros.until(lambda: 'compiling the kernels' in node.stderr, 'the compiler')
    begin = time.monotonic()
    assert node.end(signal.SIGINT) == 0
    assert time.monotonic() - begin < 5.0
    assert node.stderr.count('\n') == 1


@pytest.mark.parametrize('method', ['an900', 'rhythm'])
def test_without_numba_it_says_so_once_and_goes_on(tmp_path, monkeypatch, request, method):
    monkeypatch.setitem(SETTINGS, 'pedometer.method', method)
    (tmp_path / 'numba.py').write_text('raise ImportError')
    path = os.pathsep.join([str(tmp_path), os.environ.get('PYTHONPATH', '')])
    monkeypatch.setenv('PYTHONPATH', path)
    node, _, said, feed = request.getfixturevalue('running')
    feed.send_until(lambda: 'numba is not there' in node.stderr, 'the reason')
    feed.send_until(lambda: said.of('pipeline'), 'figures')
    assert taken(said) == 0
    assert node.end(signal.SIGINT) == 0
    assert node.stderr.count('numba is not there') == 1


@pytest.mark.parametrize('name', ['pedometer', 'pipeline'])
def test_what_finds_steps_is_there_before_the_first_sample(name):
    pytest.importorskip('numba')
    code = (
        'import sys, rclpy\n'
        f'from dead_reckoning.nodes.{name} import NODE\n'
        'from dead_reckoning.core import kernels\n'
        'made = []\n'
        'kernels.load = lambda kernel, *arguments: True\n'
        'kernels._kept = lambda function: (made.append(function.__qualname__), function)[1]\n'
        "rclpy.init(args=['--ros-args', '-p', 'pipeline.estimators:=[pedometer]'])\n"
        'node = NODE()\n'
        'print(*made)\n'
    )
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}
    found = subprocess.run([sys.executable, '-c', code], env=environment, stdout=subprocess.PIPE)
    assert found.stdout.split() == [b'add', b'take', b'finish']
