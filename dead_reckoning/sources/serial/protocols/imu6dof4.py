"""SparkFun IMU 6DOF v4: an MMA7260Q, three gyroscopes and a magnetometer, 22 bytes a frame.

``A``, a count, then Mx My Mz Ax Ay Az Rx Ry Rz, then ``Z``: numbers of 16 bits, the high byte
first, from a converter of 10 bits at 3.3 V.  That is what a host program for it reads; the count,
and what the gyroscopes mean, are inferred, and so are settings.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import ClassVar

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.serial.frames import Frames
from dead_reckoning.sources.serial.protocols import Event, Measurement, Reading

BITS = 10
_FRAME = struct.Struct('>c10Hc')


@dataclass(frozen=True, kw_only=True)
class Imu6Dof4Settings(Settings, prefix='driver.serial.imu6dof4'):
    """SparkFun IMU 6DOF v4: what its count and its gyroscopes mean, which is unconfirmed."""

    counts: int = parameter(
        65_536, 'Frames after which the count of the board begins anew at 0; 0: there is no '
        'count, and what stands in its place is not looked at',
        minimum=0, maximum=65_536,
    )  # fmt: skip
    rate_zero: tuple[float, float, float] = parameter(
        (512.0, 512.0, 512.0), 'Counts of the gyroscopes x, y, z at rest',
        unit='counts', minimum=0.0, maximum=1023.0, length=3,
    )  # fmt: skip
    rate_sensitivity: tuple[float, float, float] = parameter(
        (58.7, 58.7, 58.7), 'Counts of the gyroscopes x, y, z per rad/s, negative where one turns '
        'the other way; by default 3.3 mV for each °/s',
        unit='counts/(rad/s)', minimum=-10_000.0, maximum=10_000.0, length=3,
    )  # fmt: skip

    def validate(self) -> None:
        """Raise `SettingsError` for a gyroscope that shows no rate."""
        if min(abs(value) for value in self.rate_sensitivity) < 1e-3:
            raise SettingsError(
                f'driver.serial.imu6dof4.rate_sensitivity: {list(self.rate_sensitivity)} is not '
                'allowed; at least 0.001 counts/(rad/s) of either sign'
            )


class Imu6Dof4Decoder(Frames):
    """Read accelerations in counts and rates of turn.

    ``A`` and ``Z`` may stand within a frame as well.  So a frame counts if the one before it was
    good and it goes on from that, in place and count; or if the next goes on from it.  A frame
    that comes twice is none.
    """

    Settings: ClassVar[type[Settings]] = Imu6Dof4Settings
    BITS = BITS
    FIRST = b'A'
    SHAPE = f'frame of an IMU 6DOF v4, A … Z in {_FRAME.size} bytes with a count that goes on'
    unit = 'counts'

    def __init__(self, settings: Imu6Dof4Settings) -> None:
        super().__init__()
        self._settings = settings
        self._count: int | None = None
        self._clock = 0

    def restart(self) -> list[Event]:
        """Forget the frame that has begun, and the count."""
        self._count = None
        return super().restart()

    def _read(self, data: bytes, at: int, events: list[Event]) -> int | None:
        if len(data) - at < _FRAME.size:
            return None
        channels = _channels(data, at)
        if channels is None:
            return 0
        count = channels[0]
        if not (self._in_step and self._follows(self._count, count)):
            if count == self._count and self._settings.counts:
                return 0
            if len(data) - at < 2 * _FRAME.size:
                return None
            following = _channels(data, at + _FRAME.size)
            if following is None or not self._follows(count, following[0]):
                return 0
        events.append(self._reading(channels, self._before + at))
        return _FRAME.size

    def _follows(self, first: int | None, second: int) -> bool:
        counts = self._settings.counts
        return not counts or (first is not None and second == (first + 1) % counts)

    def _reading(self, channels: tuple[int, ...], start: int) -> Reading:
        count, _, _, _, ax, ay, az, rx, ry, rz = channels
        settings = self._settings
        if settings.counts:
            self._clock += 0 if self._count is None else (count - self._count) % settings.counts
            self._count = count
        wx, wy, wz = (
            (turn - zero) / sensitivity
            for turn, zero, sensitivity in zip(
                (rx, ry, rz), settings.rate_zero, settings.rate_sensitivity, strict=True
            )
        )
        return Reading(
            (float(ax), float(ay), float(az)),
            start,
            float(self._clock) if settings.counts else None,
            (wx, wy, wz),
        )


def _channels(data: bytes, at: int) -> tuple[int, ...] | None:
    """Return count and channels of a frame; None for what is none."""
    first, *numbers, last = _FRAME.unpack_from(data, at)
    if first != b'A' or last != b'Z' or max(numbers[1:]) >= 1 << BITS:
        return None
    return tuple(numbers)


class Imu6Dof4Board:
    """Send each measurement as a frame; the magnetometer stands in the middle of its range."""

    def __init__(self, settings: Imu6Dof4Settings) -> None:
        self._settings = settings
        self._count = 0

    def hear(self, data: bytes) -> bytes:
        """Take no notice."""
        return b''

    def measure(self, measurement: Measurement) -> bytes:
        """Return a frame."""
        settings = self._settings
        turns = (
            zero + sensitivity * turn
            for turn, zero, sensitivity in zip(
                measurement.rate, settings.rate_zero, settings.rate_sensitivity, strict=True
            )
        )
        channels = (_converted(value) for value in (*measurement.values['counts'], *turns))
        frame = _FRAME.pack(b'A', self._count, 512, 512, 512, *channels, b'Z')
        self._count = (self._count + 1) % (settings.counts or 1 << 16)
        return frame


def _converted(value: float) -> int:
    return min(max(round(value), 0), (1 << BITS) - 1)


PROTOCOL, BOARD = Imu6Dof4Decoder, Imu6Dof4Board
