"""The bench sees what gets lost or out of order, and takes a real relay's measure."""

import subprocess
import sys
from contextlib import ExitStack
from importlib.util import find_spec

import pytest

from benchmarks.cost import LEAN, LostError, Session, session

ONCE = """
import sys
for number, _ in enumerate(sys.stdin):
    print([] if number else {}, flush=True)
"""


def answering(text):
    """Return a process that answers its first line with a text, others with an empty list."""
    return subprocess.Popen(
        [sys.executable, '-c', ONCE.format(repr(text))],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def run(came):
    """Run traffic in which three Imu go out, and what comes is made up."""
    with ExitStack() as stack:
        ends = [stack.enter_context(answering(text)) for text in ('[1, 2, 3]', came)]
        stack.callback(lambda: [end.stdin.close() for end in ends])
        return Session(ends[0], *ends).run(3.0, 1.0)


def test_one_odometry_for_each_imu_is_no_loss():
    result = run('[[1, 1001], [2, 2002], [3, 3003]]')
    assert (result.sent, result.rate, result.lost) == (3, 3.0, 0)
    assert result.latency.tolist() == [1.0, 2.0, 3.0]


def test_loss_is_counted():
    assert run('[[1, 2], [3, 4]]').lost == 1


@pytest.mark.parametrize('came', ['[[1, 2], [3, 4], [2, 5]]', '[[1, 2], [2, 3], [2, 4], [3, 5]]'])
def test_another_order_or_more_than_one_is_refused(came):
    with pytest.raises(LostError):
        run(came)


def test_what_nobody_sent_is_refused():
    with pytest.raises(LostError):
        run('[[1, 2], [4, 5]]')


@pytest.mark.skipif(find_spec('rclpy') is None, reason='needs ROS 2')
def test_a_relay_gives_one_odometry_for_each_imu(domain_id, monkeypatch):
    monkeypatch.setenv('ROS_DOMAIN_ID', str(domain_id))
    with session(LEAN) as relay:
        relay.warm_up(0.1)
        result = relay.run(200.0, 1.0)
        hurried = relay.run(1e6, 0.2)
    assert result.lost == 0
    assert result.rate == pytest.approx(200.0, rel=0.05)
    assert 0.0 < result.latency.min() < 1e5
    assert 0.0 < result.cpu < 5000.0
    assert 0.0 < hurried.rate < 5e5, 'what no publisher reaches ends all the same'
