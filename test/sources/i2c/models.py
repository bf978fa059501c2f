"""Sensors on an I²C bus as their registers answer, on a clock of their own.

They stand behind the bus: what is read and written, in which order and after which delays, is
checked against the data sheets.
"""

import errno
import math
from typing import ClassVar


class World:
    """A clock that a wait or a transfer moves on, in ns."""

    def __init__(self, transfer=200e-6):
        self.now_ns = 1_700_000_000_000_000_000
        self.transfer = transfer

    def wait(self, seconds):
        self.now_ns += round(seconds * 1e9)

    def now(self):
        return self.now_ns


class BusModel:
    """A bus with one device on it; `plugged` and `open` say how it fails."""

    def __init__(self, world, device):
        self.world = world
        self.device = device
        self.plugged = True
        self.opened = 0
        self.failure = None

    def __call__(self, number):
        if self.failure is not None:
            raise OSError(self.failure, 'no bus', f'/dev/i2c-{number}')
        assert number == 1
        self.opened += 1
        return self

    def transfer(self, address, written, count):
        assert written or count
        self.world.wait(0.5 * self.world.transfer)
        if not self.plugged or address != self.device.ADDRESS:
            raise OSError(errno.EREMOTEIO, 'Remote I/O error')
        answer = self.device.transfer(bytes(written), count)
        assert len(answer) == count
        self.world.wait(0.5 * self.world.transfer)
        return answer

    def close(self):
        self.opened -= 1


class Adxl345Model:
    """The registers of an ADXL345 that measures what `force` gives at a time [ns] [g]."""

    ADDRESS = 0x53
    SIZE = 0x3A
    READ_ONLY = frozenset((0x00, 0x30, *range(0x32, 0x38), 0x39))

    def __init__(self, world, force=lambda time_ns: (0.0, 0.0, 1.0), off=1.0):
        """`off` is how much faster its oscillator is than it says."""
        self.world = world
        self.force = force
        self.off = off
        self.times = []
        """When each sample that was read was converted."""
        self.reset()

    def reset(self):
        """Lose the supply."""
        self.registers = bytearray(self.SIZE)
        self.registers[0x00], self.registers[0x2C] = 0xE5, 0x0A
        self.fifo = []
        self.last = (0, b'\0' * 6)
        self.overruns = 0
        self.next_ns = None

    @property
    def rate(self):
        return 3200.0 * 2.0 ** ((self.registers[0x2C] & 0x0F) - 15) * self.off

    def transfer(self, written, count):
        self._convert()
        assert written, 'every read names its register here'
        register, values = written[0], written[1:]
        for address, value in enumerate(values, register):
            assert address not in self.READ_ONLY
            if address in (0x2C, 0x31):
                assert not self.registers[0x2D] & 0x08, 'it is set up in standby'
            self.registers[address] = value
            if address == 0x38 and value >> 6 == 0:
                self.fifo.clear()
            if address == 0x2D:
                self.next_ns = None
        if not count:
            return b''
        if register == 0x32:
            assert count == 6, 'the six bytes are read at once, or they are not one sample'
            assert self.fifo, 'read a sample twice'
            self.last = self.fifo.pop(0)
            self.times.append(self.last[0])
            return self.last[1]
        self.registers[0x39] = min(len(self.fifo), 33)
        return bytes(self.registers[register : register + count])

    def _convert(self):
        if not self.registers[0x2D] & 0x08:
            return
        assert self.registers[0x38] >> 6 == 2, 'the FIFO is in stream mode'
        period_ns = 1e9 / self.rate
        if self.next_ns is None:
            self.next_ns = self.world.now_ns + period_ns
        while self.next_ns <= self.world.now_ns:
            self.fifo.append((round(self.next_ns), self._data(self.next_ns)))
            if len(self.fifo) > 33:
                del self.fifo[0]
                self.overruns += 1
            self.next_ns += period_ns

    def _data(self, time_ns):
        form = self.registers[0x31]
        assert form & 0x08, 'full resolution'
        limit = 256 << (form & 0x03) + 1
        data = b''
        for value in self.force(time_ns):
            count = min(max(math.floor(256.0 * value + 0.5), -limit), limit - 1)
            if self.registers[0x2C] & 0x0F >= 0x0E:
                count &= ~1  # the lowest bit stays 0 at 1600 and 3200 Hz
            data += count.to_bytes(2, 'little', signed=True)
        return data


class Hmc6352Model:
    """The commands of an HMC6352 on a body with a heading [0.1°]."""

    ADDRESS = 0x21
    DELAYS: ClassVar = {b'A': 6000, b'G': 70, b'g': 70, b'C': 10, b'E': 14000}
    """Microseconds before the next transfer."""

    def __init__(self, world, heading=900):
        self.world = world
        self.heading = heading
        self.ram = {0x74: 0x50, 0x4E: 0x00}
        self.keeps = True
        self.log = []
        self.calibrating = False
        self._ready_ns = 0
        self._answer = b''

    def transfer(self, written, count):
        assert self.world.now_ns >= self._ready_ns, f'too soon after {self.log[-1]}'
        if written:
            assert not count, 'a command is a transfer of its own'
            command, arguments = written[:1], written[1:]
            self.log.append(written)
            self._ready_ns = self.world.now_ns + 1000 * self.DELAYS[command]
            self._obey(command, arguments)
            return b''
        answer, self._answer = self._answer, self._answer[:0]
        assert len(answer) == count, 'read something that no command asked for'
        return answer

    def _obey(self, command, arguments):
        if command == b'C':
            assert not self.calibrating
            self.calibrating = True
        elif command == b'E':
            self.calibrating = False
        else:
            assert not self.calibrating, 'it calibrates itself'
        if command == b'G':
            address, value = arguments
            if self.keeps:
                self.ram[address] = value
        elif command == b'g':
            (address,) = arguments
            self._answer = bytes([self.ram[address]])
        elif command == b'A':
            assert self.ram[0x74] == 0x72, 'continuous, set and reset, 20 Hz'
            self._answer = self.heading.to_bytes(2, 'big')
