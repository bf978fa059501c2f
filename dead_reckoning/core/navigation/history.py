"""Keep what a filter takes, and its state now and then, so that it can go through it again."""

from __future__ import annotations

from array import array
from bisect import bisect_left
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np

from dead_reckoning.core.blocks import Array, Stamps
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.kernels.navigation.filter import navigate
from dead_reckoning.core.navigation.aids import NO_AIDS, aid_row, in_order
from dead_reckoning.core.samples import NANOSECONDS

NO_TRACE = np.empty((0, layout.TRACE_ROW))
NO_LOG = np.empty((0, layout.LOG_ROW))

STRETCH = 200
"""Samples at most between two states that are kept."""


@dataclass(eq=False)
class Stretch:
    """Rows that a filter took, shape (n, ROW), with their verdicts and aids, and its state before.

    ``stamps`` begin with those of the samples that waited then; ``begins`` says that there was no
    sample before.
    """

    state: Array
    rules: Array
    begins: bool
    stamps: array[int]
    first: int
    """Row that filters the first of the stamps."""
    count: int = 0
    closed: bool = False
    samples: Array = field(default_factory=lambda: np.empty((STRETCH, layout.ROW)))
    verdicts: Array = field(default_factory=lambda: np.empty((STRETCH, 3)))
    aids: Array = field(default_factory=lambda: NO_AIDS)

    @property
    def filtered(self) -> int:
        """How many of its stamps are filtered at its end."""
        return min(len(self.stamps), max(0, self.count - self.first))

    def add(self, samples: Array, verdicts: Array, aids: Array, stamps: Stamps) -> None:
        """Keep rows; those that stand for no sample close the stretch, and have no stamps."""
        if len(aids):
            later = aids.copy()
            later[:, 0] += self.count
            self.aids = np.concatenate((self.aids, later))
        end = self.count + len(samples)
        self.samples[self.count : end] = samples
        self.verdicts[self.count : end] = verdicts
        self.stamps.frombytes(stamps.tobytes())
        self.count = end
        self.closed = len(stamps) < len(samples)

    def run(
        self,
        state: Array,
        out: Array,
        trace: Array = NO_TRACE,
        log: Array = NO_LOG,
        rows: int | None = None,
    ) -> int:
        """Filter so many rows, or all, from a state on; return how many of ``out`` are filled."""
        n = self.count if rows is None else rows
        done = navigate(
            self.samples[:n], self.verdicts[:n], self.aids, self.rules, state, out, trace, log
        )
        return max(done, -1 - done)  # those before it diverged


class History:
    """Keep the last ``span`` [s] of what a navigator takes: its ``history``.

    96 bytes a sample, and 4 KB for each `STRETCH` of them.
    """

    def __init__(self, span: float) -> None:
        self.needed_ns: int | None = None
        """Stamp from which on all is kept, however long ago; None where nobody needs it."""
        self._span_ns = span * NANOSECONDS
        self._stretches: deque[Stretch] = deque()
        self._again: int | None = None  # the stretch from which on to filter once more
        self._now: Array | None = None

    @property
    def stretches(self) -> deque[Stretch]:
        """What is kept, each stretch with the state before it, all that was inserted in it."""
        if self._again is not None:
            state: Array = self._stretches[self._again].state.copy()
            out = np.empty((STRETCH, layout.STATE_ROW))
            for at in range(self._again, len(self._stretches)):
                self._stretches[at].state[:] = state
                self._stretches[at].run(state, out)
            self._again, self._now = None, state
        return self._stretches

    def newer(self) -> Array | None:
        """Return the state of now, if what was inserted since the last time changed it."""
        if self._again is None and self._now is None:
            return None
        _ = self.stretches
        now, self._now = self._now, None
        return now

    def clear(self) -> None:
        """Forget all; what is needed is needed from the start on."""
        self._stretches.clear()
        self._again = self._now = None
        self.needed_ns = None if self.needed_ns is None else 0

    def add(
        self,
        samples: Array,
        verdicts: Array,
        aids: Array,
        stamps: Stamps,
        rules: Array,
        state: Array,
    ) -> None:
        """Keep what a filter is about to take, and drop what is too long ago."""
        stretches = self.stretches
        last = stretches[-1] if stretches else None
        begins = bool(state[layout.SEEN] == 0.0 and state[layout.WAITING] == 0.0)
        if begins and self._span_ns < inf:
            self.clear()
            last = None
        if (
            last is None
            or begins
            or last.closed
            or last.rules is not rules
            or last.count + len(samples) > STRETCH
        ):
            waiting = int(state[layout.WAITING])
            late = last.stamps[len(last.stamps) - waiting :] if last and waiting else array('q')
            first = int(rules[layout.DELAY]) - len(late)  # those that nobody kept have no stamp
            last = Stretch(state.copy(), rules, begins, late, first)
            stretches.append(last)
        last.add(samples, verdicts, aids, stamps)
        if len(stamps):
            self._forget(int(stamps[-1]))

    def _forget(self, newest_ns: int) -> None:
        from_ns = newest_ns - self._span_ns
        if self.needed_ns is not None:
            from_ns = min(from_ns, self.needed_ns)
        stretches = self._stretches
        while len(stretches) > 1 and stretches[1].stamps[0] <= from_ns:
            stretches.popleft()

    def insert(self, stamp_ns: int, kind: int, values: Sequence[float]) -> bool:
        """Take what is known of a sample that is filtered already; `newer` has what comes of it.

        However many are inserted before that, it is all filtered once.  False says that the sample
        is not filtered yet, or not kept, and nothing changed.
        """
        found = self._find(stamp_ns)
        if found is None:
            return False
        begin, index = found
        stretch = self._stretches[begin]
        row = aid_row(stretch.first + index, kind, values, stretch.stamps[index] - stamp_ns)
        stretch.aids = in_order(np.concatenate((stretch.aids, [row])))
        self._again = begin if self._again is None else min(begin, self._again)
        return True

    def _find(self, stamp_ns: int) -> tuple[int, int] | None:
        """Return in which stretch, and where, the first filtered sample not before a stamp is."""
        found = None
        for at in range(len(self._stretches) - 1, -1, -1):
            stretch = self._stretches[at]
            index = bisect_left(stretch.stamps, stamp_ns, hi=stretch.filtered)
            if index < stretch.filtered:
                found = at, index
            if index > 0 or (found is not None and stretch.stamps[0] == stamp_ns):
                return found
            if stretch.begins:
                break
        return None
