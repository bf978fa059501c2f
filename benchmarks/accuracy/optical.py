"""What an optical system says of velocity and acceleration, from its positions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.signals import derivative, low_pass, rotations, second_derivative

Array = NDArray[np.float64]

CUT_OFF = 5.0
"""Low-pass [Hz] of accelerations: above it the noise of the positions, grown with f², shows."""

VELOCITY_CUT_OFF = 10.0
"""Low-pass [Hz] of the velocity, one derivative less and so less noisy."""


@dataclass(frozen=True)
class Mounting:
    """Where the markers are, and how late the inertial sensor is.

    ``lever_arm_s``, shape (3,) [m], leads from the markers to the sensor, frame of the sensor;
    ``delay`` [s] by which the sensor lags the optical system.
    """

    lever_arm_s: Array
    delay: float


class OpticalTruth:
    """Velocity and acceleration of the markers at each sample; NaN around what was not seen.

    ``position_w``, shape (n, 3) [m]; ``attitude`` (x, y, z, w), shape (n, 4); ``rate`` [Hz].
    """

    def __init__(self, position_w: Array, attitude: Array, rate: float) -> None:
        self._rate = rate
        self.position_w = position_w
        """Shape (n, 3) [m], world."""
        self.velocity_w = low_pass(derivative(position_w, rate), rate, VELOCITY_CUT_OFF)
        """Shape (n, 3) [m/s], world."""
        self.acceleration_w = low_pass(second_derivative(position_w, rate), rate, CUT_OFF)
        """Shape (n, 3) [m/s²], world."""
        self._rot_ws = rotations(attitude)

    def fit_mounting(self, acceleration_w: Array, chosen: NDArray[np.bool_]) -> Mounting:
        """Fit lever arm and delay to an inertial acceleration, low-passed like the truth.

        Least squares of ``a_imu − a_opt = d²(rot_ws · l)/dt² − δ · da_opt/dt`` over the chosen
        samples: four numbers that say how the truth was recorded, none of the estimate.
        """
        columns = np.concatenate((self._lever_effects(), -self._jerk()[:, :, None]), axis=2)
        difference = acceleration_w - self.acceleration_w
        known = chosen & ~np.isnan(columns).any(axis=(1, 2)) & ~np.isnan(difference).any(axis=1)
        solution = np.linalg.lstsq(
            columns[known].reshape(-1, 4), difference[known].ravel(), rcond=None
        )[0]
        return Mounting(solution[:3], float(solution[3]))

    def acceleration_at(self, mounting: Mounting) -> Array:
        """Return the acceleration of the sensor, as late as it sees it, shape (n, 3) [m/s²]."""
        lever: Array = self._lever_effects() @ mounting.lever_arm_s
        return self.acceleration_w + lever - mounting.delay * self._jerk()

    def at_sensor(self, mounting: Mounting) -> tuple[Array, Array]:
        """Return position and velocity of the sensor, as late as it sees them, shapes (n, 3)."""
        lever_w: Array = self._rot_ws @ mounting.lever_arm_s
        position = self.position_w + lever_w - mounting.delay * self.velocity_w
        turning = low_pass(derivative(lever_w, self._rate), self._rate, VELOCITY_CUT_OFF)
        return position, self.velocity_w + turning - mounting.delay * self.acceleration_w

    def _lever_effects(self) -> Array:
        """Accelerations that a metre of lever arm along each axis makes, shape (n, 3, 3)."""
        curve = second_derivative(self._rot_ws.reshape(-1, 9), self._rate)
        return low_pass(curve, self._rate, CUT_OFF).reshape(-1, 3, 3)

    def _jerk(self) -> Array:
        return derivative(self.acceleration_w, self._rate)
