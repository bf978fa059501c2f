"""Smooth what a navigator has filtered: each state then knows all samples."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator
from math import dist, inf

import numpy as np

from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.kernels.navigation.smoother import smooth
from dead_reckoning.core.navigation.history import STRETCH, History, Stretch
from dead_reckoning.core.navigation.states import state_block
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.samples import NANOSECONDS, Vector
from dead_reckoning.core.strides import SHORTEST

LONGEST_NS = 10 * NANOSECONDS
"""Without a stance for so long, what there is comes out."""

LARGEST_LOG = 18
"""Entries in the log of one sample at most, without what aids."""

OF_AID = 6
"""Entries in the log of one aid at most."""


class Smoother:
    """Record what a navigator takes, and go back through it at the end.

    Between the states that are kept the filter runs again, so that only the samples themselves
    stay in memory, 96 bytes each; the rest, 2 KB a sample, is there for one stretch.
    docs/navigation.md derives the recursion.
    """

    def __init__(self, navigator: InertialNavigator) -> None:
        """Record from now on all that ``navigator`` takes."""
        navigator.history = self._history = History(inf)

    def blocks(self) -> Iterator[StateBlock]:
        """Give the smoothed states, in blocks from the last to the first."""
        return smoothed(reversed(self._history.stretches))


class StrideSmoother:
    """Smooth the way since the last stance when the foot has left the next one: one stride late.

    What comes out knows all samples up to the end of that stance, and no later one.  A stance is
    left once the foot is `SHORTEST` away: before, it shifted, and the stance goes on.  Where
    nothing is left for `LONGEST_NS` what there is comes out, so that memory is bounded.
    """

    def __init__(self, navigator: InertialNavigator) -> None:
        self._navigator = navigator
        navigator.keep().needed_ns = 0
        self._begin()

    def _begin(self) -> None:
        self._begun = self._navigator.strides  # anew at each start
        self._from_ns: int | None = None
        self._last_ns = 0
        self._stood: tuple[int, Vector] | None = None  # when and where last

    def take(self, states: StateBlock) -> list[StateBlock]:
        """Take the next states that the navigator gave; return smoothed ones, in their order."""
        if self._navigator.strides is not self._begun:
            self._begin()
        found = []
        columns = (states.stamp_ns, states.stationary, states.position)
        for stamp_ns, rests, position in zip(*(each.tolist() for each in columns), strict=True):
            if self._from_ns is None:
                self._need(stamp_ns)
            elif stamp_ns > self._from_ns + LONGEST_NS:
                found.append(self._smooth(self._last_ns))
                self._need(stamp_ns)
            if rests:
                self._stood = stamp_ns, position
            elif self._stood is not None and dist(self._stood[1], position) > SHORTEST:
                found.append(self._smooth(self._stood[0]))
                self._need(self._stood[0] + 1)
            self._last_ns = stamp_ns
        return found

    def flush(self) -> list[StateBlock]:
        """Return what is left, as at the end."""
        if self._from_ns is None:
            return []
        left = self._smooth(self._last_ns)
        self._begin()
        return [left]

    def _need(self, from_ns: int) -> None:
        self._from_ns = self._navigator.keep().needed_ns = from_ns
        self._stood = None

    def _smooth(self, last_ns: int) -> StateBlock:
        """Return the states from the first that is needed to that of a stamp, smoothed."""
        assert self._from_ns is not None
        found = []
        for block in smoothed(reversed(self._navigator.keep().stretches), last_ns):
            begin = int(np.searchsorted(block.stamp_ns, self._from_ns))
            found.append(block.part(begin, len(block)))
            if begin > 0:
                break
        return StateBlock.join(found[::-1])


def smoothed(stretches: Iterable[Stretch], last_ns: int | None = None) -> Iterator[StateBlock]:
    """Give the smoothed states of stretches, which come from the last to the first, in blocks.

    ``last_ns`` is the stamp of the last sample that they know; of all where that is None.
    """
    trace = np.empty((STRETCH, layout.TRACE_ROW))
    adjoint = np.zeros((layout.ERRORS, 1))
    information = np.zeros((layout.ERRORS, layout.ERRORS))
    for stretch in stretches:
        rows = stretch.count
        if last_ns is not None:
            rows = min(rows, stretch.first + bisect_right(stretch.stamps, last_ns))
            if rows <= stretch.first:
                continue
        out = np.empty((rows, layout.STATE_ROW))
        log = np.empty((LARGEST_LOG * rows + OF_AID * len(stretch.aids), layout.LOG_ROW))
        done = stretch.run(stretch.state.copy(), out, trace, log, rows)
        smooth(trace[:done], log, stretch.rules, adjoint, information, out[:done])
        if done:
            yield state_block(np.array(stretch.stamps[:done], np.int64), out[:done])
        if stretch.begins:
            adjoint[:] = information[:] = 0.0
