"""Judge rest by a statistic of a moving window: what most detectors have in common."""

from __future__ import annotations

from typing import Any, ClassVar

from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.stationarity import rules_of, state_of
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.stationarity import Watch


class WindowDetector:
    """Hold the body for resting while the statistic is below a threshold that follows the gait.

    A subclass names its settings, which have ``least`` and ``most`` and may have ``weight``, and
    the kernel that judges by its statistic.  At the first samples, and at the last, the window
    holds those there are.
    """

    Settings: ClassVar[type[Settings]]
    JUDGE: ClassVar[staticmethod[[Array, Array, Array, Array], None]]

    def __init__(self, settings: Any, watch: Watch) -> None:
        self.delay = watch.delay
        self._watch = watch
        weight = getattr(settings, 'weight', 0.0)
        self._rules = rules_of(watch, settings.least, settings.most, weight)
        self.reset()

    def reset(self) -> None:
        """Forget all samples."""
        self._state = state_of(self._watch)

    def take(self, samples: Array, verdicts: Array) -> None:
        """Judge samples, as `StationarityDetector` has it."""
        self.JUDGE(samples, self._rules, self._state, verdicts)
