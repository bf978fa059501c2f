"""From the counts of an accelerometer to samples: average, calibrate, convert."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.errors import CalibrationError, DeadReckoningError, NotAtRestError
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import ImuSample, Matrix, Vector
from dead_reckoning.core.work import Work
from dead_reckoning.core.zero_g import ZeroGCalibration

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Conversions:
    """Readings of an ADC: stamps, shape (n,) [ns], and counts, shape (n, 3), in order of time."""

    stamps_ns: NDArray[np.int64]
    counts: Array


class FrontEnd:
    """Average conversions into samples, stamped at the middle of their block, and calibrate.

    AN3397 averages 64 conversions into one.  Clipped conversions are counted, and the sample they
    went into says so by its covariance: the range squared on that axis.  While the calibration at
    the start runs, no sample comes out; if it fails, samples come with the nominal offsets and
    ``finding`` says why.
    """

    def __init__(
        self,
        model: Accelerometer,
        *,
        frame_id: str,
        samples_per_message: int,
        calibration_samples: int,
        rest_deviation: float,
        calibrate_on_start: bool,
    ) -> None:
        self.model = model
        self.zero_g: Array = np.array(model.zero_g)
        """Output at zero g in force, shape (3,) [V]."""
        self.clipped = 0
        """Conversions so far with an axis at the end of its range."""
        self.finding: DeadReckoningError | None = None
        """Why the calibration at the start failed, for whoever reports it and clears it."""
        self._frame_id = frame_id
        self._per_message = samples_per_message
        self._calibration_samples = calibration_samples
        self._rest_deviation = rest_deviation
        self._variance = model.variance(samples_per_message)
        self._stamps_ns = np.empty(0, dtype=np.int64)
        self._counts: Array = np.empty((0, 3))
        self._work = Work()
        self._silent = calibrate_on_start
        self._calibration = self._new_calibration() if calibrate_on_start else None

    def _new_calibration(self) -> ZeroGCalibration:
        return ZeroGCalibration(self.model, self._calibration_samples, self._rest_deviation)

    def calibrate(self) -> Future[str]:
        """Find the zero-g offsets from the coming conversions, at rest and level.

        The future ends with a sentence for the user, or with `NotAtRestError` or
        `CalibrationError`; the offsets in force change only if it succeeds.
        """
        self._calibration = self._new_calibration()
        return self._work.begin()

    def add(self, conversions: Conversions) -> list[ImuSample]:
        """Take conversions, return the samples they complete; those left over wait.

        However the conversions are cut into calls, the samples are the same.
        """
        stamps_ns, counts = conversions.stamps_ns, conversions.counts
        calibration = self._calibration
        if calibration is None:
            return self._average(stamps_ns, counts)
        needed = calibration.missing
        calibration.add(counts[:needed])
        samples = [] if self._silent else self._average(stamps_ns[:needed], counts[:needed])
        if calibration.missing:
            return samples
        self._finish_calibration(calibration)
        self._silent = False
        return samples + self._average(stamps_ns[needed:], counts[needed:])

    def _average(self, stamps_ns: NDArray[np.int64], counts: Array) -> list[ImuSample]:
        stamps_ns = np.concatenate((self._stamps_ns, stamps_ns))
        counts = np.concatenate((self._counts, counts))
        n = self._per_message
        whole = len(counts) // n * n
        self._stamps_ns, self._counts = stamps_ns[whole:], counts[whole:]
        return [
            self._sample(stamps_ns[start : start + n], counts[start : start + n])
            for start in range(0, whole, n)
        ]

    def _finish_calibration(self, calibration: ZeroGCalibration) -> None:
        self._calibration = None
        try:
            self.zero_g = calibration.finish()
        except (NotAtRestError, CalibrationError) as error:
            if not self._work.running:
                self.finding = error
            self._work.fail(error)
            return
        off = (self.zero_g - np.array(self.model.zero_g)) / np.array(self.model.sensitivity)
        said = ', '.join(f'{value:+.4f}' for value in off)
        self._work.succeed(
            f'offset of x, y, z: {said} g; if gravity was taken from rest before, level again'
        )

    def _sample(self, stamps_ns: NDArray[np.int64], counts: Array) -> ImuSample:
        clipped = self.model.clipped(counts)
        variance = self._variance
        if clipped.any():
            self.clipped += int(clipped.any(axis=1).sum())
            limit = (self.model.range_g * GRAVITY) ** 2
            variance = np.where(clipped.any(axis=0), limit, variance)
        x, y, z = variance.tolist()
        covariance: Matrix = (x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z)
        fx, fy, fz = self.model.force(counts.mean(axis=0), self.zero_g).tolist()
        force: Vector = (fx, fy, fz)
        stamp_ns = (int(stamps_ns[0]) + int(stamps_ns[-1])) // 2
        return ImuSample(stamp_ns, self._frame_id, force, covariance)
