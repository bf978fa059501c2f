"""Count the strides of a foot: from stance to stance."""

from __future__ import annotations

from math import dist

import numpy as np

from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.samples import Vector

SHORTEST = 0.15
"""Way [m] between two stances below which the foot only shifted."""


class Strides:
    """Add up the way from stance to stance.

    A stride is counted when its second stance begins; its length is that from the end of one
    stance to the end of the other, where the positions are known best.
    """

    def __init__(self) -> None:
        self.count = 0
        self.placings: list[int] = []
        """Stamps [ns] at which the body is going to be placed: there it does not walk."""
        self._length = 0.0
        self._left: Vector | None = None
        self._last: Vector | None = None

    @property
    def distance(self) -> float:
        """Way [m] through all stances, that of a stance under way included."""
        if self._left is None or self._last is None:
            return self._length
        return self._length + dist(self._left, self._last)

    def reach(self, stamp_ns: int) -> None:
        """Go on from elsewhere, where the body was placed by then: it did not walk there."""
        later = [placing_ns for placing_ns in self.placings if placing_ns > stamp_ns]
        if len(later) < len(self.placings):
            self.placings = later
            self._length, self._left, self._last = self.distance, None, None

    def update(self, stationary: bool, position: Vector) -> None:
        """Take the next state: whether the foot stands, and where, shape (3,) [m].

        Only where that changes, just before and just after, it matters.
        """
        if stationary:
            first = self._last is None
            if first and self._left is not None and dist(self._left, position) > SHORTEST:
                self.count += 1
            self._last = position
        elif self._last is not None:
            self._length = self.distance
            self._left, self._last = self._last, None


def count_strides(strides: Strides, block: StateBlock) -> None:
    """Count the strides of a block, one placing after the other."""
    begin = 0
    for stamp_ns in sorted(strides.placings):
        end = int(np.searchsorted(block.stamp_ns, stamp_ns))
        if end == len(block):
            break
        _count(strides, block.part(begin, end))
        strides.reach(stamp_ns)
        begin = end
    _count(strides, block.part(begin, len(block)))


def _count(strides: Strides, block: StateBlock) -> None:
    """Count those of a block within which nothing is placed.

    What is between two changes does not matter.
    """
    if not len(block):
        return
    changes = np.flatnonzero(np.diff(block.stationary))
    matter = {0, len(block) - 1, *changes.tolist(), *(changes + 1).tolist()}
    for i in sorted(matter):
        x, y, z = block.position[i].tolist()
        strides.update(bool(block.stationary[i]), (x, y, z))
