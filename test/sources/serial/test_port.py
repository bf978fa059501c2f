"""A real port (a pty) that is missing, taken, forbidden, unplugged and back."""

import fcntl
import gc
import os
import socket
import subprocess
import sys
import threading
import time
import tracemalloc
from contextlib import contextmanager

import pytest

from dead_reckoning.core.errors import (
    BusyPortError,
    LostPortError,
    MissingPortError,
    PortError,
    PortPermissionError,
)
from dead_reckoning.sources.serial import port as port_module
from dead_reckoning.sources.serial.port import Opened, Received, SerialPort
from dead_reckoning.sources.serial.settings import SerialSettings

DEADLINE = 20.0
NOBODY = 65534


class Events:
    """What a port has reported, in its order."""

    def __init__(self, path):
        self.all = []
        self.port = SerialPort(SerialSettings(port=str(path)), time.time_ns)

    def until(self, condition):
        """Wait until ``condition`` holds for the events, and return what it gives."""
        deadline = time.monotonic() + DEADLINE
        while not (found := condition()):
            assert time.monotonic() < deadline, self.all
            time.sleep(0.001)
            self.all += self.port.poll()
        return found

    def next(self, kind):
        """Wait for an event of a kind, forget those before it, and return it."""
        found = self.until(lambda: next((e for e in self.all if isinstance(e, kind)), None))
        self.all = self.all[self.all.index(found) + 1 :]
        return found

    @property
    def data(self):
        return b''.join(e.data for e in self.all if isinstance(e, Received))


@pytest.fixture
def opened():
    """Open ports, and see to it that their threads end in time."""
    ports = []

    def open_port(path):
        ports.append(Events(path))
        return ports[-1]

    yield open_port
    for events in ports:
        begun = time.monotonic()
        events.port.close()
        assert time.monotonic() - begun < 1.0
    assert not [t for t in threading.enumerate() if t.name == 'serial port']


@contextmanager
def without_rights():
    """Be nobody for a while, if one is root: root may open everything."""
    if os.geteuid():
        yield
        return
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)


def test_bytes_come_as_they_were_sent_with_the_time_of_their_arrival(board, opened):
    board.plug()
    events = opened(board.port)
    events.next(Opened)
    begun = time.time_ns()
    sent = bytes(range(256)) * 20
    board.send(sent)
    events.until(lambda: len(events.data) >= len(sent))
    assert events.data == sent
    arrivals = [e.arrival_ns for e in events.all]
    assert begun <= arrivals[0] <= arrivals[-1] <= time.time_ns()
    assert arrivals == sorted(arrivals)


def test_bytes_from_before_the_opening_are_not_read(board, opened):
    board.plug()
    board.send(b'old')
    events = opened(board.port)
    events.next(Opened)
    board.send(b'new')
    events.until(lambda: len(events.data) >= 3)
    assert events.data == b'new'


def test_a_board_is_told_what_is_sent_and_when(board, opened):
    board.plug()
    events = opened(board.port)
    events.next(Opened)
    begun = time.time_ns()
    stamp_ns = events.port.send(b'V')
    assert begun <= stamp_ns <= time.time_ns()
    assert events.until(board.hear) == b'V'


def test_what_can_not_be_told_is_not_told_and_no_error_of_the_sender(board, opened):
    events = opened(board.port)
    events.next(MissingPortError)
    assert events.port.send(b'V') is None
    board.plug()
    events.next(Opened)
    assert events.port.send(b'V') is not None
    board.unplug()
    assert events.until(lambda: events.port.send(b'V') is None)
    events.next(LostPortError)


def test_a_board_that_takes_nothing_does_not_hold_up_the_sender_or_the_end(board, opened):
    board.plug()
    events = opened(board.port)
    events.next(Opened)
    begun = time.monotonic()
    assert events.until(lambda: events.port.send(b'x' * 4096) is None)
    events.port.close(b'q')
    assert time.monotonic() - begun < 3.0


def test_goodbye_is_told_before_the_port_is_closed(board):
    board.plug()
    events = Events(board.port)
    events.next(Opened)
    events.port.close(b'A')
    assert board.hear() == b'A'
    assert events.port.send(b'V') is None


def test_tries_in_vain_become_rare(board, opened, monkeypatch):
    monkeypatch.setattr(port_module, 'RETRY', 0.1)
    monkeypatch.setattr(port_module, 'LONGEST_RETRY', 0.4)
    events = opened(board.port)
    time.sleep(1.6)  # tries after 0, 0.1, 0.3, 0.7, 1.1, 1.5 s
    assert 3 <= len(events.port.poll()) <= 6


def test_a_port_that_appears_is_tried_at_once(board, opened, monkeypatch):
    monkeypatch.setattr(port_module, 'RETRY', 1000.0)
    events = opened(board.port)
    events.next(MissingPortError)
    board.plug()
    events.next(Opened)


def test_plugged_in_and_out_a_thousand_times_nothing_is_left_behind(board, opened, monkeypatch):
    monkeypatch.setattr(port_module, 'RETRY', 0.002)
    monkeypatch.setattr(port_module, 'LOOK', 0.001)
    events = opened(board.port)

    def cycle():
        board.plug()
        events.next(Opened)
        board.send(b'1,2,3\n')
        events.port.send(b'V')
        events.next(Received)
        board.unplug()
        events.next(LostPortError)
        events.all.clear()

    def held():
        gc.collect()
        return len(os.listdir('/proc/self/fd')), threading.active_count()

    tracemalloc.start()
    try:
        for _ in range(50):
            cycle()
        before, (memory, _) = held(), tracemalloc.get_traced_memory()
        for _ in range(1000):
            cycle()
        after, (grown, _) = held(), tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after == before
    assert grown - memory < 50_000


