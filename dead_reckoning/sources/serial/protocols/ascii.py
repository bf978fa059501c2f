"""Lines of text, one reading each: numbers in columns, as ``512,498,830``."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import ClassVar

from dead_reckoning.core.accelerometer import UNITS
from dead_reckoning.core.errors import ColumnError, NumberError, SettingsError
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.serial.lines import SHOWN, LineDecoder
from dead_reckoning.sources.serial.protocols import Measurement, Reading

LARGEST = 1e9
"""No sensor sends a larger number."""


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


_NUMBER = re.compile(
    r'\s*(?:([A-Za-z]\w*)\s*[:=]\s*)?'  # a label
    r'([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*',
    re.ASCII,
)


class AsciiDecoder(LineDecoder):
    """Read x, y, z from lines; a number may have a label, as ``X: 1`` or ``ay = 2``.

    A line is a reading only if all of it is in order: as many columns as ``columns`` says, and in
    each that is used a number, whose label, if it names an axis, names that of the column.  A
    label names an axis if just one of the letters x, y, z is in it.
    """

    Settings: ClassVar[type[Settings]] = AsciiSettings

    def __init__(self, settings: AsciiSettings) -> None:
        super().__init__()
        self.unit = settings.unit
        self._columns = settings.columns
        self._separator = None if settings.separator == ' ' else settings.separator
        self._axes = tuple((axis, settings.columns.index(axis)) for axis in 'xyz')

    def _reading(self, text: str, start: int) -> Reading:
        fields = text.split(self._separator)
        if len(fields) != len(self._columns):
            raise ColumnError(
                f'{text[:SHOWN]!r} has {len(fields)} columns, driver.serial.ascii.columns '
                f'{self._columns!r} has {len(self._columns)}: set it, or '
                'driver.serial.ascii.separator'
            )
        x, y, z = [self._number(fields[place], axis, text) for axis, place in self._axes]
        return Reading((x, y, z), start)

    def _number(self, field: str, axis: str, text: str) -> float:
        found = _NUMBER.fullmatch(field)
        number = float(found.group(2)) if found else LARGEST
        if found is None or abs(number) >= LARGEST:
            raise NumberError(
                f'{field.strip()[:SHOWN]!r} in {text[:SHOWN]!r} is no number that a sensor sends: '
                'is it a heading, or are driver.serial.ascii.columns others?'
            )
        label = found.group(1)
        if label:
            named = {'x', 'y', 'z'}.intersection(label.lower())
            if len(named) == 1 and axis not in named:
                raise ColumnError(
                    f'{field.strip()[:SHOWN]!r} in {text[:SHOWN]!r} is where '
                    f'driver.serial.ascii.columns {self._columns!r} has {axis}: set it in the '
                    'order of the labels'
                )
        return number


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
