"""SparkFun's WiTilt v3: binary frames with a counter, started and stopped through a menu.

A frame is ``# @ count X Y Z [battery] [rate] $``, a number in two bytes, the high one first, those
of the converter of 10 bits.  The low byte of the count has been seen to leave out 0x0A.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import ClassVar

from dead_reckoning.core.errors import BoardError, CutError, FrameError, SettingsError
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.samples import Vector
from dead_reckoning.core.sensors.mma7260qt import PART
from dead_reckoning.sources.serial.protocols import Decoder, Event, Measurement, Reading

CHANNELS = ('xyz', 'xyzr', 'xyzb', 'xyzbr')
"""What a frame may hold, a letter each."""

SCRIPT = (b'A', b'x', b' ', b'1', b'S')
"""What the board is told, one after the other: stop, leave the menu, show it, begin."""

PAUSE = 0.3
"""Time [s] from one of these to the next."""

SILENCE = 1.0
"""Time [s] without a frame after which the board is told to begin again."""

FULL = 0x3FF
"""Largest number of a converter of 10 bits."""

WRAP = 0x10000
"""The count begins anew here."""

LOST = 250
"""A count that goes on by more, or back, is believed only when the next one follows on it."""

LONGEST = 32
"""Bytes that may have to be kept: the longest frame or line of the menu that is read."""

MENU = 1024
"""As many bytes without a frame are no menu any more."""


@dataclass(frozen=True, kw_only=True)
class Witilt3Settings(Settings, prefix='driver.serial.witilt3'):
    """A WiTilt v3 in its binary mode."""

    range_g: float = parameter(
        1.5, 'Range that is set in the menu of the board, ±; driver.range_g is the same',
        unit='g', choices=tuple(PART.ranges),
    )  # fmt: skip
    channels: str = parameter(
        'xyzr',
        'What a frame holds, as set in the menu of the board: x, y, z, b for the battery, r for '
        'the rate of turn',
        choices=CHANNELS,
    )
    menu: bool = parameter(
        True,
        'Whether the board is started and stopped through its menu; else it has to send by itself',
    )
    rate_axis: str = parameter(
        '-',
        'Axis round which its one gyroscope measures; the rates round the others are given as 0 '
        'then, which is right only for what stays level. - for none: the rate is not used',
        choices=('-', 'x', 'y', 'z'),
    )
    rate_zero: float = parameter(
        512.0, 'Count of the rate at rest', unit='counts', minimum=0.0, maximum=1023.0,
    )  # fmt: skip
    rate_scale: float = parameter(
        0.0064, 'A count of the rate; negative turns the sign',
        unit='rad/s per count', minimum=-1.0, maximum=1.0,
    )  # fmt: skip

    def validate(self) -> None:
        """Raise `SettingsError` for a rate that no frame holds."""
        if self.rate_axis != '-' and 'r' not in self.channels:
            raise SettingsError(
                f'driver.serial.witilt3.rate_axis: {self.rate_axis!r} needs an r, which '
                f'driver.serial.witilt3.channels {self.channels!r} lack; set one of the two'
            )

    def rate(self, count: float) -> Vector:
        """Return the rate of turn [rad/s], frame s, of a count."""
        rate = (count - self.rate_zero) * self.rate_scale
        x, y, z = (rate if axis == self.rate_axis else 0.0 for axis in 'xyz')
        return (x, y, z)


class Witilt3Decoder(Decoder):
    """Start the board and find its frames by their length, both ends and the range of the numbers.

    Letters of the frame may occur in it, so a frame counts only as a whole, and if its count
    follows.  The clock is the running number of the conversion: the count, unwrapped, without the
    0x0A that it leaves out, until one shows that it does not.  It goes back where the board counts
    anew.  A board that falls silent is started again.  What comes before the first frame is the
    menu; its range is compared.
    """

    Settings: ClassVar[type[Settings]] = Witilt3Settings
    BITS: ClassVar[int | None] = 10

    def __init__(self, settings: Witilt3Settings) -> None:
        self.unit = 'counts'
        self.range_g = settings.range_g
        self._settings = settings
        numbers = len(settings.channels)
        self._rate_at = 2 * settings.channels.find('r') if settings.rate_axis != '-' else -1
        self._frame = re.compile(
            rb'#@(..)((?:[\x00-\x03].){%d})\$|Range \(([0-9.]{1,4})g\)' % numbers, re.DOTALL
        )
        self._fed = 0
        self._begin()

    def _begin(self) -> None:
        self._kept = b''
        self._skipped = 0
        self._said = False
        self._in_step = False
        self._last: int | None = None
        self._doubted: int | None = None
        self._clock = 0
        self._leaves_out = True
        self._step = 0
        self._heard = False
        self._heard_at = 0.0

    def feed(self, data: bytes) -> list[Event]:
        """Take the next bytes and return the readings of the frames they complete."""
        events: list[Event] = []
        kept = self._kept + data
        start = self._fed - len(self._kept)
        self._fed += len(data)
        at = 0
        for found in self._frame.finditer(kept):
            events += self._skip(found.start() - at)
            at = found.end()
            if found[3] is not None:
                events += self._compare(found[3])
                continue
            if self._skipped and not self._said:
                events.append(_DAMAGED if self._in_step else _CUT)
            self._skipped, self._said, self._in_step = 0, False, True
            events += self._take(found, start + found.start())
        end = max(at, len(kept) - LONGEST)
        self._kept = kept[end:]
        return events + self._skip(end - at)

    def _skip(self, count: int) -> list[Event]:
        """Take note of bytes that are no frame, and say it once when there are too many."""
        self._skipped += count
        if self._said or self._skipped <= (0 if self._in_step else MENU):
            return []
        self._said = True
        return [_DAMAGED]

    def _compare(self, range_: bytes) -> list[Event]:
        """Compare the range that the menu shows."""
        try:
            if float(range_) == self.range_g:
                return []
        except ValueError:  # not the menu
            return []
        return [
            BoardError(
                f'the menu of the board says ±{range_.decode()} g, '
                f'driver.serial.witilt3.range_g ±{self.range_g:g} g: set one of them'
            )
        ]

    def _take(self, found: re.Match[bytes], start: int) -> list[Event]:
        """Take a frame that is whole."""
        count, numbers = int.from_bytes(found[1], 'big'), found[2]
        before = self._last if self._doubted is None else self._doubted
        if not (_follows(self._last, count) or _follows(before, count)):
            self._doubted = count
            return [_DOUBTED]
        self._heard, self._doubted = True, None
        self._count(count)
        x, y, z = (float(int.from_bytes(numbers[k : k + 2], 'big')) for k in (0, 2, 4))
        rate = None
        if self._rate_at >= 0:
            raw = numbers[self._rate_at : self._rate_at + 2]
            rate = self._settings.rate(int.from_bytes(raw, 'big'))
        return [Reading((x, y, z), start, float(self._clock), rate)]

    def _count(self, count: int) -> None:
        """Let the clock go on."""
        if count & 0xFF == 0x0A:
            self._leaves_out = False
        last = self._last
        self._last = count
        if last is not None and (count - last) % WRAP < WRAP // 4:
            end = last + (count - last) % WRAP
            self._clock += end - last
            if self._leaves_out:
                self._clock -= _left_out(end) - _left_out(last)
        else:
            self._clock = count

    def due(self, waited: float) -> bytes:
        """Return what starts the board, and again when it has fallen silent."""
        if not self._settings.menu:
            return b''
        if self._step == len(SCRIPT):
            if self._heard:
                self._heard, self._heard_at = False, waited
            if waited - self._heard_at <= SILENCE:
                return b''
            self._step = 0
        elif waited < PAUSE:
            return b''
        told = SCRIPT[self._step]
        self._step += 1
        self._last = None  # it counts anew
        self._heard, self._heard_at = False, 0.0
        return told

    def goodbye(self) -> bytes:
        """Return what stops the board and leaves its menu."""
        return b'Ax' if self._settings.menu else b''

    def restart(self) -> list[Event]:
        """Forget the frame that has begun; the board is started anew."""
        cut = self._in_step and (self._kept != b'' or self._skipped > 0)
        self._begin()
        return [_CUT] if cut else []


def _follows(last: int | None, count: int) -> bool:
    return last is None or 0 < (count - last) % WRAP <= LOST


def _left_out(count: int) -> int:
    """Return how many counts up to one have the low byte 0x0A."""
    return (count + 0x100 - 0x0A) // 0x100


_DAMAGED = FrameError(
    'bytes that are no frame: driver.serial.witilt3.channels, driver.serial.baud or the binary '
    'mode in the menu of the board does not fit, or the line is disturbed'
)
_DOUBTED = FrameError(
    'a frame whose count does not follow on the one before: disturbed, come twice, or after a gap'
)
_CUT = CutError('bytes before the first frame: the menu, or a frame without its beginning')


class Witilt3Board:
    """Show a menu, and send a frame for each measurement once it is told to begin."""

    BATTERY: ClassVar[int] = 700

    def __init__(self, settings: Witilt3Settings) -> None:
        self._settings = settings
        self._state = 'idle'
        self._sent = 0

    def hear(self, data: bytes) -> bytes:
        """Return what the board writes on its terminal."""
        return b''.join(self._hear(data[i : i + 1]) for i in range(len(data)))

    def _hear(self, letter: bytes) -> bytes:
        if self._state == 'sampling':
            if letter == b'A':
                self._state = 'idle'
                return self._menu()
        elif letter == b'1':
            self._state = 'ready'
            return b'\r\nS starts, A aborts, x exits\r\n'
        elif letter == b'S' and self._state == 'ready':
            self._state, self._sent = 'sampling', 0
        elif letter in b' x':
            self._state = 'idle'
            return self._menu() if letter == b' ' else b''
        return b''

    def _menu(self) -> bytes:
        settings = self._settings
        letters = settings.channels.upper()
        return (
            f'\r\nWiTilt v3, emulated\r\n1) Start\r\nMode (Binary)\r\n'
            f'Channels ({letters} Active)\r\nSensor Range ({settings.range_g:g}g)\r\n'
        ).encode()

    def measure(self, measurement: Measurement) -> bytes:
        """Return a frame, or nothing before it is told to begin."""
        if self._state != 'sampling':
            return b''
        self._sent = (self._sent + 1) % WRAP
        if self._sent & 0xFF == 0x0A:
            self._sent += 1
        settings = self._settings
        numbers = list(measurement.values['counts'])
        for channel in settings.channels[3:]:
            numbers.append(self.BATTERY if channel == 'b' else self._rate(measurement.rate))
        raw = b''.join(_number(number).to_bytes(2, 'big') for number in numbers)
        return b'#@' + self._sent.to_bytes(2, 'big') + raw + b'$'

    def _rate(self, rate: Vector) -> float:
        settings = self._settings
        axis = 'xyz'.find(settings.rate_axis)
        if axis < 0 or settings.rate_scale == 0.0:
            return settings.rate_zero
        return settings.rate_zero + rate[axis] / settings.rate_scale


def _number(value: float) -> int:
    return min(max(math.floor(value + 0.5), 0), FULL)


PROTOCOL, BOARD = Witilt3Decoder, Witilt3Board
