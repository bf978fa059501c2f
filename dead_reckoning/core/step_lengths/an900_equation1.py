"""AN-900, equation (1): how full the step's curve is."""

from __future__ import annotations

from typing import ClassVar

from dead_reckoning.core.step_detectors import Step


class FullnessOfStep:
    """d = k · (avg − min) / (max − min), of the magnitudes in a step.

    Analog Devices AN-900 (2006), equation (1): longer and faster steps have narrower troughs, so
    their mean lies higher between the extremes; no amplitude enters, so how springy a walk is does
    not either.  AN-900 found up to 10 % between people, and gives no k; 1.6 to 1.8 m fits straight
    walks with a sensor on the lower back.
    """

    K: ClassVar[float] = 1.7
    UNIT: ClassVar[str] = 'm'

    def size(self, step: Step, height: float) -> float:
        """Return (avg − min) / (max − min), 0 where nothing varies."""
        samples = step.samples
        if not samples:
            return 0.0
        low, high = min(samples), max(samples)
        if not high > low:
            return 0.0
        return max(0.0, min(1.0, (sum(samples) / len(samples) - low) / (high - low)))


MODEL = FullnessOfStep()
