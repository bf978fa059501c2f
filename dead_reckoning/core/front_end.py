"""From the counts of an accelerometer to samples: average, calibrate, convert."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass
from math import isnan

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.errors import CalibrationError, DeadReckoningError, NotAtRestError
from dead_reckoning.core.gyroscope import Gyroscope
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import UNKNOWN, ImuSample, Matrix, Quaternion, Vector
from dead_reckoning.core.work import Work
from dead_reckoning.core.zero_g import ZeroGCalibration

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Conversions:
    """Readings of a sensor in order of time.

    ``stamps_ns``, shape (n,) [ns]; ``counts`` of the accelerometer, shape (n, 3); ``rates`` of the
    gyroscope, shape (n, 3) [rad/s], frame s; ``orientations`` of s in the world, shape (n, 4), as
    quaternions.  The last two are None where the device has none, NaN in a row where it gave none.
    """

    stamps_ns: NDArray[np.int64]
    counts: Array
    rates: Array | None = None
    orientations: Array | None = None

    def __len__(self) -> int:
        return len(self.counts)

    def part(self, start: int, stop: int | None = None) -> Conversions:
        """Return those from ``start`` to before ``stop``."""
        return Conversions(
            self.stamps_ns[start:stop],
            self.counts[start:stop],
            None if self.rates is None else self.rates[start:stop],
            None if self.orientations is None else self.orientations[start:stop],
        )

    def then(self, more: Conversions) -> Conversions:
        """Return these with ``more`` after them, from the same sensor."""
        if not len(self):
            return more
        return Conversions(
            np.concatenate((self.stamps_ns, more.stamps_ns)),
            np.concatenate((self.counts, more.counts)),
            _joined(self.rates, len(self), more.rates, len(more)),
            _joined(self.orientations, len(self), more.orientations, len(more)),
        )


class FrontEnd:
    """Average conversions into samples, stamped at the middle of their block, and calibrate.

    AN3397 averages 64 conversions into one; the orientation is that of the middle one.  Clipped
    conversions are counted, and the sample they went into says so by its covariance: the range
    squared on that axis; so for a gyroscope beside the accelerometer.  While the calibration at
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
        gyroscope: Gyroscope | None = None,
        orientation_covariance: Matrix = UNKNOWN,
    ) -> None:
        self.model = model
        self.zero_g: Array = np.array(model.zero_g)
        """Output at zero g in force, shape (3,) [unit of the output]."""
        self.clipped = 0
        """Conversions so far with an axis at the end of its range."""
        self.saturated = 0
        """Readings of the gyroscope so far with an axis at the end of its range."""
        self.finding: DeadReckoningError | None = None
        """Why the calibration at the start failed, for whoever reports it and clears it."""
        self._frame_id = frame_id
        self._per_message = samples_per_message
        self._calibration_samples = calibration_samples
        self._rest_deviation = rest_deviation
        self._variance = model.variance(samples_per_message)
        self._gyroscope = gyroscope
        self._orientation_covariance = orientation_covariance
        self._left = Conversions(np.empty(0, dtype=np.int64), np.empty((0, 3)))
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
        calibration = self._calibration
        if calibration is None:
            return self._average(conversions)
        needed = calibration.missing
        calibration.add(conversions.counts[:needed])
        samples = [] if self._silent else self._average(conversions.part(0, needed))
        if calibration.missing:
            return samples
        self._finish_calibration(calibration)
        self._silent = False
        return samples + self._average(conversions.part(needed))

    def interrupt(self) -> None:
        """Forget the conversions that wait: those to come do not follow on."""
        self._left = self._left.part(0, 0)

    def _average(self, conversions: Conversions) -> list[ImuSample]:
        waiting = self._left.then(conversions)
        n = self._per_message
        whole = len(waiting) // n * n
        self._left = waiting.part(whole)
        return [self._sample(waiting.part(start, start + n)) for start in range(0, whole, n)]

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

    def _sample(self, block: Conversions) -> ImuSample:
        counts, stamps_ns = block.counts, block.stamps_ns
        clipped = self.model.clipped(counts)
        variance = self._variance
        if clipped.any():
            self.clipped += int(clipped.any(axis=1).sum())
            limit = (self.model.range_g * GRAVITY) ** 2
            variance = np.where(clipped.any(axis=0), limit, variance)
        rate, rate_covariance = self._rate(block.rates)
        return ImuSample(
            (int(stamps_ns[0]) + int(stamps_ns[-1])) // 2,
            self._frame_id,
            _vector(self.model.force(counts.mean(axis=0), self.zero_g)),
            _diagonal(variance),
            rate,
            rate_covariance,
            *self._orientation(block.orientations),
        )

    def _orientation(self, orientations: Array | None) -> tuple[Quaternion | None, Matrix]:
        if orientations is None:
            return None, UNKNOWN
        x, y, z, w = orientations[len(orientations) // 2].tolist()
        return (None, UNKNOWN) if isnan(x) else ((x, y, z, w), self._orientation_covariance)

    def _rate(self, rates: Array | None) -> tuple[Vector | None, Matrix]:
        gyroscope = self._gyroscope
        if rates is None or gyroscope is None or np.isnan(rates).any():
            return None, UNKNOWN
        saturated = gyroscope.saturated(rates)
        variance = np.full(3, gyroscope.variance(self._per_message))
        if saturated.any():
            self.saturated += int(saturated.any(axis=1).sum())
            variance = np.where(saturated.any(axis=0), gyroscope.range**2, variance)
        return _vector(rates.mean(axis=0)), _diagonal(variance)


def _joined(first: Array | None, before: int, second: Array | None, after: int) -> Array | None:
    """Return rows one after the other, NaN for those that are not there; None if none are."""
    if first is None and second is None:
        return None
    width = (first if second is None else second).shape[1]  # type: ignore[union-attr]
    rows: Array = np.full((before + after, width), np.nan)
    if first is not None:
        rows[:before] = first
    if second is not None:
        rows[before:] = second
    return rows


def _vector(array: Array) -> Vector:
    x, y, z = array.tolist()
    return (x, y, z)


def _diagonal(variance: Array) -> Matrix:
    x, y, z = variance.tolist()
    return (x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z)
