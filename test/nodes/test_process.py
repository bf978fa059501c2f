"""Start and end of the nodes as processes: clean on Ctrl-C and SIGTERM, whenever they come."""

import signal
import sys
import time
from itertools import cycle
from pathlib import Path

import pytest
from ros_harness import DEADLINE, EXECUTORS, NODES, NodeProcess

SECONDS = 5.0
"""How long an end may take, on a busy machine too."""

SIGNALS = {
    'ctrl-c': (signal.SIGINT,),
    'sigterm': (signal.SIGTERM,),
    'ctrl-c twice': (signal.SIGINT, signal.SIGINT),  # as ros2 launch sends it
}
DELAYS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.45)
"""From the moment the executables listen to signals [s]; their imports take about 0.3 s."""


@pytest.mark.parametrize('sent', SIGNALS)
def test_a_signal_ends_a_running_node(ros, sent):
    started = {}
    for executor in EXECUTORS:
        for name in NODES:
            # A namespace each: two nodes on one topic would have something to say.
            space = f'/{executor}/alone_{name}'
            parameters = {'common.executor': executor}
            started[f'{space}/{name}'] = ros.start(name, parameters, '-r', f'__ns:={space}')
    for name, node in started.items():
        assert ros.get(name, 'common.executor') == [name.split('/')[1]]
        assert node.running
    for node in started.values():
        begin = time.monotonic()
        assert node.end(*SIGNALS[sent]) == 0, node.stderr
        assert time.monotonic() - begin < SECONDS
        assert node.stdout == ''
        assert node.stderr == ''


def listens(node):
    """Say whether a process handles SIGTERM: Python itself does not, `run` does first of all."""
    status = Path(f'/proc/{node.process.pid}/status').read_text()
    mask = int(status.partition('SigCgt:')[2].split()[0], 16)
    return mask >> (signal.SIGTERM - 1) & 1


@pytest.mark.skipif(sys.platform != 'linux', reason='only /proc tells when a process listens')
@pytest.mark.parametrize('delay', DELAYS)
def test_ctrl_c_while_it_starts_ends_a_node(domain_id, tmp_path, delay):
    started = [
        NodeProcess(name, domain_id, tmp_path / name, {'common.executor': executor})
        for name, executor in zip(NODES, cycle(EXECUTORS))
    ]
    deadline = time.monotonic() + DEADLINE
    while not all(listens(node) for node in started):
        assert time.monotonic() < deadline
        time.sleep(0.001)
    time.sleep(delay)
    for count, node in enumerate(started):
        signals = (signal.SIGINT,) * (1 + count // 2)
        assert node.end(*signals) == 0, node.stderr
        assert node.stderr == ''
