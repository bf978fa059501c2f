"""Judge rest by a statistic of a moving window: what most detectors have in common."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.stationarity import FLOOR, rules_of, state_of
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.stationarity import STATISTIC, Watch


class WindowDetector:
    """Hold the body for resting while its statistic is below a threshold.

    That follows the noise at rest and the swings of the gait: docs/navigation.md.  A subclass
    names its settings, which have ``least`` and ``share`` and may have ``weight``, and the kernel
    that judges by its statistic.  At the first samples, and at the last, the window holds those
    there are.
    """

    Settings: ClassVar[type[Settings]]
    JUDGE: ClassVar[staticmethod[[Array, Array, Array, Array], None]]

    def __init__(self, settings: Any, watch: Watch) -> None:
        self.delay = watch.delay
        self._watch = watch
        self._own = settings.least, settings.share, getattr(settings, 'weight', 0.0)
        self._rules = rules_of(watch, *self._own)
        self.reset()

    def reset(self) -> None:
        """Forget all samples."""
        self._state = state_of(self._watch)

    def learn(self, rest: Array) -> None:
        """Take the median of the statistic of a rest, as `StationarityDetector` has it."""
        watch = self._watch
        width = watch.behind + watch.ahead + 1
        prompt = watch._replace(behind=width - 1, ahead=0, minimum=1)
        said = np.empty((len(rest), 3))
        self.JUDGE(rest, rules_of(prompt, *self._own), state_of(prompt), said)
        noise = float(np.median(said[min(width, len(rest)) - 1 :, STATISTIC]))
        self._rules[FLOOR] = max(self._own[0], watch.factor * noise)

    def take(self, samples: Array, verdicts: Array) -> None:
        """Judge samples, as `StationarityDetector` has it."""
        self.JUDGE(samples, self._rules, self._state, verdicts)
