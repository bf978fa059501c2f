"""Smooth what a navigator has filtered: each state then knows all samples."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dead_reckoning.core.blocks import Array, Stamps, StateBlock
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.kernels.navigation.filter import navigate
from dead_reckoning.core.kernels.navigation.smoother import smooth
from dead_reckoning.core.navigation.aids import NO_AIDS
from dead_reckoning.core.navigation.states import state_block
from dead_reckoning.core.navigator import STRETCH, InertialNavigator

LARGEST_LOG = 16
"""Updates of one sample at most."""


class Smoother:
    """Record what a navigator takes, and go back through it at the end.

    Between a state that is kept for each `STRETCH` samples the filter runs again, so that only the
    samples themselves stay in memory, 96 bytes each; the rest, 2 KB a sample, is there for one
    stretch.  docs/navigation.md derives the recursion.
    """

    def __init__(self, navigator: InertialNavigator) -> None:
        """Record from now on all that ``navigator`` takes."""
        self._stretches: list[_Stretch] = []
        navigator.record = self._record

    def _record(
        self,
        samples: Array,
        verdicts: Array,
        aids: Array,
        stamps: Stamps,
        rules: Array,
        state: Array,
    ) -> None:
        last = self._stretches[-1] if self._stretches else None
        begins = state[layout.SEEN] == 0.0 and state[layout.WAITING] == 0.0
        full = last is not None and last.count + len(samples) > STRETCH
        if last is None or begins or full or last.rules is not rules:
            waiting = int(state[layout.WAITING])
            late = np.concatenate(last.stamps)[-waiting:] if last and waiting else stamps[:0]
            last = _Stretch(state, rules, late, begins)
            self._stretches.append(last)
        last.add(samples, verdicts, aids, stamps)

    def blocks(self) -> Iterator[StateBlock]:
        """Give the smoothed states, in blocks from the last to the first."""
        trace = np.empty((STRETCH, layout.TRACE_ROW))
        log = np.empty((LARGEST_LOG * STRETCH, layout.LOG_ROW))
        adjoint, information = (
            np.zeros((layout.ERRORS, 1)),
            np.zeros((layout.ERRORS, layout.ERRORS)),
        )
        for stretch in reversed(self._stretches):
            samples, verdicts = stretch.samples[: stretch.count], stretch.verdicts[: stretch.count]
            out = np.empty((stretch.count, layout.STATE_ROW))
            aids = np.concatenate(stretch.aids)
            done = navigate(
                samples, verdicts, aids, stretch.rules, stretch.state.copy(), out, trace, log
            )
            smooth(trace[:done], log, stretch.rules, adjoint, information, out[:done])
            if done:
                yield state_block(np.concatenate(stretch.stamps)[:done], out[:done])
            if stretch.begins:
                adjoint[:] = information[:] = 0.0


class _Stretch:
    """Samples with their verdicts, and the state of the filter before them.

    ``stamps`` begin with those of the samples that waited then; ``begins`` says that there was no
    sample before.
    """

    def __init__(self, state: Array, rules: Array, waiting: Stamps, begins: bool) -> None:
        self.state, self.rules, self.begins = state.copy(), rules, begins
        self.samples = np.empty((STRETCH, layout.ROW))
        self.verdicts = np.empty((STRETCH, 3))
        self.aids = [NO_AIDS]
        self.stamps = [waiting]
        self.count = 0

    def add(self, samples: Array, verdicts: Array, aids: Array, stamps: Stamps) -> None:
        """Keep samples; one with a step below 0 is none, and has no stamp."""
        if len(aids):
            later = aids.copy()
            later[:, 0] += self.count
            self.aids.append(later)
        end = self.count + len(samples)
        self.samples[self.count : end] = samples
        self.verdicts[self.count : end] = verdicts
        self.stamps.append(stamps.copy())
        self.count = end
