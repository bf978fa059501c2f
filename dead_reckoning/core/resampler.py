"""Bring the magnitude of samples of any rate to a uniform one, causally."""

from __future__ import annotations

from inspect import unwrap
from typing import Any, ClassVar

import numpy as np

from dead_reckoning.core.kernels.resampler import LAST, MIDDLE, add, begin
from dead_reckoning.core.samples import Vector


class Resampler:
    """Average a vector over equal stretches of time, whatever the rate it comes at.

    Time is cut into cells of ``1/rate`` from the first sample on.  A sample of the output is the
    magnitude of the mean over its cell of the straight lines between the samples of the input,
    stamped at the middle: at a higher input rate that is an average, which keeps what is faster
    than the output from folding down; at a lower one it interpolates.  It comes out with the first
    sample at or after the end of its cell.

    Stamps must rise; gaps are bridged by a straight line, so whoever knows better calls `reset`.
    """

    KERNELS: ClassVar[Any] = ((add, (2, 0.0, 0.0, 0.0, np.ones(7, np.int64), np.zeros(9))),)
    """What is called where it is compiled, with arguments for which it can be."""

    def __init__(self, rate: int, use: Vector = (1.0, 1.0, 1.0), compiled: bool = False) -> None:
        """``rate`` [Hz]; ``use`` is 1 for each axis whose magnitude counts, and 0 for others.

        ``compiled``: the kernel works, on arrays, else the same function of Python, on lists.
        """
        self.rate = rate
        self._add = add if compiled else unwrap(add)
        self.grid: Any = [rate, 0, 0, 0, 0, 0, 0]
        self.lines: Any = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, *use]
        self._stamps: Any = self.grid
        if compiled:
            self.grid, self.lines = np.array(self.grid, np.int64), np.array(self.lines)
            self._stamps = memoryview(self.grid)
        self.reset()

    def reset(self) -> None:
        """Forget everything: the next sample begins the first cell."""
        self.begun = False

    @property
    def last_ns(self) -> int:
        """The stamp of the last sample [ns]."""
        return int(self.grid[LAST])

    def add(self, stamp_ns: int, vector: Vector) -> list[tuple[int, float]]:
        """Take one sample, shape (3,); return the magnitudes it completes, each with its stamp."""
        x, y, z = vector
        grid, lines, stamps = self.grid, self.lines, self._stamps
        if not self.begun:
            self.begun = True
            begin(grid, lines, stamp_ns, x, y, z)
        made = []
        while (magnitude := self._add(stamp_ns, x, y, z, grid, lines)) >= 0.0:
            made.append((stamps[MIDDLE], magnitude))
            if stamps[LAST] == stamp_ns:
                break
        return made
