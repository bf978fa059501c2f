"""Learn the bias of a gyro from rests, and only from rests."""

from __future__ import annotations

from math import sqrt

from dead_reckoning.core.errors import CalibrationError, NotAtRestError
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest import Rest
from dead_reckoning.core.rest_search import RestSearch, Stillness
from dead_reckoning.core.rotation import rotate
from dead_reckoning.core.samples import ZERO, ImuSample, Matrix, Vector

HIDDEN = 0.1
"""One sigma of the turn that a rest may hide, as a part of `gravity.rest_rate`."""

PUSH = 0.1
"""Horizontal force at rest beyond what the tilt explains [m/s²]."""

FORCE_FLOOR = 0.01
"""By how much the mean force of two windows at rest may differ beyond its noise [m/s²]."""


class GyroBias:
    """Keep the bias and its variance; take the mean rate of a rest for it, weighted by both.

    A slow turn, as of a vehicle under way, looks like rest to a gyro with a bias.  So the rate
    must be no more than a bias can have become, the force vertical, and both the same as in the
    window before: a turn on the way hardly leaves all three as they are.
    """

    def __init__(self, settings: GravitySettings) -> None:
        self._settings = settings
        self.value: Vector = ZERO
        """Shape (3,) [rad/s], frame of the sensor."""
        self.variance = 0.0
        """Of each axis [rad²/s²]."""
        self._search = RestSearch(settings, with_rate=True)
        self._before: Stillness | None = None

    def set(self, rate: Rest) -> None:
        """Take the mean rate of a rest for the bias.

        Raises `CalibrationError` where it is more than a bias can be.
        """
        fastest = _length(rate.mean)
        if fastest > self._settings.rate_offset:
            raise CalibrationError(
                f'the gyro shows a steady turn of {fastest:.3g} rad/s: hold the device still; or '
                'its unit is °/s instead of rad/s; or, if its bias is that large, raise '
                'gravity.rate_offset'
            )
        self.value = rate.mean
        self.variance = self._variance_of(rate)

    def wander(self, dt: float) -> None:
        """Let it drift for ``dt`` [s]."""
        self.variance += self._settings.rate_walk**2 * dt

    def learn(self, imu: ImuSample, rot_ws: Matrix) -> float:
        """Look at one sample; return the weight that a rest it completes got, 0 to 1."""
        try:
            still = self._search.add(imu)
        except NotAtRestError:
            self._before = None
            return 0.0
        if still is None or still.rate is None:
            return 0.0
        before, self._before = self._before, still
        if before is None or before.rate is None:
            return 0.0
        x, y, _ = rotate(rot_ws, still.force.mean)
        lag = 2.0 * self._settings.tilt_time * sqrt(self.variance)  # of the tilt, by a wrong bias
        ax, ay, az = (m - b for m, b in zip(still.rate.mean, self.value, strict=True))
        if (
            sqrt(x * x + y * y) > PUSH + 3.0 * lag * _length(still.force.mean)
            or _length((ax, ay, az)) > self._settings.rest_rate + 3.0 * sqrt(self.variance)
            or not _agree(before.force, still.force, FORCE_FLOOR)
            or not _agree(before.rate, still.rate, self._settings.rate_walk)
        ):
            return 0.0
        hidden = (HIDDEN * self._settings.rest_rate) ** 2
        weight = self.variance / (self.variance + self._variance_of(still.rate) + hidden)
        bx, by, bz = self.value
        self.value = (bx + weight * ax, by + weight * ay, bz + weight * az)
        self.variance *= 1.0 - weight
        return weight

    def _variance_of(self, rate: Rest) -> float:
        return max(rate.deviation) ** 2 / rate.count + self._settings.rate_walk**2


def _agree(before: Rest, after: Rest, floor: float) -> bool:
    """Say whether two windows show one value, as far as their noise lets see."""
    for axis in range(3):
        noise = before.deviation[axis] ** 2 / before.count
        noise += after.deviation[axis] ** 2 / after.count
        if abs(after.mean[axis] - before.mean[axis]) > 4.0 * sqrt(noise) + floor:
            return False
    return True


def _length(vector: Vector) -> float:
    return sqrt(sum(v * v for v in vector))
