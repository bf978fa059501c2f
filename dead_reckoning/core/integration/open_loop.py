"""What the documents' integrations share: no feedback, covariance from the errors that last."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from math import sqrt

from dead_reckoning.core.bias_growth import BiasGrowth
from dead_reckoning.core.heading_growth import HeadingGrowth
from dead_reckoning.core.integration import Reading
from dead_reckoning.core.integration.settings import AXES, IntegratorSettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import rotate, rotate_back
from dead_reckoning.core.samples import IDENTITY, ZERO, Matrix, Vector


class OpenLoop(ABC):
    """Integrate what the window leaves; at rest the velocity is set to zero.

    With one axis the body carries its speed along: before each step velocity and acceleration
    turn with it.  Derived in docs/integrator.md.
    """

    def __init__(self, settings: IntegratorSettings) -> None:
        self.position: Vector = ZERO
        self.velocity: Vector = ZERO
        self._settings = settings
        self._acceleration: Vector = ZERO
        self._rot_ws: Matrix = IDENTITY
        self._carried = len(settings.axes) == 1
        self._growth: BiasGrowth | HeadingGrowth
        if self._carried:
            self._growth = HeadingGrowth(settings.offset_deviation, AXES.index(settings.axes[0]))
        else:
            self._growth = BiasGrowth(
                settings.offset_deviation, [axis in settings.axes for axis in AXES]
            )

    @abstractmethod
    def _integrate(self, dt: float, carried: Vector, before: Vector, accel_w: Vector) -> None:
        """Set position and velocity at the end of a step.

        ``carried`` and ``before`` are velocity and acceleration of the last sample, turned with
        the body where it carries them; `velocity` is still that of the last sample.
        """

    def start(self, reading: Reading) -> None:
        """Begin at the origin, at rest."""
        self.position = self.velocity = ZERO
        self._growth.reset()
        self._arrive(reading, rotate(reading.rot_ws, reading.kept_s))

    def step(self, dt: float, reading: Reading) -> None:
        """Integrate over ``dt`` [s], which ends with this reading."""
        x, y, z = reading.accel_w
        accel_w = rotate(reading.rot_ws, reading.kept_s)
        self._integrate(
            dt,
            self._turned(self.velocity, reading.rot_ws),
            self._turned(self._acceleration, reading.rot_ws),
            accel_w,
        )
        self._growth.step(
            dt,
            reading.rot_ws,
            (x, y, z + GRAVITY),
            reading.attitude_covariance,
            reading.noise,
            self.velocity,
            reading.gravity_variance,
        )
        self._arrive(reading, accel_w)

    def hold(self, dt: float, reading: Reading) -> None:
        """Pass ``dt`` [s] in which the body rests: nothing moves, and nothing grows uncertain."""
        self._arrive(reading, rotate(reading.rot_ws, reading.kept_s))

    def gap(self, dt: float, reading: Reading) -> None:
        """Hold position and velocity over ``dt`` [s], and know them less well."""
        self._growth.gap(
            dt, sqrt(sum(v * v for v in self.velocity)), self._settings.gap_acceleration
        )
        self.velocity = self._turned(self.velocity, reading.rot_ws)
        self._arrive(reading, rotate(reading.rot_ws, reading.kept_s))

    def stop(self) -> None:
        """Take note that the body rests."""
        self.velocity = ZERO
        self._growth.stop()

    def stop_along(self, axes: Sequence[int], reading: Reading) -> None:
        """Take note that the velocity along some axes of the sensor is zero."""
        rot_ws = reading.rot_ws
        velocity_s = list(rotate_back(rot_ws, self.velocity))
        for index in axes:
            velocity_s[index] = 0.0
            self._growth.stop_along((rot_ws[index], rot_ws[3 + index], rot_ws[6 + index]))
        self.velocity = rotate(rot_ws, (velocity_s[0], velocity_s[1], velocity_s[2]))

    def covariances(self, stationary: bool) -> tuple[Matrix, Matrix]:
        """Return the covariances of position [m²] and velocity [m²/s²], shapes (3, 3), world."""
        return self._growth.covariances(
            self._settings.stationary_deviation**2 if stationary else 0.0
        )

    def _arrive(self, reading: Reading, accel_w: Vector) -> None:
        self._acceleration = accel_w
        self._rot_ws = reading.rot_ws

    def _turned(self, vector_w: Vector, rot_ws: Matrix) -> Vector:
        if not self._carried or rot_ws == self._rot_ws:
            return vector_w
        return rotate(rot_ws, rotate_back(self._rot_ws, vector_w))
