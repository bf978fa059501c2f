"""The pseudo-terminal: a name that stays, bytes as they are, and nothing that waits for a host."""

import os
import time

import pytest
import serial

from dead_reckoning.core.errors import InputError
from dead_reckoning.tools.emulate.port import Port

EVERY = bytes(range(256))


@pytest.fixture
def link(tmp_path):
    return tmp_path / 'board'


def opened(port, timeout=2.0):
    return serial.Serial(port.name, timeout=timeout, exclusive=True)


def test_bytes_pass_as_they_are_both_ways():
    with Port() as port, opened(port) as host:
        port.write(EVERY)
        assert host.read(256) == EVERY
        host.write(EVERY)
        assert port.read(2.0) == EVERY
    assert port.lost == 0


def test_a_host_that_sets_nothing_gets_bytes_as_they_are():
    with Port() as port:
        host = os.open(port.name, os.O_RDWR | os.O_NOCTTY)
        port.write(EVERY)
        assert os.read(host, 1000) == EVERY
        os.close(host)


def test_what_nobody_reads_is_lost_at_once_and_counted():
    with Port() as port:
        port.write(EVERY)  # nobody has opened it
        assert port.lost == 256
        with opened(port) as host:
            begun = time.monotonic()
            for _ in range(4000):
                port.write(EVERY)
            assert time.monotonic() - begun < 2.0
            assert 4000 * 256 - 100_000 < port.lost - 256 < 4000 * 256
            host.read(host.in_waiting)
            host.read(host.in_waiting)
        lost = port.lost
        port.write(EVERY)
        assert port.lost == lost + 256


def test_reading_waits_its_time_whether_or_not_somebody_is_there():
    with Port() as port:
        begun = time.monotonic()
        for _ in range(10):
            assert port.read(0.005) == b''
        assert time.monotonic() - begun >= 0.05
        with opened(port):
            begun = time.monotonic()
            assert port.read(0.05) == b''
            assert 0.04 < time.monotonic() - begun < 1.0


def test_a_hang_up_is_felt_and_the_link_leads_to_the_port_that_comes_back(link):
    with Port(link) as port:
        assert port.name == str(link)
        with opened(port) as host:
            port.unplug()
            assert not link.is_symlink()
            with pytest.raises(serial.SerialException):
                host.read(1)
        port.write(EVERY)
        assert port.lost == 256
        assert port.read(0.0) == b''
        port.plug()
        with opened(port) as host:
            port.write(b'back')
            assert host.read(4) == b'back'
    assert not link.is_symlink()


def test_a_link_that_leads_nowhere_is_replaced(link):
    link.symlink_to('/dev/pts/of-a-killed-process')
    with Port(link) as port, opened(port):
        assert link.exists()


def test_what_else_has_the_name_is_refused_and_left_alone(link):
    link.write_text('mine')
    port = Port(link)
    with pytest.raises(InputError, match='name a path where nothing is'), port:
        pass
    assert link.read_text() == 'mine'


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match='No such file'), Port(tmp_path / 'no' / 'board'):
        pass


def test_the_link_of_another_is_not_removed(link):
    with Port(link):
        link.unlink()
        link.symlink_to('/dev/null')
    assert os.readlink(link) == '/dev/null'
