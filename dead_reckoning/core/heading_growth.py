"""How far errors carry a body away that moves along one axis of its own."""

from __future__ import annotations

import numpy as np

from dead_reckoning.core.acceleration_error import cross_matrix, write_jacobian_along
from dead_reckoning.core.bias_growth import FLOOR
from dead_reckoning.core.samples import ZERO, Matrix, Vector


class HeadingGrowth:
    """Carry the covariance where the body carries its speed s along an axis u: ``v = s · u``.

    The speed errs by what gravity and the offset leave along the axis, and by noise; the direction
    errs by the attitude, ``δv = u δs + θ × v``, so position errs by heading error times distance.
    Derived in docs/integrator.md, "One axis along a heading".
    """

    def __init__(self, offset_deviation: float, axis: int) -> None:
        """``axis`` is that of the sensor, 0 to 2."""
        self._axis = axis
        self._sigma = np.zeros((7, 7))
        self._sigma[4:, 4:] = offset_deviation**2 * np.eye(3)
        self._attitude_covariance: Matrix | None = None
        self._jacobian = np.zeros((1, 7))
        self.reset()

    def reset(self) -> None:
        """Forget all growth: position and velocity are known."""
        self._ahead = np.zeros(3)
        self._position = np.zeros((3, 7))  # sensitivities to (θ, γ, b)
        self._velocity = np.zeros((3, 7))
        self._speed = np.zeros((1, 7))
        self._white = np.zeros((4, 4))  # of position and speed

    def step(
        self,
        dt: float,
        rot_ws: Matrix,
        force_w: Vector,
        attitude: Matrix,
        noise: Matrix,
        velocity_w: Vector = ZERO,
        gravity_variance: float = 0.0,
    ) -> None:
        """Grow over one sample; the arguments are those of `BiasGrowth.step`."""
        if attitude is not self._attitude_covariance:
            self._attitude_covariance = attitude
            self._sigma[:3, :3] = np.reshape(attitude, (3, 3))
        self._sigma[3, 3] = gravity_variance
        write_jacobian_along(self._jacobian, rot_ws, self._axis)
        self._speed += dt * self._jacobian
        self._position += (0.5 * dt) * self._velocity
        self._ahead = np.array(rot_ws[self._axis :: 3])
        self._velocity = self._ahead[:, np.newaxis] * self._speed
        self._velocity[:, :3] -= cross_matrix(velocity_w)
        self._position += (0.5 * dt) * self._velocity
        self._shake(dt, noise[4 * self._axis])

    def _shake(self, dt: float, variance: float) -> None:
        """Carry on what noise has done, and add an acceleration of that variance [m²/s⁴]."""
        transition = np.eye(4)
        transition[:3, 3] = dt * self._ahead
        entry = np.append(0.5 * dt * dt * self._ahead, dt)
        self._white = transition @ self._white @ transition.T + variance * np.outer(entry, entry)

    def gap(self, dt: float, speed: float, acceleration: float) -> None:
        """Grow over a time without samples; the arguments are those of `BiasGrowth.gap`."""
        self._position += dt * self._velocity
        self._shake(dt, acceleration**2)
        self._white.flat[:15:5] += (speed * dt) ** 2

    def stop(self) -> None:
        """Take note that the velocity is known to be zero; what position has gathered stays."""
        self._velocity[:] = 0.0
        self._speed[:] = 0.0
        self._white[3, :] = self._white[:, 3] = 0.0

    def stop_along(self, axis_w: Vector) -> None:
        """Take note that the velocity along the axis is zero: there is no other."""
        self.stop()

    def covariances(self, velocity_variance: float = 0.0) -> tuple[Matrix, Matrix]:
        """Return the covariances of position and velocity as `BiasGrowth.covariances` does."""
        position = self._position @ self._sigma @ self._position.T + self._white[:3, :3]
        velocity = self._velocity @ self._sigma @ self._velocity.T
        velocity += self._white[3, 3] * np.outer(self._ahead, self._ahead)
        position.flat[::4] += FLOOR
        velocity.flat[::4] += FLOOR + velocity_variance
        return tuple(position.ravel().tolist()), tuple(velocity.ravel().tolist())
