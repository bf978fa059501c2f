"""Lines of text out of bytes, for the protocols that send them."""

from __future__ import annotations

import re
from abc import abstractmethod

from dead_reckoning.core.errors import CutError, GarbledError, OverlongError, ReadingError
from dead_reckoning.sources.serial.protocols import Decoder, Event, Reading

LONGEST = 256
"""Bytes of the longest line that is read."""

SHOWN = 40
"""Characters of a line that an error shows."""

_LINE_END = re.compile(rb'[\r\n]')
_UNPRINTABLE = re.compile(rb'[^\t\x20-\x7e]')
_CUT = CutError('a line without its beginning or its end, where the port was opened or lost')


class LineDecoder(Decoder):
    """Find lines that end in CR, LF or both; a subclass says what is in one.

    Whatever a line is, it costs that line alone, and becomes the error that says why.  Blank lines
    are nothing.  The first line after a start may lack its beginning without showing it, so it is
    never a reading.
    """

    def __init__(self) -> None:
        self._fed = 0
        self._begin(in_step=False)

    @abstractmethod
    def _reading(self, text: str, start: int) -> Reading:
        """Return the reading in a line that began at a byte, or raise a `ReadingError`."""

    def _begin(self, *, in_step: bool) -> None:
        self._in_step = in_step
        self._line = bytearray()
        self._length = 0

    def feed(self, data: bytes) -> list[Event]:
        """Take the next bytes and return the readings and errors of the lines they complete."""
        *ends, rest = _LINE_END.split(data)
        events: list[Event] = []
        for part in ends:
            events += self._extend(part)
            events += self._end()
            self._fed += 1
            self._begin(in_step=True)
        return events + self._extend(rest)

    def restart(self) -> list[Event]:
        """Forget the line that has begun."""
        cut = self._length > 0
        self._begin(in_step=False)
        return [_CUT] if cut else []

    def _extend(self, part: bytes) -> list[Event]:
        """Add to the line, and say it once when that makes it too long."""
        before = self._length
        self._length += len(part)
        self._fed += len(part)
        self._line += part[: max(0, LONGEST - before)]
        if before <= LONGEST < self._length:
            return [
                OverlongError(
                    f'no end of line in {LONGEST} bytes: driver.serial.baud does not fit, or the '
                    'board does not send lines'
                )
            ]
        return []

    def _end(self) -> list[Event]:
        if self._length > LONGEST:
            return []  # said already
        line = bytes(self._line)
        if not line.strip():
            return []
        if not self._in_step:
            return [_CUT]
        if _UNPRINTABLE.search(line):
            return [
                GarbledError(
                    f'{line[:SHOWN]!r} is no text: driver.serial.baud or driver.serial.protocol '
                    'does not fit, or the line is disturbed'
                )
            ]
        try:
            return [self._reading(line.decode('ascii').strip(), self._fed - self._length)]
        except ReadingError as error:
            return [error]
