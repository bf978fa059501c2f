"""A gyroscope as its data sheet describes it: what one reading can say of a rate of turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Gyroscope:
    """A three-axis digital gyroscope.

    ``range``       largest rate, ± [rad/s]; a reading there may stand for any rate beyond.
    ``noise``       of one reading, one sigma [rad/s].
    ``resolution``  size of one count [rad/s]; zero for none.
    """

    range: float
    noise: float
    resolution: float

    def reading(self, rate_s: Array) -> Array:
        """Round to whole counts and keep within the range, shape (n, 3) [rad/s], frame s."""
        if self.resolution > 0.0:
            rate_s = np.floor(rate_s / self.resolution + 0.5) * self.resolution
        reading: Array = np.clip(rate_s, -self.range, self.range)
        return reading

    def saturated(self, rate_s: Array) -> NDArray[np.bool_]:
        """Say which readings, shape (n, 3) [rad/s], stand at an end of the range."""
        ends: NDArray[np.bool_] = np.abs(rate_s) >= self.range - 0.5 * self.resolution
        return ends

    def variance(self, averaged: int) -> float:
        """Return the variance [rad²/s²] of an axis of the mean of ``averaged`` readings.

        Noise averages out; a count of rounding may not, where noise is too small to dither it.
        """
        return self.noise**2 / averaged + self.resolution**2 / 12.0
