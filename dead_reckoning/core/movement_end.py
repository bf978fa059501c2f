"""Say along which axes of the sensor a movement has ended."""

from __future__ import annotations

from collections import deque

from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.samples import Vector


class MovementEnd:
    """Count, for each axis, the samples in a row that look like rest.

    A sample inside the discrimination window is quiet, as in AN3397 and the mbed tutorial.  Of the
    noise of a sensor and of the tremor of a hand many samples are outside, though they move
    nothing: so a sample is quiet too if the mean of the last `movement_end_samples` is inside and
    their standard deviation is not above `movement_end_deviation`.  docs/integrator.md, "Movement
    end".
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget the samples so far."""
        self._recent: deque[Vector] = deque()
        self._sum = [0.0, 0.0, 0.0]
        self._squares = [0.0, 0.0, 0.0]
        self._quiet = [0, 0, 0]
        self._age = 0

    def add(self, accel_s: Vector, settings: IntegratorSettings) -> None:
        """Take the acceleration of one sample, shape (3,) [m/s²], frame of the sensor."""
        recent, n = self._recent, settings.movement_end_samples
        recent.append(accel_s)
        self._change(accel_s, 1.0)
        while len(recent) > n:
            self._change(recent.popleft(), -1.0)
        self._age += 1
        if self._age >= n:
            self._sum_anew()
        low, high = settings.window_minimum, settings.window_maximum
        largest = settings.movement_end_deviation**2
        count = len(recent)
        quiet = self._quiet
        for axis, value in enumerate(accel_s):
            if low <= value <= high:
                quiet[axis] += 1
                continue
            mean = self._sum[axis] / count
            rests = low <= mean <= high and self._squares[axis] / count - mean * mean <= largest
            quiet[axis] = quiet[axis] + 1 if rests else 0

    def ended(self, axis: int, settings: IntegratorSettings) -> bool:
        """Say whether the movement along an axis, 0 to 2, has ended."""
        return self._quiet[axis] >= settings.movement_end_samples

    def _change(self, accel_s: Vector, sign: float) -> None:
        x, y, z = accel_s
        total, squares = self._sum, self._squares
        total[0] += sign * x
        total[1] += sign * y
        total[2] += sign * z
        squares[0] += sign * x * x
        squares[1] += sign * y * y
        squares[2] += sign * z * z

    def _sum_anew(self) -> None:
        """Lose what rounding has left in the sums, which a large value makes large."""
        self._age = 0
        self._sum = [0.0, 0.0, 0.0]
        self._squares = [0.0, 0.0, 0.0]
        for accel_s in self._recent:
            self._change(accel_s, 1.0)
