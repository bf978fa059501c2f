"""CH Robotics UM7: accelerations, rates of turn and orientation in packets of registers.

``s n p``, a byte that says how many registers of four bytes follow, the address of the first, the
registers, and the 16-bit sum of all bytes before it; the high byte first.  Source: data sheet
Rev 1.6.  Its axes are forward, right, down, its world is north, east, down; what becomes of them,
and which figures are unconfirmed, is in docs/devices/um7.md.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from math import asin, atan2, degrees, inf, radians, sqrt
from typing import Any, ClassVar

from dead_reckoning.core.errors import (
    CutError,
    HealthError,
    IncompleteError,
    OutOfRangeError,
)
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.rotation import (
    inverse,
    quaternion_from_euler,
    unit,
    yaw_from_quaternion,
)
from dead_reckoning.core.samples import Quaternion, Vector
from dead_reckoning.core.stages import IMU
from dead_reckoning.sources.serial.frames import Frames
from dead_reckoning.sources.serial.protocols import Event, Measurement, Reading

HEAD = b'snp'
HAS_DATA, BATCH, HIDDEN, FAILED = 0x80, 0x40, 0x02, 0x01
SHORTEST = 7
"""Bytes of a packet without a register."""

QUATERNION_UNIT = 29_789.09091
ANGLE_UNIT = 91.02222
"""Counts of 1 and of 1°."""

LARGEST = 1e4
"""No UM7 measures more g or °/s."""

HEALTH = 85
FAULTS = {
    8: 'it sends more than its baud rate allows, and packets are lost: lower its rates',
    3: 'its accelerometer fails',
    2: 'its gyroscope fails',
    1: 'its magnetometer fails',
}
"""What the bits of the health register mean; those about a GNSS and a disturbed field are left."""

_XYZ, _QUATERNION, _EULER = '>4f', '>4hf', '>3h10xf'
_RATE, _FORCE, _ATTITUDE = 97, 101, 109
_PARTS = {_RATE: 'rate of turn', _FORCE: 'acceleration', _ATTITUDE: 'attitude'}


@dataclass(frozen=True, kw_only=True)
class Um7Settings(Settings, prefix='driver.serial.um7'):
    """CH Robotics UM7: how its packets are read where that is unconfirmed."""

    attitude: str = parameter(
        'quaternion',
        'Where the orientation comes from: quaternion (registers 109 to 111, taken to turn the '
        'body into north, east, down), inverse (the same, turning back) or euler (112 to 116)',
        choices=('quaternion', 'inverse', 'euler'),
    )
    together: float = parameter(
        0.003, 'Packets make one reading if their times differ by no more; less than the time '
        'from one reading to the next',
        unit='s', minimum=0.0, maximum=1.0,
    )  # fmt: skip


class Um7Decoder(Frames):
    """Read accelerations in g, rates of turn and orientations.

    An instant is a rate, an acceleration and an attitude with the same time, in any order and in
    one packet or several; it becomes a reading as soon as it is whole.  What begins another one,
    by its time or because it is there already, ends it; if something is missing then, there is no
    reading of it.  The clock is the time of the acceleration [s], as the board has it.
    """

    Settings: ClassVar[type[Settings]] = Um7Settings
    OUTPUT = IMU
    FIRST = HEAD[:1]
    SHAPE = 'packet of a UM7, s n p … sum'
    unit = 'g'

    def __init__(self, settings: Um7Settings) -> None:
        super().__init__()
        self._settings = settings
        self._layouts = {
            _RATE: (_RATE, _XYZ),
            _FORCE: (_FORCE, _XYZ),
            _ATTITUDE: (112, _EULER) if settings.attitude == 'euler' else (109, _QUATERNION),
        }
        self._begin()

    def _begin(self) -> None:
        self._first = True
        self._instant: dict[int, Any] = {}
        self._time = self._clock = 0.0
        self._start = 0

    def restart(self) -> list[Event]:
        """Forget the packet and the instant that have begun."""
        self._begin()
        return super().restart()

    def _read(self, data: bytes, at: int, events: list[Event]) -> int | None:
        left = len(data) - at
        if not HEAD.startswith(data[at : at + len(HEAD)]):
            return 0
        if left <= len(HEAD):
            return None
        kind = data[at + len(HEAD)]
        registers = 0
        if kind & HAS_DATA:
            registers = kind >> 2 & 0xF if kind & BATCH else 1
        end = at + SHORTEST + 4 * registers
        if end > len(data):
            return None
        if sum(data[at : end - 2]) != int.from_bytes(data[end - 2 : end], 'big'):
            return 0
        if not kind & (HIDDEN | FAILED):
            self._take(data[at + 5 : end - 2], data[at + 4], self._before + at, events)
        return end - at

    def _take(self, registers: bytes, address: int, start: int, events: list[Event]) -> None:
        """Take the registers from an address on, in a packet that began at ``start``."""
        if address == HEALTH and registers:
            bits = int.from_bytes(registers[:4], 'big')
            events += [
                HealthError(f'the UM7 says that {fault}')
                for bit, fault in FAULTS.items()
                if bits >> bit & 1
            ]
        for part, (first, layout) in self._layouts.items():
            offset = 4 * (first - address)
            if 0 <= offset <= len(registers) - struct.calcsize(layout):
                *values, time = struct.unpack_from(layout, registers, offset)
                read = self._converted(part, values) if 0.0 <= time < inf else None
                if read is None:
                    shown = ', '.join(f'{value:g}' for value in (*values, time))
                    events.append(
                        OutOfRangeError(f'{shown} is no {_PARTS[part]} and time of a UM7')
                    )
                else:
                    self._add(part, read, time, start, events)

    def _converted(self, part: int, values: list[float]) -> Vector | Quaternion | None:
        """Return what registers say, in the frames of this package; None if they can not."""
        if part == _ATTITUDE:
            return self._attitude(values)
        if not all(abs(value) < LARGEST for value in values):
            return None
        x, y, z = values
        if part == _RATE:
            return (radians(x), -radians(y), -radians(z))
        return (x, -y, -z)

    def _attitude(self, values: list[float]) -> Quaternion | None:
        if self._settings.attitude == 'euler':
            roll, pitch, yaw = (radians(value / ANGLE_UNIT) for value in values)
            return turned(quaternion_from_euler(roll, pitch, yaw))
        w, x, y, z = (value / QUATERNION_UNIT for value in values)
        if not 0.9 < sqrt(w * w + x * x + y * y + z * z) < 1.1:
            return None
        found = unit((x, y, z, w))
        return turned(inverse(found) if self._settings.attitude == 'inverse' else found)

    def _add(
        self, part: int, read: Vector | Quaternion, time: float, start: int, events: list[Event]
    ) -> None:
        instant = self._instant
        # The time is a float of 32 bits: after 4.5 hours it goes on in steps of 2 ms.
        apart = self._settings.together + time * 2.0**-23
        if instant and (part in instant or abs(time - self._time) > apart):
            events.append(self._incomplete())
            instant.clear()
        if not instant:
            self._time, self._start = time, start
        instant[part] = read
        if part == _FORCE:
            self._clock = time
        if len(instant) == len(_PARTS):
            events.append(
                Reading(
                    instant[_FORCE], self._start, self._clock, instant[_RATE], instant[_ATTITUDE]
                )
            )
            instant.clear()
            self._first = False

    def _incomplete(self) -> CutError | IncompleteError:
        if self._first:
            self._first = False
            return CutError('an instant of which only the end came, where the port was opened')
        missing = ' and '.join(
            f'{_PARTS[part]} (registers {first} to {first + struct.calcsize(layout) // 4 - 1})'
            for part, (first, layout) in self._layouts.items()
            if part not in self._instant
        )
        return IncompleteError(
            f'an instant of the UM7 without {missing}: lost, or not sent at the rate of the rest, '
            'or driver.serial.um7.together is too small'
        )


def turned(quaternion: Quaternion) -> Quaternion:
    """Turn an attitude of forward, right, down in north, east, down into one of this package.

    That is forward, left, up in east, north, up; the same way leads back.
    """
    x, y, z, w = quaternion
    h = sqrt(0.5)
    return (h * (x + y), h * (x - y), h * (w - z), h * (w + z))


class Um7Board:
    """Send each measurement as two packets: all that is processed, and the attitude.

    It has no magnetometer, and all of an instant has the same time.
    """

    def __init__(self, settings: Um7Settings) -> None:
        self._settings = settings

    def hear(self, data: bytes) -> bytes:
        """Take no notice."""
        return b''

    def measure(self, measurement: Measurement) -> bytes:
        """Return both packets."""
        time = measurement.time
        x, y, z = measurement.values['g']
        wx, wy, wz = (degrees(turn) for turn in measurement.rate)
        processed = (
            struct.pack(_XYZ, wx, -wy, -wz, time)
            + struct.pack(_XYZ, x, -y, -z, time)
            + struct.pack(_XYZ, 0.0, 0.0, 0.0, time)
        )
        attitude = turned(measurement.orientation)
        if self._settings.attitude == 'euler':
            angles = (round(degrees(angle) * ANGLE_UNIT) for angle in _euler(attitude))
            return packet(_RATE, processed) + packet(112, struct.pack(_EULER, *angles, time))
        if self._settings.attitude == 'inverse':
            attitude = inverse(attitude)
        qx, qy, qz, qw = (round(part * QUATERNION_UNIT) for part in attitude)
        return packet(_RATE, processed) + packet(
            109, struct.pack(_QUATERNION, qw, qx, qy, qz, time)
        )


def packet(address: int, registers: bytes) -> bytes:
    """Return the packet of several registers, from an address on."""
    kind = HAS_DATA | BATCH | len(registers) // 4 << 2
    head = HEAD + bytes((kind, address)) + registers
    return head + sum(head).to_bytes(2, 'big')


def _euler(quaternion: Quaternion) -> Vector:
    """Return roll, pitch and yaw [rad] of a quaternion, as `quaternion_from_euler` takes them."""
    x, y, z, w = quaternion
    roll = atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
    return (roll, pitch, yaw_from_quaternion(quaternion))


PROTOCOL, BOARD = Um7Decoder, Um7Board
