"""Read samples from CSV with a header: specific force or counts, angular velocity, attitude."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.blocks import Array, ImuBlock, Stamped, Stamps
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import InputError, OutOfRangeError
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.parameters import Parts
from dead_reckoning.core.samples import NANOSECONDS, NOT_MEASURED
from dead_reckoning.sources.driver import front_end
from dead_reckoning.sources.driver_settings import DriverSettings

STAMP, TIME = 'stamp_ns', 'time'
FORCE = ('ax', 'ay', 'az')
RATE = ('gx', 'gy', 'gz')
ATTITUDE = ('qx', 'qy', 'qz', 'qw')
COUNTS = ('x', 'y', 'z')

WHOLE = re.compile(r'\s*[+-]?\d{1,19}\s*', re.ASCII)
NUMBER = re.compile(r'\s*[+-]?(((\d+\.?\d*|\.\d+)(e[+-]?\d+)?)|nan|inf)\s*', re.ASCII | re.I)

LATEST = 2**31 * NANOSECONDS
"""What a stamp has to be less than, to fit a message [ns]."""

EXACT = 1e6
"""Times [s] up to which a double tells one nanosecond from the next."""

BLOCK = 8192
SHOWN = 40
"""How many characters of a cell a message shows."""


class CsvRecording:
    """Samples of a table, in its order.

    Columns: ``stamp_ns`` or ``time`` [s], or neither where a ``rate`` [Hz] is given; ``ax,ay,az``
    [m/s²], frame of the sensor, to which ``gx,gy,gz`` [rad/s] and ``qx,qy,qz,qw`` may come; or
    ``x,y,z``, counts of the sensor in ``parts``, which its front end averages and calibrates.
    Others are passed over.  NaN and stamps that go back are left to who takes the samples.

    Raises `InputError`, which names the file, the line, the column and the value: no header, a
    missing column, a cell that is empty or no number, a line with more or fewer cells.
    """

    def __init__(self, path: Path, parts: Parts, rate: float | None = None) -> None:
        self._path = path
        self._parts = parts
        try:
            text = path.read_bytes().decode('utf-8-sig', errors='backslashreplace')
        except OSError as error:
            raise InputError(f'{path}: {error.strerror or error}') from error
        # Not splitlines(): it knows more ends of lines than editors count.
        self._lines = text.replace('\r\n', '\n').rstrip().split('\n')
        self._header = [cell.strip().strip('"') for cell in self._lines[0].split(',')]
        if not set(self._header) & {STAMP, TIME, *FORCE, *COUNTS}:
            raise InputError(
                f'{path}, line 1: no header with the columns {", ".join(FORCE)} or '
                f'{", ".join(COUNTS)}, but {_shown(self._lines[0])}'
            )
        if len(self._lines) == 1:
            raise InputError(f'{path}: no line after the header')
        self._measured = self._groups()
        stamp = next((name for name in (STAMP, TIME) if name in self._header), None)
        if stamp is None and rate is None:
            raise InputError(f'{path}, line 1: no column {STAMP} or {TIME}; give a --rate')
        self._values = self._read([*([stamp] if stamp else []), *self._measured])
        self._stamps = self._stamps_of(stamp, rate or 0.0)

    def __len__(self) -> int:
        """Return how many samples the rows make, if all can be used."""
        if COUNTS[0] in self._measured:
            return len(self._stamps) // self._parts[DriverSettings].samples_per_message
        return len(self._stamps)

    def blocks(self) -> Iterator[ImuBlock | Stamped]:
        """Yield the samples in blocks, and what is wrong with single rows."""
        if COUNTS[0] in self._measured:
            yield from self._converted()
            return
        for begin in range(0, len(self), BLOCK):
            yield self._block(slice(begin, begin + BLOCK))

    def _block(self, rows: slice) -> ImuBlock:
        stamps = self._stamps[rows]
        unknown = np.zeros((len(stamps), 9))
        rate_covariance, attitude_covariance = unknown.copy(), unknown.copy()
        rate, attitude = np.zeros((len(stamps), 3)), np.zeros((len(stamps), 4))
        if RATE[0] in self._measured:
            rate = self._columns(RATE)[rows]
        else:
            rate_covariance[:] = NOT_MEASURED
        if ATTITUDE[0] in self._measured:
            attitude = self._columns(ATTITUDE)[rows]
        attitude_covariance[~attitude.any(axis=1)] = NOT_MEASURED
        return ImuBlock(
            stamp_ns=stamps,
            frame_id=self._parts[FrameSettings].sensor,
            specific_force=self._columns(FORCE)[rows],
            specific_force_covariance=unknown,
            angular_velocity=rate,
            angular_velocity_covariance=rate_covariance,
            orientation=attitude,
            orientation_covariance=attitude_covariance,
        )

    def _converted(self) -> Iterator[ImuBlock | Stamped]:
        model, end = self._parts[DriverSettings].model(), front_end(self._parts)
        counts = self._columns(COUNTS)
        possible = model.possible(counts)
        low, high = model.limits
        for row in np.flatnonzero(~possible).tolist():
            said = ', '.join(f'{value:g}' for value in counts[row])
            yield Stamped(
                int(self._stamps[row]),
                OutOfRangeError(
                    f'{said} counts can be no reading of a converter from {low:.0f} to {high:.0f}'
                ),
            )
        stamps, counts = self._stamps[possible], counts[possible]
        for begin in range(0, len(stamps), BLOCK):
            rows = slice(begin, begin + BLOCK)
            samples = end.add(Conversions(stamps[rows], counts[rows]))
            if end.finding is not None:
                yield Stamped(int(stamps[begin]), end.finding)
                end.finding = None
            if samples:
                yield ImuBlock.of(samples)

    def _columns(self, names: Sequence[str]) -> Array:
        return np.column_stack([self._values[name] for name in names])

    def _groups(self) -> list[str]:
        """Return the columns that are measured, or raise where one is missing or there twice."""
        groups: list[tuple[str, ...]] = [FORCE]
        if not set(self._header) & set(FORCE) and set(self._header) & set(COUNTS):
            groups = [COUNTS]
        groups += [group for group in (RATE, ATTITUDE) if set(group) & set(self._header)]
        if groups[0] is COUNTS and len(groups) > 1:
            raise InputError(
                f'{self._path}, line 1: {groups[1][0]} beside the counts x, y, z: with '
                f'{", ".join(groups[1])} the force has to be ax, ay, az [m/s²]'
            )
        names = [name for group in groups for name in group]
        for name in (*names, STAMP, TIME):
            times = self._header.count(name)
            if times > 1 or (times == 0 and name in names):
                what = 'no' if times == 0 else 'more than one'
                raise InputError(
                    f'{self._path}, line 1: {what} column {name} in {_shown(self._lines[0])}'
                )
        return names

    def _read(self, names: Sequence[str]) -> dict[str, NDArray[Any]]:
        rows, width = self._lines[1:], len(self._header)
        kinds = np.dtype([(name, np.int64 if name == STAMP else np.float64) for name in names])
        chosen = [self._header.index(name) for name in names]
        table = None
        if all(row.count(',') == width - 1 for row in rows):
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter('error')  # as for an integer with a point
                    table = np.loadtxt(
                        rows, kinds, delimiter=',', usecols=chosen, comments=None, ndmin=1
                    )
            except (ValueError, OverflowError, Warning):
                pass  # which line and why, is found below
        if table is None or len(table) != len(rows):
            table = np.array(list(self._line_by_line(names, chosen)), dtype=kinds)
        return {name: table[name] for name in names}

    def _line_by_line(
        self, names: Sequence[str], chosen: Sequence[int]
    ) -> Iterator[tuple[float, ...]]:
        for number, line in enumerate(self._lines[1:], 2):
            where = f'{self._path}, line {number}'
            cells = line.split(',')
            if len(cells) != len(self._header):
                raise InputError(
                    f'{where}: {_shown(line)} has {len(cells)} columns, not {len(self._header)}'
                )
            row = []
            for name, index in zip(names, chosen, strict=True):
                cell = cells[index]
                if not cell.strip():
                    raise InputError(f'{where}: {name} is empty')
                if not (WHOLE if name == STAMP else NUMBER).fullmatch(cell):
                    kind = 'whole number' if name == STAMP else 'number'
                    raise InputError(f'{where}: {name} is {_shown(cell)}, which is no {kind}')
                row.append(self._stamp(where, cell, 1) if name == STAMP else float(cell))
            yield tuple(row)

    def _stamps_of(self, name: str | None, rate: float) -> Stamps:
        """Return the stamps of all rows [ns]; what has none begins one period after zero."""
        if name is None:
            periods = np.arange(1, len(self._lines)) / rate
            if periods[-1] * NANOSECONDS >= LATEST:
                raise InputError(f'--rate {rate:g}: so few a second end after the last stamp')
            return _whole(periods * NANOSECONDS)
        values = self._values[name]
        if name == TIME and (np.abs(values) < EXACT).all():
            stamps = _whole(values * NANOSECONDS)
        elif name == TIME or ((values >= LATEST) | (values <= -LATEST)).any():
            column, scale = self._header.index(name), NANOSECONDS if name == TIME else 1
            stamps = np.array(
                [
                    self._stamp(f'{self._path}, line {number}', line.split(',')[column], scale)
                    for number, line in enumerate(self._lines[1:], 2)
                ],
                dtype=np.int64,
            )
        else:
            return _whole(values)
        stamps[stamps == 0] = 1  # a time of zero is a time, the stamp zero is none
        return stamps

    def _stamp(self, where: str, cell: str, scale: int) -> int:
        value = Decimal(cell.strip()) * scale
        if not value.is_finite() or abs(value) >= LATEST:
            name = STAMP if scale == 1 else TIME
            raise InputError(
                f'{where}: {name} is {_shown(cell)}, which is no time that a message holds'
            )
        return int(value.to_integral_value())


def _whole(values: NDArray[Any]) -> Stamps:
    stamps: Stamps = np.rint(values).astype(np.int64) if values.dtype.kind == 'f' else values
    return stamps


def _shown(text: str) -> str:
    return repr(text if len(text) <= SHOWN else text[:SHOWN] + '…')
