"""Weinberg's fourth root: a longer step bounces harder."""

from __future__ import annotations

from typing import ClassVar

from dead_reckoning.core.step_detectors import Step


class RootOfSwing:
    """d = k · ⁴√(max − min), of the magnitudes in a step.

    H. Weinberg, Using the ADXL202 in Pedometer and Personal Navigation Applications, Analog
    Devices AN-602 (2002), of the vertical acceleration.  The root is his finding, not geometry;
    one jolt in a step is its maximum.
    """

    K: ClassVar[float] = 0.41
    UNIT: ClassVar[str] = 'm^¾ s^½'

    def size(self, step: Step, height: float) -> float:
        """Return the root, 0 without samples."""
        samples = step.samples
        return (max(samples) - min(samples)) ** 0.25 if samples else 0.0


MODEL = RootOfSwing()
