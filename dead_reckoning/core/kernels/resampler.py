"""Order columns of specific force in time and bring them to a rate: the loops of `Resampler`."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from dead_reckoning.core.checks import is_measurable
from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import Array, Stamps, measured, vector
from dead_reckoning.core.samples import NANOSECONDS

RATE, START, CELL, BEGIN, END, LAST, MIDDLE = range(7)
"""What the elements of a grid are: rate [Hz], start [ns], index of the cell, its begin and end,
the last sample, and the middle of the cell before [ns]."""


class Cells(NamedTuple):
    """State and settings of a `Resampler`, and what comes out of it.

    ``grid``       shape (7,), by the names above.
    ``lines``      shape (9,): the last sample, the area under the lines of the cell until then,
                   and 1 for the axes whose magnitude counts.
    ``stamp_ns``, ``magnitude``, ``by``   a row per cell: its middle, the magnitude [m/s²], and the
                   row that completed it; as long as there is room.
    """

    grid: Stamps
    lines: Array
    stamp_ns: Stamps
    magnitude: Array
    by: Stamps


def begin(grid: Stamps, lines: Array, stamp_ns: int, x: float, y: float, z: float) -> None:
    """Begin the first cell with a sample."""
    grid[START] = grid[BEGIN] = grid[LAST] = stamp_ns
    grid[CELL] = 0
    grid[END] = _end_ns(grid)
    lines[0], lines[1], lines[2] = x, y, z
    lines[3] = lines[4] = lines[5] = 0.0


@compiled
def add(stamp_ns: int, x: float, y: float, z: float, grid: Stamps, lines: Array) -> float:
    """Take a sample, or its line as far as one cell was completed before the end of another.

    Returns the magnitude of the cell that is complete, or −1; its stamp is ``grid[MIDDLE]``.  The
    sample is to be given again until it is ``grid[LAST]``.
    """
    magnitude = -1.0
    if stamp_ns >= grid[END]:
        magnitude = _complete(stamp_ns, x, y, z, grid, lines)
        if stamp_ns >= grid[END]:
            return magnitude
    half = 0.5 * (stamp_ns - grid[LAST])
    lines[3] += half * (lines[0] + x)
    lines[4] += half * (lines[1] + y)
    lines[5] += half * (lines[2] + z)
    lines[0], lines[1], lines[2] = x, y, z
    grid[LAST] = stamp_ns
    return magnitude


def _complete(
    stamp_ns: int, to_x: float, to_y: float, to_z: float, grid: Stamps, lines: Array
) -> float:
    """Follow the line to a sample as far as the end of the cell; return its magnitude."""
    begin_ns, end_ns, last_ns = grid[BEGIN], grid[END], grid[LAST]
    x, y, z = lines[0], lines[1], lines[2]
    part = (end_ns - last_ns) / (stamp_ns - last_ns)
    end_x, end_y, end_z = x + part * (to_x - x), y + part * (to_y - y), z + part * (to_z - z)
    half, width = 0.5 * (end_ns - last_ns), end_ns - begin_ns
    x = (lines[3] + half * (x + end_x)) / width
    y = (lines[4] + half * (y + end_y)) / width
    z = (lines[5] + half * (z + end_z)) / width
    lines[0], lines[1], lines[2] = end_x, end_y, end_z
    lines[3] = lines[4] = lines[5] = 0.0
    grid[MIDDLE] = (begin_ns + end_ns) // 2
    grid[BEGIN] = grid[LAST] = end_ns
    grid[CELL] += 1
    grid[END] = _end_ns(grid)
    return sqrt(lines[6] * x * x + lines[7] * y * y + lines[8] * z * z)


def _end_ns(grid: Stamps) -> int:
    """Return where the cell ends [ns]: rounded each time anew, so that nothing drifts."""
    rate = grid[RATE]
    return int(grid[START] + (2 * (grid[CELL] + 1) * NANOSECONDS + rate) // (2 * rate))


@compiled
def resample(
    stamps: Stamps,
    forces: Array,
    covariances: Array,
    waiting: int,
    newest_ns: int,
    hold_ns: int,
    limit: int,
    max_gap_ns: float,
    cells: Cells,
) -> tuple[int, int, int]:
    """Take rows from ``waiting`` on, and write what cells they complete.

    Returns the ends of what is regular and of what was released, and the number of cells.  The
    rows before wait already, and those that come, whose first is row 0 of ``covariances``, wait
    too, until the newest stamp is ``hold_ns`` ahead or ``limit`` are behind them (`StampOrder`);
    ``newest_ns`` is the newest at the start.
    Irregular is what is refused or out of order, and a gap over ``max_gap_ns`` in the released.
    """
    released = made = 0
    for i in range(waiting, len(stamps)):
        stamp_ns = stamps[i]
        if not (
            stamp_ns > newest_ns
            and stamp_ns != 0
            and measured(covariances, i - waiting)
            and is_measurable(vector(forces, i))
        ):
            return i, released, made
        end, last_ns = released, cells.grid[LAST]
        while end <= i and (stamps[end] <= stamp_ns - hold_ns or i + 1 - end > limit):
            if stamps[end] - last_ns > max_gap_ns:
                return i, released, made
            last_ns = stamps[end]
            end += 1
        coming = (last_ns - cells.grid[START]) * cells.grid[RATE] // NANOSECONDS + 2
        if made + coming - cells.grid[CELL] > len(cells.stamp_ns):
            return i, released, made
        for k in range(released, end):
            x, y, z = vector(forces, k)
            while cells.grid[LAST] != stamps[k]:
                magnitude = add(stamps[k], x, y, z, cells.grid, cells.lines)
                if magnitude >= 0.0:
                    cells.stamp_ns[made] = cells.grid[MIDDLE]
                    cells.magnitude[made], cells.by[made] = magnitude, i
                    made += 1
        newest_ns, released = stamp_ns, end
    return len(stamps), released, made
