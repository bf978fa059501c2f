"""Find the zero-g offsets of an accelerometer that rests level: AN3397's `Calibrate`."""

from __future__ import annotations

from math import asin, degrees

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.errors import CalibrationError, NotAtRestError
from dead_reckoning.core.rest import GRAVITY

Array = NDArray[np.float64]

BLOCKS = 16
SIGMAS = 6.0


class ZeroGCalibration:
    """Average conversions at rest, and fit the offsets so that +g stays on the up axis.

    AN3397 averages 1024 conversions and takes the mean for zero, gravity and all; here the z axis
    keeps its +g.  `finish` refuses a device that moved, and offsets that no good part has.
    """

    def __init__(self, model: Accelerometer, conversions: int, deviation: float) -> None:
        """Expect ``conversions``; ``deviation`` [m/s²] is what one axis may show at rest."""
        self._model = model
        self._wanted = conversions
        self._deviation = deviation
        self._counts: list[Array] = []
        self._taken = 0

    @property
    def missing(self) -> int:
        """How many more conversions it takes to `finish`."""
        return self._wanted - self._taken

    def add(self, counts: Array) -> None:
        """Take conversions, shape (n, 3), at most as many as are `missing`."""
        self._counts.append(counts)
        self._taken += len(counts)

    def finish(self) -> Array:
        """Return the outputs at zero g, shape (3,) [unit of the output].

        Raises `NotAtRestError` if the device moved: the spread of all conversions is over
        ``deviation``, or the mean of a sixteenth of them is off the whole mean by more than noise
        and one count explain.  Raises `CalibrationError` if an offset is beyond the tolerance.
        """
        model = self._model
        counts = np.concatenate(self._counts)
        self._check_rest(counts)
        level = np.array([0.0, 0.0, 1.0]) * np.array(model.sensitivity)
        zero_g: Array = counts.mean(axis=0) * model.unit_per_count - level
        off = zero_g - np.array(model.zero_g)
        worst = int(np.argmax(np.abs(off)))
        if abs(off[worst]) > model.zero_g_tolerance:
            off_g = off[worst] / model.sensitivity[worst]
            tolerance_g = model.zero_g_tolerance / model.sensitivity[worst]
            tilt = degrees(asin(min(1.0, abs(off_g))))
            raise CalibrationError(
                f'the offset of axis {"xyz"[worst]} would be {off_g:+.3f} g, a good part has up '
                f'to ±{tolerance_g:.3f} g: the device is not level ({tilt:.0f}° would look like '
                'this), its z axis does not point up, or driver.range_g, driver.supply or '
                'driver.adc_reference do not fit the circuit'
            )
        return zero_g

    def _check_rest(self, counts: Array) -> None:
        model = self._model
        blocks = np.array_split(counts, min(BLOCKS, len(counts)))
        means = np.array([block.mean(axis=0) for block in blocks])
        within = np.sqrt(np.mean([block.var(axis=0) for block in blocks], axis=0))
        spread = counts.std(axis=0) * model.force_per_count
        allowed = SIGMAS * within / np.sqrt(len(counts) / len(blocks)) + 1.0
        wander = np.abs(means - counts.mean(axis=0))
        if spread.max() > self._deviation or (wander > allowed).any():
            moved = max(spread.max(), (wander * model.force_per_count).max())
            raise NotAtRestError(
                f'the device moved while it was calibrated: {moved:.3g} m/s² '
                f'({moved / GRAVITY * 1000:.0f} mg) on an axis; hold it still and ask again'
            )
