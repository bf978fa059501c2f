"""Count the steps of a block: `Pedometer` on columns, as far as the rate of its method."""

from __future__ import annotations

from collections import deque

import numpy as np

from dead_reckoning.core.batch import NOTHING, Run
from dead_reckoning.core.blocks import ImuBlock, Stamped
from dead_reckoning.core.chain import Output
from dead_reckoning.core.headings import Heading, HeadingHistory
from dead_reckoning.core.kernels.columns import imu_columns, in_one_piece
from dead_reckoning.core.kernels.headings import HeadingColumns, find_headings
from dead_reckoning.core.kernels.resampler import Cells, resample
from dead_reckoning.core.mounting import Mountings, is_turned
from dead_reckoning.core.pedometer import Pedometer
from dead_reckoning.core.samples import NANOSECONDS, NavigationState
from dead_reckoning.core.stages import StepOutputs
from dead_reckoning.core.step_odometry import StepOdometry

ROOM = 1000
"""Cells beyond one for each sample that a run has room for."""


def pedometer_run(
    pedometer: Pedometer, odometry: StepOdometry, says: StepOutputs, mountings: Mountings
) -> Run:
    """Return what counts the steps of a block.

    Left to the stream are: the first samples of a walk, and a sensor that is turned on its body.
    """

    def run(block: ImuBlock, begin: int) -> tuple[int, list[Output]]:
        newest_ns = regular_since(pedometer)
        if newest_ns is None:
            return NOTHING
        order, headings = pedometer._order, _Headings(odometry)
        waiting = len(order._stamps)
        if headings.last_ns > newest_ns or is_turned(mountings, block.frame_id):
            return NOTHING
        limit = headings.find(block, begin)
        stamps = np.empty(waiting + limit - begin, np.int64)
        stamps[:waiting], stamps[waiting:] = order._stamps, block.stamp_ns[begin:limit]
        forces = np.empty((len(stamps), 3))
        forces[waiting:] = block.specific_force[begin:limit]
        if waiting:
            forces[:waiting] = order._samples
        cells = cells_of(pedometer, len(stamps) + ROOM)
        max_gap_ns = pedometer.settings.max_gap * NANOSECONDS
        end, released, made = resample(
            stamps,
            forces,
            in_one_piece(block.specific_force_covariance[begin:limit]),
            waiting,
            newest_ns,
            order._hold_ns,
            order._limit,
            max_gap_ns,
            cells,
        )
        if end == waiting:
            return NOTHING
        order._newest_ns = int(stamps[end - 1])
        order._stamps = stamps[released:end].tolist()
        order._samples = [(x, y, z) for x, y, z in forces[released:end].tolist()]
        leave_cells(pedometer, cells)
        outputs: list[Output] = []
        columns = (cells.stamp_ns[:made], cells.magnitude[:made], cells.by[:made])
        for cell_ns, magnitude, by in zip(*(c.tolist() for c in columns), strict=True):
            states = pedometer.advance(cell_ns, magnitude)
            if states:
                headings.take(begin + by - waiting)
                for name, value in says.of(states):
                    walked = isinstance(value, NavigationState)
                    outputs.append((name, value if walked else Stamped(int(stamps[by]), value)))
        headings.take(begin + end - waiting - 1)
        return end - waiting, outputs

    return run


def regular_since(pedometer: Pedometer) -> int | None:
    """Return the newest stamp [ns] if it counts, and has begun to."""
    begun = pedometer.running and pedometer._resampler.begun
    return pedometer._order._newest_ns if begun else None


def cells_of(pedometer: Pedometer, room: int) -> Cells:
    """Return the state of the resampler of a pedometer, and room for cells."""
    resampler = pedometer._resampler
    return Cells(
        np.array(resampler.grid, np.int64),
        np.array(resampler.lines),
        np.empty(room, np.int64),
        np.empty(room),
        np.empty(room, np.int64),
    )


def leave_cells(pedometer: Pedometer, cells: Cells) -> None:
    """Carry the state back."""
    resampler = pedometer._resampler
    resampler.grid[:], resampler.lines[:] = cells.grid.tolist(), cells.lines.tolist()
    pedometer._last_ns = pedometer._order._handed_ns = resampler.last_ns


class _Headings:
    """Find the headings of a block, and hand them on when their time has come."""

    def __init__(self, odometry: StepOdometry) -> None:
        self._asked = odometry.settings.heading
        self._history: HeadingHistory = odometry._orientation
        self.last_ns = self._history.newest_ns
        self._found: deque[tuple[int, Heading]] = deque()

    def find(self, block: ImuBlock, begin: int) -> int:
        """Look at a block from a row on; return the end of what is regular."""
        if self._asked not in ('orientation', 'any'):
            return len(block)
        room = len(block) - begin
        out = HeadingColumns(np.empty(room, np.int64), *(np.empty(room) for _ in range(3)))
        end, count = find_headings(
            imu_columns(block),
            begin,
            self.last_ns,
            self._history._variance,
            self._asked == 'orientation',
            out,
        )
        rows = out.row[:count]
        columns = (block.stamp_ns[rows], out.x[:count], out.y[:count], out.variance[:count])
        headings = map(Heading, *(column.tolist() for column in columns))
        self._found.extend(zip(rows.tolist(), headings, strict=True))
        return end

    def take(self, row: int) -> None:
        """Hand on those of the rows up to one."""
        history = self._history
        while self._found and self._found[0][0] <= row:
            history.append(self._found.popleft()[1])
