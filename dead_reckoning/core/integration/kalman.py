"""A Kalman filter that learns from every rest what attitude and offset did to the motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.acceleration_error import (
    cross_matrix,
    write_jacobian,
    write_jacobian_along,
)
from dead_reckoning.core.bias_growth import FLOOR
from dead_reckoning.core.errors import DependencyError
from dead_reckoning.core.integration import Reading
from dead_reckoning.core.integration.settings import AXES, IntegratorSettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import Matrix, Vector

try:
    from filterpy.kalman import KalmanFilter
except ImportError as error:
    raise DependencyError(
        'integrator.method: kalman needs filterpy, which is not installed: pip install filterpy, '
        'or choose trapezoid'
    ) from error

Array = NDArray[np.float64]

GATE = 9.0
"""Square of the sigmas that a velocity at rest may be off before the model is not believed."""


class Kalman:
    """Estimate position, velocity, and the errors of attitude and offset that bend them.

    The state is (p, c, θ, γ, b): true position and velocity in the world; the errors θ of the
    attitude about the axes of the world and γ of the magnitude of gravity; the offset b along the
    axes of the sensor.  The bias of the acceleration is ``J · (θ, γ, b)``, as in `BiasGrowth`.
    The measured acceleration, past the window, is the control input; rests that the movement-end
    check finds are measurements of the velocity.  While the body rests the position is held.
    With one axis c is the speed along it.

    An attitude that becomes worse known adds to the variance of θ; one that becomes better known
    is taken for another attitude: what was learnt about it fades.  Derived in docs/integrator.md,
    "Kalman filter".
    """

    def __init__(self, settings: IntegratorSettings) -> None:
        self._settings = settings
        moves = [axis in settings.axes for axis in AXES]
        self._axis = moves.index(True) if sum(moves) == 1 else None
        self._mask: Array | None = None if all(moves) else np.diag(np.array(moves, dtype=float))
        m = 3 if self._axis is None else 1
        self._p, self._c, self._e = slice(0, 3), slice(3, 3 + m), slice(3 + m, 10 + m)
        self._theta, self._given = slice(3 + m, 6 + m), slice(3 + m, 7 + m)
        self._transition: Array = np.eye(10 + m)
        self._entry: Array = np.zeros((10 + m, m))  # of the acceleration
        self._process: Array = np.zeros((10 + m, 10 + m))
        self._jacobian: Array = np.zeros((m, 7))
        self._filter: Any = None

    @property
    def position(self) -> Vector:
        """Shape (3,) [m], world."""
        x, y, z = self._filter.x[self._p].tolist()
        return (x, y, z)

    @property
    def velocity(self) -> Vector:
        """Shape (3,) [m/s], world."""
        x, y, z = (self._ahead @ self._filter.x[self._c]).tolist()
        return (x, y, z)

    def start(self, reading: Reading) -> None:
        """Begin at the origin, at rest, with nothing learnt."""
        size, m = self._entry.shape
        self._filter = KalmanFilter(dim_x=size, dim_z=m)
        self._filter.x = np.zeros(size)
        self._filter.P = np.zeros((size, size))
        self._variances = _variances(reading)
        self._filter.P[self._e, self._e] = self._settings.offset_deviation**2 * np.eye(7)
        self._filter.P[self._given, self._given] = np.diag(self._variances)
        attitude = np.reshape(reading.attitude_covariance, (3, 3))
        self._filter.P[self._theta, self._theta] = attitude
        self._moving = 0.0
        self._swing: Array = np.zeros((3, 3))
        self._arrive(reading)

    def step(self, dt: float, reading: Reading) -> None:
        """Integrate over ``dt`` [s], which ends with this reading."""
        self._moving += dt
        self._predict(dt, reading, held=False)

    def hold(self, dt: float, reading: Reading) -> None:
        """Pass ``dt`` [s] in which the body rests: nothing moves, only the errors are learnt."""
        self._predict(dt, reading, held=True)

    def _predict(self, dt: float, reading: Reading, held: bool) -> None:
        ahead, swing, accel = self._ahead, self._swing, self._accel
        self._arrive(reading)
        mean = 0.5 * (accel + self._accel)
        f, c, e, half = self._transition, self._c, self._e, 0.5 * dt
        f[c, e] = -dt * self._jacobian
        self._turn(f[c] @ self._filter.x + dt * mean)
        if held:
            f[self._p, 3:] = 0.0
        else:
            f[self._p, c] = half * (ahead + self._ahead)
            f[self._p, e] = half * self._ahead @ f[c, e]
            f[self._p, self._theta] += half * (swing + self._swing)
        self._wander(dt, reading, self._noise(reading), held)
        self._filter.predict(mean, self._entry, f, self._process)

    def gap(self, dt: float, reading: Reading) -> None:
        """Hold position and velocity over ``dt`` [s], and know them less well."""
        speed = np.linalg.norm(self._filter.x[self._c])
        f, p = self._transition, self._p
        f[self._c, self._e] = f[p, self._e] = 0.0
        f[p, self._c] = dt * self._ahead
        f[p, self._theta] = dt * self._swing
        hidden = self._settings.gap_acceleration**2 * np.eye(3)
        self._wander(dt, reading, self._along_what_moves(reading, hidden))
        self._process.flat[: 3 * len(f) : len(f) + 1] += (speed * dt) ** 2
        self._filter.P = f @ self._filter.P @ f.T + self._process
        self._arrive(reading)
        self._turn(self._filter.x[self._c])

    def stop(self) -> None:
        """Take note that the body rests."""
        m = len(self._accel)
        seen = np.zeros((m, len(self._filter.x)))
        seen[:, self._c] = np.eye(m)
        self._update(seen)

    def stop_along(self, axes: Sequence[int], reading: Reading) -> None:
        """Take note that the velocity along some axes of the sensor is zero."""
        along = np.reshape(reading.rot_ws, (3, 3)).T[list(axes)]
        seen = np.zeros((len(along), len(self._filter.x)))
        seen[:, self._c] = along
        # A wrong attitude looks along wrong axes: true ones are along − θ × along.
        seen[:, self._theta] = -np.cross(along, self.velocity)
        self._update(seen)

    def covariances(self, stationary: bool) -> tuple[Matrix, Matrix]:
        """Return the covariances of position [m²] and velocity [m²/s²], shapes (3, 3), world."""
        p = self._filter.P
        position = p[self._p, self._p] + FLOOR * np.eye(3)
        spread = np.zeros((3, len(p)))
        spread[:, self._c] = self._ahead
        spread[:, self._theta] = self._swing
        velocity = spread @ p @ spread.T + FLOOR * np.eye(3)
        return _symmetric(position), _symmetric(velocity)

    def _arrive(self, reading: Reading) -> None:
        """Take over what the next step begins with."""
        rotation = np.reshape(reading.rot_ws, (3, 3))
        accel_s = np.array(reading.accel_s)
        if self._axis is None:
            x, y, z = reading.accel_w
            write_jacobian(self._jacobian, reading.rot_ws, (x, y, z + GRAVITY), self._mask)
            self._ahead: Array = np.eye(3)
            self._accel: Array = rotation @ accel_s
        else:
            write_jacobian_along(self._jacobian, reading.rot_ws, self._axis)
            self._ahead = rotation[:, self._axis : self._axis + 1]
            self._accel = accel_s[self._axis : self._axis + 1]

    def _turn(self, speed: Array) -> None:
        """Note how an attitude error swings a velocity that the body carries along."""
        if self._axis is not None:
            self._swing = cross_matrix(self._ahead @ speed)

    def _wander(
        self, dt: float, reading: Reading, acceleration: Array, held: bool = False
    ) -> None:
        """Fill in how an acceleration enters, its covariance, shape (m, m), and what drifts."""
        entry, process, f = self._entry, self._process, self._transition
        entry[self._c] = dt * np.eye(len(self._accel))
        entry[self._p] = 0.0 if held else 0.5 * dt * self._ahead @ entry[self._c]
        process[:] = entry @ acceleration @ entry.T
        size = len(process)
        process.flat[(size - 3) * (size + 1) :: size + 1] += self._settings.bias_walk**2 * dt
        variances = _variances(reading)
        if variances != self._variances:
            old, new = np.array(self._variances), np.array(variances)
            kept = np.minimum(1.0, new / np.maximum(old, FLOOR**2))
            f[self._given, self._given] = np.diag(kept)
            process[self._given, self._given] += np.diag(new - kept**2 * old)
            self._variances = variances
        else:
            f[self._given, self._given] = np.eye(4)

    def _noise(self, reading: Reading) -> Array:
        rotation = np.reshape(reading.rot_ws, (3, 3))
        noise = np.reshape(reading.noise, (3, 3))
        return self._along_what_moves(reading, rotation @ noise @ rotation.T)

    def _along_what_moves(self, reading: Reading, covariance_w: Array) -> Array:
        """Return what of a covariance of acceleration, shape (3, 3), is along the axes in use."""
        if self._axis is not None:
            speed: Array = self._ahead.T @ covariance_w @ self._ahead
            return speed
        if self._mask is None:
            return covariance_w
        rotation = np.reshape(reading.rot_ws, (3, 3))
        moves = rotation @ self._mask @ rotation.T
        along: Array = moves @ covariance_w @ moves
        return along

    def _update(self, seen: Array) -> None:
        """Take zero for what a matrix, shape (k, n), sees of the state.

        A velocity far beyond what the errors in the state explain comes from something else, such
        as a tilt or a shock on the way.  It is taken for an acceleration of its own that lasted
        since the last rest, lest the filter learn a bias from it.
        """
        kf, count = self._filter, len(seen)
        noise = (self._settings.stationary_deviation**2 + FLOOR) * np.eye(count)
        odd = -seen @ kf.x
        distance = odd @ np.linalg.solve(seen @ kf.P @ seen.T + noise, odd)
        if distance > GATE * count:
            push = np.zeros(len(kf.x))
            push[self._c] = odd @ seen[:, self._c]
            push[self._p] = 0.5 * self._moving * self._ahead @ push[self._c]
            kf.P = kf.P + (1.0 - GATE * count / distance) * np.outer(push, push)
        kf.dim_z = count  # filterpy 1 checks z against it
        kf.update(np.zeros(count), noise, seen)
        self._moving = 0.0


def _variances(reading: Reading) -> tuple[float, ...]:
    """Return how well a reading knows attitude [rad²], shape (3,), and gravity [m²/s⁴]."""
    return (*reading.attitude_covariance[::4], reading.gravity_variance)


def _symmetric(matrix: Array) -> Matrix:
    return tuple((0.5 * (matrix + matrix.T)).ravel().tolist())
