"""An accelerometer as its circuit and its settings make it: specific force to counts, and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import Vector

Array = NDArray[np.float64]

UNITS = ('counts', 'volts', 'g', 'm/s2')
"""What readings of a sensor may come in, for `Accelerometer.counts_of`."""


@dataclass(frozen=True, kw_only=True)
class Accelerometer:
    """A three-axis accelerometer, analogue behind an ADC, or digital.

    ``output = zero_g + sensitivity · f/g`` along each axis, kept within ``swing``; then
    ``counts = round(output / unit_per_count)``, kept within ``limits``.  The unit of the output is
    the volt where an ADC follows, and the count itself where the sensor is digital.

    ``range_g``           nominal range ± [g].
    ``zero_g``            output at zero g, shape (3,) [unit].
    ``sensitivity``       shape (3,) [unit/g].
    ``zero_g_tolerance``  how far ``zero_g`` of a good part may be off [unit].
    ``swing``             lowest and highest output [unit].
    ``noise``             of one conversion, one sigma [unit].
    ``unit_per_count``    size of one count [unit].
    ``limits``            lowest and highest count.
    """

    range_g: float
    zero_g: Vector
    sensitivity: Vector
    zero_g_tolerance: float
    swing: tuple[float, float]
    noise: float
    unit_per_count: float
    limits: tuple[float, float]

    @property
    def force_per_count(self) -> Array:
        """Size of one count along each axis, shape (3,) [m/s²]."""
        return self.unit_per_count / np.array(self.sensitivity) * GRAVITY

    def output(self, force_s: Array) -> Array:
        """Return the output, shape (n, 3) [unit], for a force, shape (n, 3) [m/s²], frame s.

        The swing is not applied: noise comes before it.
        """
        output: Array = np.array(self.zero_g) + np.array(self.sensitivity) * force_s / GRAVITY
        return output

    def counts(self, output: Array, *, quantise: bool = True) -> Array:
        """Clip to the swing and convert, shape (n, 3); ``quantise`` off keeps the fractions."""
        return self.convert(np.clip(output, *self.swing), quantise=quantise)

    def convert(self, output: Array, *, quantise: bool = True) -> Array:
        """Do what the ADC does to an output, shape (n, 3) [unit], whatever its swing."""
        counts = output / self.unit_per_count
        if quantise:
            counts = np.floor(counts + 0.5)
        limited: Array = np.clip(counts, *self.limits)
        return limited

    def counts_of(self, readings: Array, unit: str) -> Array:
        """Return readings in one of `UNITS`, shape (n, 3), as counts with their fractions.

        A board that sends g or m/s² is taken to compute them with the nominal offset and
        sensitivity; what is beyond the ends of the converter stands at its end then, and so counts
        as clipped.
        """
        if unit == 'counts':
            return readings
        if unit == 'volts':
            return readings / self.unit_per_count
        force_s = readings * (GRAVITY if unit == 'g' else 1.0)
        return self.convert(self.output(force_s), quantise=False)

    def possible(self, counts: Array) -> NDArray[np.bool_]:
        """Say which rows of counts, shape (n, 3), the converter can give, to within a count."""
        low, high = self.limits
        within = (counts >= low - 1.0) & (counts <= high + 1.0)
        rows: NDArray[np.bool_] = np.logical_and.reduce(within, axis=1)
        return rows

    def force(self, counts: Array, zero_g: Array) -> Array:
        """Return the specific force, shape (n, 3) [m/s²], frame s, of counts, shape (n, 3).

        ``zero_g``, shape (3,) [unit], is the output at zero g as calibrated.
        """
        force: Array = (
            (counts * self.unit_per_count - zero_g) / np.array(self.sensitivity) * GRAVITY
        )
        return force

    def clipped(self, counts: Array) -> NDArray[np.bool_]:
        """Say which counts, shape (n, 3), stand at an end of the swing or of the counts."""
        swing = np.array(self.swing)
        rounded, exact = self.counts(swing), self.counts(swing, quantise=False)
        low, high = max(rounded[0], exact[0]), min(rounded[1], exact[1])
        ends: NDArray[np.bool_] = (counts <= low) | (counts >= high)
        return ends

    def variance(self, averaged: int) -> Array:
        """Return the variance, shape (3,) [m²/s⁴], of the mean of ``averaged`` conversions.

        Noise averages out; a count of quantisation may not, where noise is too small to dither it.
        """
        noise = self.noise / np.array(self.sensitivity) * GRAVITY
        variance: Array = noise**2 / averaged + self.force_per_count**2 / 12.0
        return variance
