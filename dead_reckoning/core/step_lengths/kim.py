"""Kim's cube root: a longer step is rougher all along."""

from __future__ import annotations

from math import pow
from typing import ClassVar

from dead_reckoning.core.step_detectors import Step


class RootOfRoughness:
    """d = k · ∛( mean |f − avg| ), of the magnitudes in a step.

    J. W. Kim, H. J. Jang, D.-H. Hwang, C. Park, A Step, Stride and Heading Determination for the
    Pedestrian Navigation System, Journal of Global Positioning Systems 3 (2004) 273–279: the
    absolute acceleration without gravity, which is here the mean of the step.  All samples count,
    so one jolt says little.
    """

    K: ClassVar[float] = 0.55
    UNIT: ClassVar[str] = 'm^⅔ s^⅔'

    def size(self, step: Step, height: float) -> float:
        """Return the root, 0 without samples."""
        samples = step.samples
        if not samples:
            return 0.0
        mean = sum(samples) / len(samples)
        return pow(sum(abs(sample - mean) for sample in samples) / len(samples), 1.0 / 3.0)


MODEL = RootOfRoughness()
