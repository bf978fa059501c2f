"""Cadence and height: who walks faster takes longer steps, and who is taller, too."""

from __future__ import annotations

from math import sqrt
from typing import ClassVar

from dead_reckoning.core.step_detectors import Step


class CadenceAndHeight:
    """d = k · h · √(1/T), of a pedestrian's height h and the duration T of a step.

    Q. Tian, Z. Salcic, K. I.-K. Wang, Y. Pan, A Multi-Mode Dead Reckoning System for Pedestrian
    Tracking Using Smartphones, IEEE Sensors Journal 16 (2016) 2079–2093; V. Renaudin, M. Susi,
    G. Lachapelle, Step Length Estimation Using Handheld Inertial Sensors, Sensors 12 (2012)
    8507–8525, have a linear function of the cadence, with two constants for a person, instead of
    the root.  Nothing of the force enters: it holds wherever the device is, and is wrong for short
    steps at a usual cadence.
    """

    K: ClassVar[float] = 0.3
    UNIT: ClassVar[str] = '√s'

    def size(self, step: Step, height: float) -> float:
        """Return the height times the root of the cadence, 0 for a step that took no time."""
        return height / sqrt(step.duration) if step.duration > 0.0 else 0.0


MODEL = CadenceAndHeight()
