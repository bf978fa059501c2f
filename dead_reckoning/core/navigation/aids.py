"""Keep what is known beside the samples until the sample of its time is filtered."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from dead_reckoning.core.blocks import Array, Stamps
from dead_reckoning.core.errors import AidingError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.samples import NANOSECONDS

LONGEST = 4096
"""So many wait at most: a second of four thousand."""

NO_AIDS = np.empty((0, layout.AID_ROW))


def aid_row(row: int, kind: int, values: Sequence[float], age_ns: int) -> tuple[float, ...]:
    """Return what the kernel takes, AID_ROW numbers, for the sample that a row filters."""
    padding = (layout.AID_ROW - 3 - len(values)) * (0.0,)
    return (row, -age_ns / NANOSECONDS, kind, *values, *padding)


def in_order(aids: Array) -> Array:
    """Return aids, shape (m, AID_ROW), in the order of their rows, and of their stamps in each.

    Nothing depends on which came first.
    """
    ordered: Array = aids[np.lexsort(aids.T[::-1])]
    return ordered


class Aids:
    """Hand each over with the first sample that is not before it and not filtered yet.

    What comes late is thus taken late, and says by how much.
    """

    def __init__(self) -> None:
        self.waiting: deque[tuple[int, int, Sequence[float]]] = deque()
        """Stamp [ns], kind and values of each."""

    @property
    def first_ns(self) -> int:
        """The least stamp of those that wait, at least one [ns]."""
        return min(stamp_ns for stamp_ns, _, _ in self.waiting)

    def drop_compass(self) -> bool:
        """Drop what a compass told and waits; say whether its first yaw was among it."""
        told = [aid for aid in self.waiting if _is_of_compass(aid)]
        for aid in told:
            self.waiting.remove(aid)
        return any(kind == layout.NORTH for _, kind, _ in told)

    def add(self, stamp_ns: int, kind: int, values: Sequence[float]) -> None:
        """Take one, of a kind of `layout`, with its values.

        Raises `AidingError` where too many wait.
        """
        if len(self.waiting) >= LONGEST:
            raise AidingError(
                f'{LONGEST} others wait for Imu samples of their time: is there still an Imu?'
            )
        self.waiting.append((stamp_ns, kind, values))

    def due(self, stamps: Stamps, first: int, rows: int) -> Array:
        """Return those that the next rows take, shape (m, AID_ROW).

        ``stamps`` are those of the samples that are not filtered yet, of which sample i is
        filtered with row ``first`` + i.
        """
        made, kept = [], self.waiting
        self.waiting = deque()
        last_ns = int(stamps[min(rows - first, len(stamps)) - 1])
        for stamp_ns, kind, values in kept:
            if stamp_ns > last_ns:
                self.waiting.append((stamp_ns, kind, values))
                continue
            index = int(np.searchsorted(stamps, stamp_ns))
            made.append(aid_row(index + first, kind, values, int(stamps[index]) - stamp_ns))
        return in_order(np.array(made)) if made else NO_AIDS


def _is_of_compass(aid: tuple[int, int, Sequence[float]]) -> bool:
    _, kind, values = aid
    return kind == layout.NORTH or (kind == layout.YAW and values[-1] == layout.BY_COMPASS)
