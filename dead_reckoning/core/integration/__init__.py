"""Ways from acceleration to position, a file each, behind one interface.

`Integrator` looks at the samples and decides what counts as motion; an `Integration` carries
position, velocity and their covariances.  With one axis only (`integrator.axes`) the velocity is
a speed that the body carries along as it turns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from dead_reckoning.core.samples import Matrix, Vector

if TYPE_CHECKING:
    from dead_reckoning.core.integration.settings import IntegratorSettings


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """One sample, as an `Integration` takes it.

    ``rot_ws``                takes the sensor into the world, shape (3, 3).
    ``accel_w``               linear acceleration as it came, shape (3,) [m/s²], world.
    ``accel_s``               the same along the axes of the sensor without the calibrated offset;
                              zero along those that do not move.
    ``kept_s``                what the discrimination window leaves of it.
    ``attitude_covariance``   shape (3, 3) [rad²], world.
    ``gravity_variance``      of the magnitude of gravity that was taken off [m²/s⁴].
    ``noise``                 covariance of the specific force of one sample, shape (3, 3)
                              [m²/s⁴], frame of the sensor.
    """

    rot_ws: Matrix
    accel_w: Vector
    accel_s: Vector
    kept_s: Vector
    attitude_covariance: Matrix
    gravity_variance: float
    noise: Matrix


class Integration(Protocol):
    """Carry position and velocity, and how well they are known, from sample to sample.

    It begins at the origin at rest with the first sample, given to `start`; every other one goes
    to `step`, to `hold` while the body rests, or to `gap` where too much time has passed.
    """

    @property
    def position(self) -> Vector:
        """Shape (3,) [m], world."""

    @property
    def velocity(self) -> Vector:
        """Shape (3,) [m/s], world."""

    def start(self, reading: Reading) -> None:
        """Begin at the origin, at rest."""

    def step(self, dt: float, reading: Reading) -> None:
        """Integrate over ``dt`` [s], which ends with this reading."""

    def hold(self, dt: float, reading: Reading) -> None:
        """Pass ``dt`` [s] in which the body rests: nothing moves, and nothing grows uncertain."""

    def gap(self, dt: float, reading: Reading) -> None:
        """Hold position and velocity over ``dt`` [s], and know them less well."""

    def stop(self) -> None:
        """Take note that the body rests."""

    def stop_along(self, axes: Sequence[int], reading: Reading) -> None:
        """Take note that the velocity along some axes of the sensor is zero."""

    def covariances(self, stationary: bool) -> tuple[Matrix, Matrix]:
        """Return the covariances of position [m²] and velocity [m²/s²], shapes (3, 3), world."""


def integration(settings: IntegratorSettings) -> Integration:
    """Return the method that the settings name.

    Raises `DependencyError` for `kalman` without filterpy, whose import takes most of a second and
    so is left to those who ask for it.
    """
    if settings.method == 'kalman':
        from dead_reckoning.core.integration.kalman import Kalman

        return Kalman(settings)
    if settings.method == 'euler':
        from dead_reckoning.core.integration.euler import Euler

        return Euler(settings)
    from dead_reckoning.core.integration.trapezoid import Trapezoid

    return Trapezoid(settings)
