"""Count steps in what kernels read from messages."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.batch import pedometer
from dead_reckoning.core.chain import Output
from dead_reckoning.core.headings import Heading
from dead_reckoning.core.kernels import memory as layout
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.headings import HeadingColumns
from dead_reckoning.core.kernels.live import CELL, HEADS, RESTS
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import NANOSECONDS

LONGEST_STEP = 1.0
"""Longest time [s] between samples for which the kernel has room."""

HEADED = {'orientation': layout.REQUIRED, 'any': layout.WELCOME}
"""What an orientation is for `pedometer.heading`."""


class LiveSteps:
    """Resample in the memory, and let the pedometer find steps in what comes of it.

    A pipeline without a pedometer has none.
    """

    def __init__(self, pipeline: Pipeline, taken: str) -> None:
        """``taken`` names the topic that the kernels take."""
        self._pipeline = pipeline
        self._taken = taken

    def parts(self, clock: NDArray[np.int64]) -> dict[int, NDArray[Any]] | None:
        """Return what kernels find in a memory, and write the rest into its clock.

        None says that the stream has to go on.
        """
        counting, walking = self._pipeline.pedometer, self._pipeline.step_odometry
        if counting is None or walking is None:
            return {}
        if pedometer.regular_since(counting) != clock[layout.LAST]:
            return None
        order, resampler, history = counting._order, counting._resampler, walking._orientation
        longest = min(counting.settings.max_gap, LONGEST_STEP)
        clock[layout.LONGEST] = longest_ns = min(clock[layout.LONGEST], int(longest * NANOSECONDS))
        stamps = [resampler.last_ns, *order._stamps]
        too_long = any(after - before > longest_ns for before, after in pairwise(stamps))
        if too_long or history.newest_ns > clock[layout.LAST]:
            return None
        as_it_came = counting.settings.input == self._taken
        clock[layout.COUNTED] = layout.AS_IT_CAME if as_it_came else layout.AS_LEVELLED
        clock[layout.HEADED] = HEADED.get(walking.settings.heading, layout.NOTHING)
        clock[layout.HEADING] = history.newest_ns
        clock[layout.HOLD], clock[layout.LIMIT] = order._hold_ns, order._limit
        clock[layout.TAIL] = waiting = len(order._stamps)
        line, forces = (
            np.zeros(2 * order._limit + 2, np.int64),
            np.zeros((2 * order._limit + 2, 3)),
        )
        line[:waiting], forces[:waiting] = order._stamps, np.reshape(order._samples, (waiting, 3))
        cells = pedometer.cells_of(counting, 4 + int(2.0 * LONGEST_STEP * resampler.rate))
        headings = HeadingColumns(np.zeros(1, np.int64), *np.zeros((3, 1)))
        parts = (*cells, line, forces, *headings, np.array([history._variance]))
        return layout.numbered(layout.CELLS, parts)

    def begin(self, memory: Array) -> None:
        """Work on a memory from now on."""
        self._clock = layout.ticks(memory, layout.CLOCK)
        self._cells, self._headings = layout.cells_of(memory), layout.headings_of(memory)

    def of(self, brought: int) -> list[Output]:
        """Return what comes of a sample that brought cells or a heading."""
        if brought <= RESTS:
            return []
        counting, walking, says = (
            self._pipeline.pedometer,
            self._pipeline.step_odometry,
            self._pipeline.steps,
        )
        assert counting is not None
        assert walking is not None
        assert says is not None
        if brought & HEADS:
            stamp_ns = int(self._clock[layout.LAST])
            x, y, variance = (float(column[0]) for column in self._headings[1:])
            walking._orientation.append(Heading(stamp_ns, x, y, variance))
        states = []
        for k in range(brought // CELL):
            stamp_ns, magnitude = int(self._cells.stamp_ns[k]), float(self._cells.magnitude[k])
            states += counting.advance(stamp_ns, magnitude)
        return says.of(states) if states else []

    def leave(self, memory: Array) -> None:
        """Carry the state back."""
        counting = self._pipeline.pedometer
        if counting is None:
            return
        clock = layout.ticks(memory, layout.CLOCK)
        line = slice(clock[layout.HEAD], clock[layout.TAIL])
        order = counting._order
        order._newest_ns = int(clock[layout.LAST])
        order._stamps = layout.ticks(memory, layout.LINE)[line].tolist()
        forces = layout.table(memory, layout.LINE + 1, 3)[line].tolist()
        order._samples = [(x, y, z) for x, y, z in forces]
        pedometer.leave_cells(counting, layout.cells_of(memory))
