"""AN3397's movement-end check on the magnitude of the specific force."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import hypot
from typing import ClassVar

import numpy as np

from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.movement_end import MovementEnd as Count
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.stationarity import Watch


@dataclass(frozen=True, kw_only=True)
class MovementEndSettings(Settings, prefix='navigator.movement_end'):
    """Window and count of the check."""

    window: float = parameter(
        0.5,
        'A force that differs from gravity by no more counts as none',
        unit='m/s²',
        minimum=1e-6,
        maximum=1000.0,
    )
    deviation: float = parameter(
        0.15,
        'Largest standard deviation of samples whose mean counts as none; noise at rest raises it',
        unit='m/s²',
        minimum=0.0,
        maximum=1000.0,
    )
    samples: int = parameter(
        25, 'Samples in a row that end a movement', minimum=1, maximum=1_000_000
    )


class MovementEnd:
    """Hold the body for resting once the movement-end check of the integrator has ended.

    Freescale AN3397 counts samples inside the discrimination window; docs/integrator.md, "Movement
    end".  Here they are those of |f| − g, as a body that turns has no axis of its own to count on.
    The rest ends with the first sample outside.  It looks at no sample ahead, and the windows,
    durations and thresholds of the other detectors are not its own.  Where noise leaves the window
    the mean counts, so of the two it is the deviation that follows the noise at rest.
    """

    Settings: ClassVar[type[Settings]] = MovementEndSettings
    delay = 0

    def __init__(self, settings: MovementEndSettings, watch: Watch) -> None:
        """Take gravity from what all detectors know."""
        self._gravity, self._factor = watch.gravity, watch.factor
        self._deviation = settings.deviation
        self._window = settings.window
        self._rules = IntegratorSettings(
            window_minimum=-settings.window,
            window_maximum=settings.window,
            movement_end_samples=settings.samples,
            movement_end_deviation=settings.deviation,
        )
        self.reset()

    def reset(self) -> None:
        """Forget all samples."""
        self._count = Count()

    def learn(self, rest: Array) -> None:
        """Take the deviation of a rest, as `StationarityDetector` has it."""
        noise = float(np.linalg.norm(rest[:, 1:4], axis=1).std())
        largest = max(self._deviation, self._factor * noise)
        self._rules = replace(self._rules, movement_end_deviation=largest)

    def take(self, samples: Array, verdicts: Array) -> None:
        """Judge samples, as `StationarityDetector` has it."""
        for k, (x, y, z) in enumerate(samples[:, 1:4].tolist()):
            excess = hypot(x, y, z) - self._gravity
            self._count.add((excess, 0.0, 0.0), self._rules)
            verdicts[k] = abs(excess), self._window, self._count.ended(0, self._rules)


DETECTOR = MovementEnd
