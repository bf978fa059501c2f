"""Read whole numbers from columns of CSV; what can't be used is refused with line and value."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dead_reckoning.core.errors import InputError

WHOLE = re.compile(r'\s*[+-]?[0-9]{1,18}\s*')
"""What counts as a whole number; more digits would not fit 64 bits."""

NUMERIC = re.compile(r'\s*[+-]?[.0-9]')
"""How a cell begins that means a number; a first line without one is a header."""

SHOWN = 40
"""How many characters of a cell a message shows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """Say which columns hold what, and how many rows of them it takes.

    ``names``
        columns in the order they are returned.  Under a header they are found by name and others
        are passed over; without one there are exactly these.
    ``minimum``, ``maximum``
        the least and the greatest count.
    ``rows``
        how many rows there are at least.
    """

    names: Sequence[str]
    minimum: int
    maximum: int
    rows: int


def read(path: Path, columns: Columns) -> npt.NDArray[np.int64]:
    """Return the counts of a file, shape (rows, columns), in order.

    Raises `InputError`, which names the file, the line and the value: a file that can't be read,
    a missing column, a cell that is no whole number or out of range, a line with more or fewer
    cells than the first one, an empty line before the last row; and where none of these is, too
    few rows.
    """
    try:
        text = path.read_bytes().decode('utf-8-sig', errors='backslashreplace')
    except OSError as error:
        raise InputError(f'{path}: {error.strerror or error}') from error
    # Not splitlines(): it knows more ends of lines than editors count.
    lines = text.replace('\r\n', '\n').rstrip().split('\n')
    begin, chosen, width = _layout(path, lines[0], columns.names)
    counts = _at_once(lines[begin:], width)
    if counts is not None:
        counts = counts[:, chosen]
    if counts is None or counts.min() < columns.minimum or counts.max() > columns.maximum:
        counts = _line_by_line(path, lines, begin, width, chosen, columns)
    if len(counts) < columns.rows:
        raise InputError(
            f'{path}, line {len(lines)}: ends after {len(counts)} rows; '
            f'at least {columns.rows} are needed'
        )
    return counts


def _layout(path: Path, first: str, names: Sequence[str]) -> tuple[int, list[int], int]:
    """Return the index of the first row, where the columns are, and how many cells a line has."""
    cells = first.split(',')
    if not first or any(NUMERIC.match(cell) for cell in cells):
        return 0, list(range(len(names))), len(names)
    found = [cell.strip().strip('"') for cell in cells]
    for name in names:
        if found.count(name) != 1:
            what = 'no' if name not in found else 'more than one'
            raise InputError(f'{path}, line 1: {what} column {name} in {_shown(first)}')
    return 1, [found.index(name) for name in names], len(cells)


def _at_once(lines: Sequence[str], width: int) -> npt.NDArray[np.int64] | None:
    """Return all cells, or None where a line may be at fault: a million lines in a blink."""
    row = re.compile(','.join(['[+-]?[0-9]{1,18}'] * width))
    if not lines or not all(map(row.fullmatch, lines)):
        return None
    return np.fromstring(','.join(lines), dtype=np.int64, sep=',').reshape(-1, width)


def _line_by_line(
    path: Path,
    lines: Sequence[str],
    begin: int,
    width: int,
    chosen: Sequence[int],
    columns: Columns,
) -> npt.NDArray[np.int64]:
    """Return the counts, or raise where the first fault is."""
    counts = []
    for number, line in enumerate(lines[begin:], begin + 1):
        where = f'{path}, line {number}'
        cells = line.split(',')
        if len(cells) != width:
            raise InputError(f'{where}: {_shown(line)} has {len(cells)} columns, not {width}')
        row = []
        for name, index in zip(columns.names, chosen, strict=True):
            cell = cells[index]
            if not WHOLE.fullmatch(cell):
                raise InputError(f'{where}: {name} is {_shown(cell)}, which is no whole number')
            count = int(cell)
            if not columns.minimum <= count <= columns.maximum:
                raise InputError(
                    f'{where}: {name} is {count}, outside {columns.minimum} to {columns.maximum}'
                )
            row.append(count)
        counts.append(row)
    return np.array(counts, dtype=np.int64).reshape(-1, len(chosen))


def _shown(text: str) -> str:
    return repr(text if len(text) <= SHOWN else text[:SHOWN] + '…')
