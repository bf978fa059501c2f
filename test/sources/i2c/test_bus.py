"""smbus2 is asked for what a transfer is: one message written, one read, in one go."""

import errno
import subprocess
import sys

import pytest


@pytest.fixture
def bus(monkeypatch):
    """Give a bus whose messages the test answers itself."""
    smbus2 = pytest.importorskip('smbus2')
    from dead_reckoning.sources.i2c.bus import LinuxBus

    done = []

    def rdwr(self, *messages):
        done.append([(m.addr, m.flags, bytes(m)) for m in messages])
        for message in messages:
            if message.flags & 1:
                for index in range(message.len):
                    message.buf[index] = bytes([0x10 + index])

    monkeypatch.setattr(smbus2.SMBus, 'open', lambda self, number: done.append(number))
    monkeypatch.setattr(smbus2.SMBus, 'i2c_rdwr', rdwr)
    bus = LinuxBus(1)
    assert done == [1]
    done.clear()
    return bus, done


def test_a_register_is_read_in_one_transfer(bus):
    bus, done = bus
    assert bus.transfer(0x53, b'\x32', 6) == bytes(range(0x10, 0x16))
    assert done == [[(0x53, 0, b'\x32'), (0x53, 1, bytes(6))]]


def test_a_write_and_a_read_alone(bus):
    bus, done = bus
    assert bus.transfer(0x21, b'A', 0) == b''
    assert bus.transfer(0x21, b'', 2) == b'\x10\x11'
    assert done == [[(0x21, 0, b'A')], [(0x21, 1, bytes(2))]]


def test_a_bus_that_is_not_there_is_an_error_of_the_system():
    pytest.importorskip('smbus2')
    from dead_reckoning.sources.i2c.bus import LinuxBus

    with pytest.raises(OSError, match='i2c-250') as caught:
        LinuxBus(250)
    assert caught.value.errno == errno.ENOENT


def test_without_smbus2_all_but_the_bus_works_and_the_bus_says_what_to_install():
    program = """
import sys
sys.modules['smbus2'] = None  # what Python takes for a package that is not there
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.errors import DependencyError
import dead_reckoning.sources.i2c.adxl345, dead_reckoning.sources.i2c.hmc6352
Configuration({'driver.source': 'i2c'})
try:
    import dead_reckoning.sources.i2c.bus
except DependencyError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True)
    assert 'python3-smbus2' in done.stdout, done.stderr
