"""What all tests share: checked messages, traffic on this machine only, ROS domains of their own.

The environment is set when this is imported, since message modules read theirs at import.
"""

import fcntl
import os
import signal
import socket
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest

DOMAINS = range(102)
"""Domains whose ports stay below those that Linux hands out to anyone."""

SHARED_MEMORY = Path('/dev/shm')

sys.path.insert(0, str(Path(__file__).parent))

os.environ['ROS_PYTHON_CHECK_FIELDS'] = '1'
os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ.pop('ROS_LOCALHOST_ONLY', None)
os.environ.setdefault('HOME', tempfile.gettempdir())
# A shell ignores Ctrl-C in what runs in its background, and so would all that tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def claimed_domain() -> Iterator[int]:
    """Hold a ROS domain that no other test process of this machine uses meanwhile.

    A locked file says that it is taken; a participant that is no test shows by its port.
    """
    for number in range(len(DOMAINS)):
        domain = DOMAINS[(os.getpid() + number) % len(DOMAINS)]
        path = Path(tempfile.gettempdir()) / f'dead_reckoning_test_domain_{domain}.lock'
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        except PermissionError:  # another user's
            continue
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            continue
        try:
            if _is_silent(domain):
                _clear(domain)
                yield domain
                return
        finally:
            os.close(descriptor)
    pytest.fail('no free ROS domain: are tests that hang running elsewhere?')


def _is_silent(domain: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # RTPS: the first participant of a domain listens here.
            probe.bind(('', 7400 + 250 * domain + 10))
        except OSError:
            return False
    return True


def _clear(domain: int) -> None:
    """Remove the shared memory of killed participants, on which new ones may hang for ever."""
    first = 7400 + 250 * domain
    for port in range(first, first + 250):
        for name in (f'fastrtps_port{port}', f'fastrtps_port{port}_el'):
            (SHARED_MEMORY / name).unlink(missing_ok=True)
        (SHARED_MEMORY / f'sem.fastrtps_port{port}_mutex').unlink(missing_ok=True)


@pytest.fixture
def domain_id():
    """Give a test a ROS domain of its own."""
    with claimed_domain() as domain:
        yield domain


@pytest.fixture(scope='module')
def module_domain_id():
    """Give the tests of a module that share processes a ROS domain of their own."""
    with claimed_domain() as domain:
        yield domain


@pytest.fixture
def board(tmp_path):
    """Give a test a board on a serial port, still unplugged."""
    from board import Board

    with Board(tmp_path) as board:
        yield board


@pytest.fixture(scope='module')
def other_module_domain_id():
    """Give the tests of a module a second domain, for what runs beside the first."""
    with claimed_domain() as domain:
        yield domain


@pytest.hookimpl(optionalhook=True)  # older pytest does not know it
def pytest_collect_directory(path, parent):
    """Skip the tests of the nodes, saying why, where there is no ROS."""
    if path == Path(__file__).parent / 'nodes' and find_spec('rclpy') is None:
        return WithoutRos.from_parent(parent, path=path)
    return None


class WithoutRos(getattr(pytest, 'Dir', object)):
    """A directory whose tests need rclpy, where it is missing."""

    def collect(self):
        pytest.skip(
            'rclpy is not importable: source ROS 2, or run make test', allow_module_level=True
        )
