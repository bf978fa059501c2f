"""Let several detectors of rest vote."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.stationarity import STATIONARY, StationarityDetector


class Vote:
    """Hold the body for resting where enough detectors do.

    Verdicts come as late as those of the latest detector; statistic and threshold are those of the
    first.
    """

    def __init__(self, detectors: Sequence[StationarityDetector], votes: int) -> None:
        """``votes`` is how many make a rest."""
        self._detectors = detectors
        self._votes = votes
        self.delay = max(detector.delay for detector in detectors)
        self._forget()

    def reset(self) -> None:
        """Forget all samples."""
        for detector in self._detectors:
            detector.reset()
        self._forget()

    def _forget(self) -> None:
        """Let those that are early wait, at first with nothing."""
        nothing = (np.nan, np.nan, 0.0)
        self._early = [np.tile(nothing, (self.delay - d.delay, 1)) for d in self._detectors]

    def learn(self, rest: Array) -> None:
        """Let each learn from a rest, as `StationarityDetector` has it."""
        for detector in self._detectors:
            detector.learn(rest)

    def take(self, samples: Array, verdicts: Array) -> None:
        """Judge samples, as `StationarityDetector` has it."""
        n, said = len(samples), np.empty_like(verdicts)
        votes = np.zeros(n)
        for index, detector in enumerate(self._detectors):
            detector.take(samples, said)
            both = np.concatenate((self._early[index], said))
            self._early[index] = both[n:]
            votes += both[:n, STATIONARY]
            if index == 0:
                verdicts[:] = both[:n]
        verdicts[:, STATIONARY] = (votes >= self._votes) & (votes > 0.0)
