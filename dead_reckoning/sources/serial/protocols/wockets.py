"""Frames of an MIT Wocket: five bytes, of which only the first has bit 7 set."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import ClassVar

from dead_reckoning.core.errors import CutError, FrameError
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.serial.protocols import Decoder, Event, Measurement, Reading

LENGTH = 5
"""Bytes of a frame."""

_FRAME = re.compile(rb'[\x80-\x9f][\x00-\x7f]{4}')
_BEGUN = re.compile(rb'[\x80-\x9f][\x00-\x7f]{0,3}\Z')


@dataclass(frozen=True, kw_only=True)
class WocketsSettings(Settings, prefix='driver.serial.wockets'):
    """Which of the sensors on the line is read."""

    id: int = parameter(
        -1, 'Number of the sensor that is read; -1 for whichever sends', minimum=-1, maximum=7
    )


class WocketsDecoder(Decoder):
    """Read frames of a number of 3 bits and counts of 10 bits.

    ``1 0 0 i i i x9 x8 | 0 x7…x1 | 0 x0 y9…y4 | 0 y3…y0 z9 z8 z7 | 0 z6…z0``.  A frame has neither
    a check nor a counter: bytes that are no frame are said once, until the next frame.  Those
    before the first are the rest of one that was cut.
    """

    Settings: ClassVar[type[Settings]] = WocketsSettings
    BITS = 10
    unit = 'counts'

    def __init__(self, settings: WocketsSettings) -> None:
        self._id = settings.id
        self._fed = 0
        self._pending = b''
        self._begin()

    def _begin(self) -> None:
        self._in_step = False
        self._said = False

    def feed(self, data: bytes) -> list[Event]:
        """Take the next bytes and return what the frames they complete hold."""
        waiting = self._pending + data
        start = self._fed - len(self._pending)
        self._fed += len(data)
        events: list[Event] = []
        done = 0
        for found in _FRAME.finditer(waiting):
            begin = found.start()
            if begin > done:
                self._skip(events)
            done = begin + LENGTH
            self._in_step, self._said = True, False
            a, b, c, d, e = found.group()
            if self._id in (-1, a >> 2 & 7):
                values = (
                    float((a & 3) << 8 | b << 1 | c >> 6),
                    float((c & 0x3F) << 4 | d >> 3),
                    float((d & 7) << 7 | e),
                )
                events.append(Reading(values, start + begin))
        tail = max(done, len(waiting) - LENGTH + 1)
        begun = _BEGUN.search(waiting, tail)
        self._pending = begun.group() if begun else b''
        end = len(waiting) - len(self._pending)
        if end > done:
            self._skip(events)
        return events

    def restart(self) -> list[Event]:
        """Forget the frame that has begun."""
        cut = bool(self._pending)
        self._pending = b''
        self._begin()
        return [_CUT] if cut else []

    def _skip(self, events: list[Event]) -> None:
        """Say once that bytes are no frame."""
        if not self._said:
            events.append(_NO_FRAME if self._in_step else _CUT)
            self._said = True


_CUT = CutError('a frame without its beginning or its end, where the port was opened or lost')
_NO_FRAME = FrameError(
    'bytes that are no frame of a Wocket: is driver.serial.protocol another, or '
    'driver.serial.baud, or is the line disturbed?'
)


class WocketsBoard:
    """Send each measurement as a frame."""

    def __init__(self, settings: WocketsSettings) -> None:
        self._id = max(settings.id, 0)

    def hear(self, data: bytes) -> bytes:
        """Take no notice."""
        return b''

    def measure(self, measurement: Measurement) -> bytes:
        """Return a frame, its counts kept within 10 bits."""
        x, y, z = (min(max(round(count), 0), 0x3FF) for count in measurement.values['counts'])
        return bytes(
            (
                0x80 | self._id << 2 | x >> 8,
                x >> 1 & 0x7F,
                (x & 1) << 6 | y >> 4,
                (y & 0xF) << 3 | z >> 7,
                z & 0x7F,
            )
        )


PROTOCOL, BOARD = WocketsDecoder, WocketsBoard
