"""Lines of text, one reading each: numbers in columns, as ``512,498,830``."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import ClassVar

from dead_reckoning.core.accelerometer import UNITS
from dead_reckoning.core.errors import (
    ColumnError,
    CutError,
    GarbledError,
    NumberError,
    OverlongError,
    ReadingError,
    SettingsError,
)
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.samples import Vector
from dead_reckoning.sources.serial.protocols import Decoder, Event, Measurement, Reading

LONGEST = 256
"""Bytes of the longest line that is read."""

LARGEST = 1e9
"""No sensor sends a larger number."""

SHOWN = 40
"""Characters of a line that an error shows."""


@dataclass(frozen=True, kw_only=True)
class AsciiSettings(Settings, prefix='driver.serial.ascii'):
    """Lines of text with a number in each column, as 512,498,830."""

    columns: str = parameter(
        'xyz',
        'What the columns of a line hold, a letter each: x, y, z, and - for one that is not used',
    )
    separator: str = parameter(
        ',', 'What stands between two columns; a space means any run of spaces and tabs'
    )
    unit: str = parameter('counts', 'Unit of the numbers', choices=UNITS)

    def validate(self) -> None:
        """Raise `SettingsError` for columns or a separator with which no line can be read."""
        if sorted(self.columns.replace('-', '')) != ['x', 'y', 'z']:
            raise SettingsError(
                f'driver.serial.ascii.columns: {self.columns!r} is not allowed; x, y and z once '
                "each, and - for every other column, as 'xyz' or '-xyz'"
            )
        if not re.fullmatch(r'[^\w.+\-\\\r\n]+', self.separator, re.ASCII):
            raise SettingsError(
                f'driver.serial.ascii.separator: {self.separator!r} is not allowed; something '
                "that is no part of a number or a name, as ',' or ';' or ' '"
            )


_LINE_END = re.compile(rb'[\r\n]')
_UNPRINTABLE = re.compile(rb'[^\t\x20-\x7e]')
_NUMBER = re.compile(
    r'\s*(?:[A-Za-z]\w*\s*[:=]\s*)?'  # a label
    r'([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*',
    re.ASCII,
)


class AsciiDecoder(Decoder):
    """Read x, y, z from lines that end in CR, LF or both; a number may have a label, as ``X: 1``.

    A line is a reading only if all of it is in order: as many columns as ``columns`` says, a
    number in each that is used.  Whatever else it is, it costs that line alone, and becomes the
    error that says why.  Blank lines are nothing.  The first line after a start may lack its
    beginning without showing it, so it is never a reading.
    """

    Settings: ClassVar[type[Settings]] = AsciiSettings

    def __init__(self, settings: AsciiSettings) -> None:
        self.unit = settings.unit
        self._columns = settings.columns
        self._separator = None if settings.separator == ' ' else settings.separator
        self._axes = tuple(settings.columns.index(axis) for axis in 'xyz')
        self._fed = 0
        self._begin(in_step=False)

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
        try:
            return [Reading(self._values(line), self._fed - self._length)]
        except ReadingError as error:
            return [error]

    def _values(self, line: bytes) -> Vector:
        if _UNPRINTABLE.search(line):
            raise GarbledError(
                f'{line[:SHOWN]!r} is no text: driver.serial.baud or driver.serial.protocol does '
                'not fit, or the line is disturbed'
            )
        text = line.decode('ascii').strip()
        fields = text.split(self._separator)
        if len(fields) != len(self._columns):
            raise ColumnError(
                f'{text[:SHOWN]!r} has {len(fields)} columns, driver.serial.ascii.columns '
                f'{self._columns!r} has {len(self._columns)}: set it, or '
                'driver.serial.ascii.separator'
            )
        x, y, z = (self._number(fields[axis], text) for axis in self._axes)
        return (x, y, z)

    def _number(self, field: str, text: str) -> float:
        found = _NUMBER.fullmatch(field)
        number = float(found.group(1)) if found else LARGEST
        if abs(number) >= LARGEST:
            raise NumberError(
                f'{field.strip()[:SHOWN]!r} in {text[:SHOWN]!r} is no number that a sensor sends: '
                'is it a heading, or are driver.serial.ascii.columns others?'
            )
        return number


_CUT = CutError('a line without its beginning or its end, where the port was opened or lost')


class AsciiBoard:
    """Send each measurement as a line."""

    def __init__(self, settings: AsciiSettings) -> None:
        self._settings = settings

    def hear(self, data: bytes) -> bytes:
        """Take no notice."""
        return b''

    def measure(self, measurement: Measurement) -> bytes:
        """Return a line; columns that are not used hold 0."""
        settings = self._settings
        values = dict(zip('xyz', measurement.values[settings.unit], strict=True))
        fields = [f'{values.get(column, 0.0):.9g}' for column in settings.columns]
        return (settings.separator.join(fields) + '\r\n').encode()


PROTOCOL, BOARD = AsciiDecoder, AsciiBoard
