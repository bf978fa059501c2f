"""AN-900, equation (2): the bounce by double integration, freed of what springs."""

from __future__ import annotations

from itertools import accumulate
from math import sqrt
from typing import ClassVar

from dead_reckoning.core.step_detectors import Step


class BounceOfStep:
    """d = k · √( (max − min) / (avg − min) · |ΣΣ (f − avg)| Δt² ), of the magnitudes in a step.

    Analog Devices AN-900 (2006), equation (2), with the time Δt between samples that it leaves to
    the constant.  The double sum is a length, in proportion to how far the hip goes up and down;
    the ratio is that of equation (1) upside down.  AN-900 reports 6 % over several people and
    paces.

    The double sum depends on where the step is cut from the next: started while the hip goes at
    the speed v₀, it is −v₀ times the step's duration.  Here it is taken from the sample of the
    step at which it comes out largest, as the hip is fastest there, so that a detector that cuts
    elsewhere at another pace does not change the length.  The equation does not say where to cut;
    the listing cuts where its moving sum crosses.

    k: 1.07 to 1.17 √m make the simulated walk as long as it is, 1.0 to 1.1 straight walks with a
    sensor on the lower back.  The listing has 0.0249, which is 1.47 √m if it means feet
    (docs/pedometer.md).
    """

    K: ClassVar[float] = 1.05
    UNIT: ClassVar[str] = '√m'

    def size(self, step: Step, height: float) -> float:
        """Return the root, 0 where nothing varies."""
        samples = step.samples
        if not samples:
            return 0.0
        mean = sum(samples) / len(samples)
        low, high = min(samples), max(samples)
        if not mean > low:
            return 0.0
        velocities = list(accumulate([sample - mean for sample in samples], initial=0.0))
        least, most, displacement = min(velocities), max(velocities), sum(velocities)
        # Started after the sample with velocity v, the sum of all n velocities has n·v less.
        count = len(samples)
        displacement = max(displacement - count * least, count * most - displacement)
        return sqrt((high - low) / (mean - low) * displacement) * step.interval


MODEL = BounceOfStep()
