"""How far a constant error of attitude and offset carries velocity and position away."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.acceleration_error import write_jacobian
from dead_reckoning.core.samples import ZERO, Matrix, Vector

FLOOR = 1e-9
"""Variance that is always there [m², m²/s²]: zero would read as unknown."""


class BiasGrowth:
    """Carry the covariance of position and velocity through double integration.

    A wrong attitude, a wrong magnitude of gravity and the rest of an offset are constant, so they
    are no noise that averages out: an attitude error θ (world), an error γ of gravity (up) and an
    offset b (sensor) add ``rot_ws·b − [f_w]×·θ − (0, 0, γ)`` to every acceleration.  The
    sensitivities of position and velocity to (θ, γ, b) are integrated beside them, so at rest the
    deviation of position grows as ½·g·σ·t².  White noise is carried beside it, one variance for
    all axes.  ``axes`` says along which axes of the sensor the body moves at all.  Derived in
    docs/integrator.md, "Covariance".
    """

    def __init__(self, offset_deviation: float, axes: Sequence[bool] = (True, True, True)) -> None:
        self._mask = None if all(axes) else np.diag([float(moves) for moves in axes])
        self._sigma = np.zeros((7, 7))
        self._sigma[4:, 4:] = offset_deviation**2 * np.eye(3)
        self._attitude_covariance: Matrix | None = None
        self._jacobian = np.zeros((3, 7))
        self.reset()

    def reset(self) -> None:
        """Forget all growth: position and velocity are known."""
        self._sensitivity = np.zeros((6, 7))  # rows: position, velocity; columns: θ, γ, b
        self._pp = self._pv = self._vv = 0.0
        self.forget()

    def forget(self) -> None:
        """Compute covariances anew, now that something has changed what they come from."""
        self._known: tuple[float, tuple[Matrix, Matrix]] | None = None
        self._stopped = False

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
        """Grow over one sample.

        ``dt`` [s]; ``force_w`` the specific force, shape (3,) [m/s²], world; ``attitude`` the
        covariance of the attitude, shape (3, 3) [rad²], world; ``noise`` that of the specific
        force of one sample, shape (3, 3) [m²/s⁴]; ``velocity_w`` the velocity at the end of the
        step, which matters only to a body that carries it along (`HeadingGrowth`);
        ``gravity_variance`` [m²/s⁴] that of the magnitude of gravity.
        """
        self.forget()
        if attitude is not self._attitude_covariance:
            self._attitude_covariance = attitude
            self._sigma[:3, :3] = np.reshape(attitude, (3, 3))
        self._sigma[3, 3] = gravity_variance
        write_jacobian(self._jacobian, rot_ws, force_w, self._mask)
        rate = self._sensitivity[3:]
        self._sensitivity[:3] += dt * rate + (0.5 * dt * dt) * self._jacobian
        rate += dt * self._jacobian
        variance = (noise[0] + noise[4] + noise[8]) / 3.0
        self._coast(dt)
        self._pp += 0.25 * variance * dt**4
        self._pv += 0.5 * variance * dt**3
        self._vv += variance * dt * dt

    def gap(self, dt: float, speed: float, acceleration: float) -> None:
        """Grow over a time ``dt`` [s] without samples in which nothing was integrated.

        ``speed`` [m/s] is what the body had, ``acceleration`` [m/s²] one sigma of what it may have
        done meanwhile.
        """
        self.forget()
        self._sensitivity[:3] += dt * self._sensitivity[3:]
        self._coast(dt)
        self._pp += (speed * dt) ** 2 + (0.5 * acceleration * dt * dt) ** 2
        self._pv += 0.5 * acceleration**2 * dt**3
        self._vv += (acceleration * dt) ** 2

    def _coast(self, dt: float) -> None:
        self._pp += 2.0 * dt * self._pv + dt * dt * self._vv
        self._pv += dt * self._vv

    def stop(self) -> None:
        """Take note that the velocity is known to be zero; what position has gathered stays."""
        if self._stopped:
            return  # as at each sample of a rest
        self.forget()
        self._stopped = True
        self._sensitivity[3:] = 0.0
        self._pv = self._vv = 0.0

    def stop_along(self, axis_w: Vector) -> None:
        """Take note that the velocity along one axis, shape (3,), unit length, world, is zero."""
        self.forget()
        axis = np.array(axis_w)
        self._sensitivity[3:] -= np.outer(axis, axis @ self._sensitivity[3:])

    def covariances(self, velocity_variance: float = 0.0) -> tuple[Matrix, Matrix]:
        """Return the covariances of position [m²] and velocity [m²/s²], shapes (3, 3), world.

        ``velocity_variance`` [m²/s²] is added to each axis of the velocity.
        """
        if self._known is None or self._known[0] != velocity_variance:
            covariance = self._sensitivity @ self._sigma @ self._sensitivity.T
            position = _sum(covariance[:3, :3], self._pp + FLOOR)
            velocity = _sum(covariance[3:, 3:], self._vv + FLOOR + velocity_variance)
            self._known = (velocity_variance, (position, velocity))
        return self._known[1]


def _sum(covariance: NDArray[np.float64], variance: float) -> Matrix:
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = covariance.tolist()
    return (xx + variance, xy, xz, yx, yy + variance, yz, zx, zy, zz + variance)
