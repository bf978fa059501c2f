"""Order columns of specific force in time and bring them to a rate: the loop of `Pedometer`."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from dead_reckoning.core.checks import is_measurable
from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import Array, Stamps, measured, put, triple, vector
from dead_reckoning.core.samples import NANOSECONDS


class Cells(NamedTuple):
    """State and settings of a `Resampler`, and what comes out of it.

    ``grid``       shape (5,): rate [Hz], start [ns], index of the cell, its end and the last
                   sample [ns].
    ``last``, ``area``   shapes (3,): of the last sample, and of the cell until then.
    ``use``        shape (3,): 1 for the axes whose magnitude counts.
    ``stamp_ns``, ``magnitude``, ``by``   a row per cell: its middle, the magnitude [m/s²], and the
                   row that completed it; as long as there is room.
    """

    grid: Stamps
    last: Array
    area: Array
    use: Array
    stamp_ns: Stamps
    magnitude: Array
    by: Stamps


RATE, START, CELL, END, LAST = range(5)
"""What the elements of `Cells.grid` are."""


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
            made = _add(cells, made, stamps[k], forces[k, 0], forces[k, 1], forces[k, 2], i)
        newest_ns, released = stamp_ns, end
    return len(stamps), released, made


def _add(
    cells: Cells, made: int, stamp_ns: int, to_x: float, to_y: float, to_z: float, by: int
) -> int:
    """Take one sample, write the cells that it completes: `Resampler.add`."""
    grid = cells.grid
    last_ns, (x, y, z), (ax, ay, az) = grid[LAST], triple(cells.last), triple(cells.area)
    from_ns = last_ns
    while stamp_ns >= grid[END]:
        end_ns = grid[END]
        part = (end_ns - from_ns) / (stamp_ns - from_ns)
        end_x, end_y, end_z = x + part * (to_x - x), y + part * (to_y - y), z + part * (to_z - z)
        half = 0.5 * (end_ns - from_ns)
        start_ns = _bound_ns(grid, grid[CELL])
        width = end_ns - start_ns
        x = (ax + half * (x + end_x)) / width
        y = (ay + half * (y + end_y)) / width
        z = (az + half * (z + end_z)) / width
        use_x, use_y, use_z = triple(cells.use)
        cells.stamp_ns[made] = (start_ns + end_ns) // 2
        cells.magnitude[made] = sqrt(use_x * x * x + use_y * y * y + use_z * z * z)
        cells.by[made] = by
        made += 1
        ax = ay = az = 0.0
        x, y, z, from_ns = end_x, end_y, end_z, end_ns
        grid[CELL] += 1
        grid[END] = _bound_ns(grid, grid[CELL] + 1)
    half = 0.5 * (stamp_ns - from_ns)
    put(cells.area, (ax + half * (x + to_x), ay + half * (y + to_y), az + half * (z + to_z)))
    put(cells.last, (to_x, to_y, to_z))
    grid[LAST] = stamp_ns
    return made


def _bound_ns(grid: Stamps, cell: int) -> int:
    rate = grid[RATE]
    return int(grid[START] + (2 * cell * NANOSECONDS + rate) // (2 * rate))