def test_a_missing_port_is_named_with_what_to_do_and_read_once_it_is_there(board, opened):
    events = opened(board.port)
    error = events.next(PortError)
    assert type(error) is MissingPortError
    assert str(board.port) in str(error)
    assert 'driver.serial.port' in str(error)
    board.plug()
    events.next(Opened)


def test_an_unplugged_board_is_lost_until_it_is_back_as_another_device(board, opened):
    board.plug()
    events = opened(board.port)
    events.next(Opened)
    board.send(b'1,2')
    events.until(lambda: events.data == b'1,2')
    board.unplug()
    lost = events.next(PortError)
    assert type(lost) is LostPortError
    assert str(board.port) in str(lost)
    again = events.next(PortError)
    assert str(again) == str(lost)  # still lost, not a second kind of trouble
    board.plug()
    events.next(Opened)
    board.send(b'4,5')
    events.until(lambda: events.data == b'4,5')


def test_a_port_that_another_program_has_is_left_to_it_and_read_when_it_is_free(board, opened):
    board.plug()
    with board.port.open('rb', buffering=0) as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        events = opened(board.port)
        error = events.next(PortError)
        assert type(error) is BusyPortError
        assert f'fuser -v {board.port}' in str(error)
        assert f'(process {os.getpid()})' in str(error)
    events.next(Opened)


def test_no_second_owner_of_this_package(board, opened):
    board.plug()
    opened(board.port).next(Opened)
    assert type(opened(board.port).next(PortError)) is BusyPortError


def test_a_port_that_is_forbidden_says_how_to_be_allowed(board, opened, monkeypatch):
    """And is tried at once when it is allowed: udev sets the group after the port is there."""
    monkeypatch.setattr(port_module, 'RETRY', 1000.0)
    board.plug()
    path = board.port.resolve()
    path.chmod(0)
    with without_rights():
        events = opened(path)
        error = events.next(PortError)
    assert type(error) is PortPermissionError
    assert str(path) in str(error)
    assert 'dialout' in str(error)
    path.chmod(0o600)
    events.next(Opened)


def test_what_is_no_serial_port_is_refused_with_the_reason(tmp_path, opened):
    path = tmp_path / 'file'
    path.write_text('1,2,3\n')
    error = opened(path).next(PortError)
    assert type(error) is PortError
    assert str(path) in str(error)
    assert 'driver.serial.port' in str(error)


@pytest.mark.parametrize('path', ['/dev/null', '/', 'socket://nonsense', 'nonsense://'])
def test_strange_ports_end_in_an_error_and_not_in_the_end_of_the_thread(path, opened):
    events = opened(path)
    events.next(PortError)
    events.next(PortError)


def test_a_socket_of_a_serial_server_is_read_too(opened):
    with socket.create_server(('127.0.0.1', 0)) as server:
        events = opened(f'socket://127.0.0.1:{server.getsockname()[1]}')
        connection, _ = server.accept()
        with connection:
            events.next(Opened)
            connection.sendall(b'1,2,3\n')
            events.until(lambda: events.data == b'1,2,3\n')
            events.port.send(b'V')
            assert connection.recv(10) == b'V'
        assert type(events.next(PortError)) is LostPortError


def test_nothing_is_lost_while_nobody_takes_it_and_the_thread_still_ends(board, opened):
    """More chunks than may wait: the thread stops to read, the system keeps the rest."""
    board.plug()
    events = opened(board.port)
    events.next(Opened)
    sent = b'%06d\n' * 1500 % tuple(range(1500))
    for start in range(0, len(sent), 7):
        board.send(sent[start : start + 7])
        time.sleep(0.0003)
    events.until(lambda: len(events.data) >= len(sent))
    assert events.data == sent


@pytest.mark.parametrize('plugged', [False, True])
def test_waiting_costs_next_to_nothing(board, opened, plugged):
    if plugged:
        board.plug()
    events = opened(board.port)
    used, begun = time.process_time(), time.monotonic()
    while time.monotonic() < begun + 2.0:
        time.sleep(0.1)
        events.all += events.port.poll()
    assert time.process_time() - used < 0.1 * (time.monotonic() - begun)
    assert 1 <= len(events.all) <= (1 if plugged else 4)


def test_without_pyserial_all_but_the_port_works_and_the_port_says_what_to_install():
    program = """
import sys
sys.modules['serial'] = None  # what Python takes for a package that is not there
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.errors import DependencyError
from dead_reckoning.sources.driver import serial_receiver
serial_receiver(Configuration())
try:
    import dead_reckoning.sources.serial.port
except DependencyError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True)
    assert 'python3-serial' in done.stdout, done.stderr


def test_a_socket_is_told_goodbye_too():
    with socket.create_server(('127.0.0.1', 0)) as server:
        events = Events(f'socket://127.0.0.1:{server.getsockname()[1]}')
        connection, _ = server.accept()
        with connection:
            events.next(Opened)
            events.port.close(b'A')
            assert connection.recv(10) == b'A'
