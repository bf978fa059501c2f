"""Every step as long as the other."""

from __future__ import annotations

from typing import ClassVar

from dead_reckoning.core.step_detectors import Step


class ConstantLength:
    """d = k: hard to beat for one person at one pace.

    k is the length of a step; 0.7 m is common at an ordinary pace.
    """

    K: ClassVar[float] = 0.7
    UNIT: ClassVar[str] = 'm'

    def size(self, step: Step, height: float) -> float:
        """Return 1."""
        return 1.0


MODEL = ConstantLength()
