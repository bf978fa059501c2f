"""Smooth what a navigator has filtered: each state then knows all samples."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dead_reckoning.core.blocks import Array, Stamps, StateBlock
from dead_reckoning.core.kernels import navigator as kernel
from dead_reckoning.core.kernels.smoother import smooth
from dead_reckoning.core.kernels.strapdown import ERRORS
from dead_reckoning.core.navigator import STRETCH, InertialNavigator, state_block

LARGEST_LOG = 9
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
        self, samples: Array, verdicts: Array, stamps: Stamps, rules: Array, state: Array
    ) -> None:
        last = self._stretches[-1] if self._stretches else None
        begins = state[kernel.SEEN] == 0.0 and state[kernel.WAITING] == 0.0
        if last is None or begins or last.count + len(samples) > STRETCH:
            waiting = int(state[kernel.WAITING])
            late = np.concatenate(last.stamps)[-waiting:] if last and waiting else stamps[:0]
            last = _Stretch(state, rules, late, begins)
            self._stretches.append(last)
        last.add(samples, verdicts, stamps)

    def blocks(self) -> Iterator[StateBlock]:
        """Give the smoothed states, in blocks from the last to the first."""
        trace = np.empty((STRETCH, kernel.TRACE_ROW))
        log = np.empty((LARGEST_LOG * STRETCH, kernel.LOG_ROW))
        adjoint, information = np.zeros((ERRORS, 1)), np.zeros((ERRORS, ERRORS))
        for stretch in reversed(self._stretches):
            samples, verdicts = stretch.samples[: stretch.count], stretch.verdicts[: stretch.count]
            out = np.empty((stretch.count, kernel.STATE_ROW))
            done = kernel.navigate(
                samples, verdicts, stretch.rules, stretch.state.copy(), out, trace, log
            )
            gravity = stretch.rules[kernel.GRAVITY]
            smooth(trace[:done], log, gravity, adjoint, information, out[:done])
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
        self.samples = np.empty((STRETCH, kernel.ROW))
        self.verdicts = np.empty((STRETCH, 3))
        self.stamps = [waiting]
        self.count = 0

    def add(self, samples: Array, verdicts: Array, stamps: Stamps) -> None:
        """Keep samples; one with a step below 0 is none, and has no stamp."""
        end = self.count + len(samples)
        self.samples[self.count : end] = samples
        self.verdicts[self.count : end] = verdicts
        self.stamps.append(stamps[samples[:, 0] >= 0.0])
        self.count = end
