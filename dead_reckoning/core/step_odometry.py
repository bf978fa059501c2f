"""Walk the steps of a pedometer along a heading."""

from __future__ import annotations

from math import atan2, cos, sin

from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import MissingAttitudeError
from dead_reckoning.core.headings import Heading, HeadingHistory
from dead_reckoning.core.pedometer import PedometerSettings, PedometerState
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.samples import (
    NANOSECONDS,
    UNMEASURED_VARIANCE,
    ImuSample,
    Matrix,
    NavigationState,
)

HEADING_WITHIN_NS = NANOSECONDS
"""A heading this far in time from the middle of a step is none of it."""


class StepOdometry:
    """Add up steps × length along the heading in the middle of each step.

    ``p ← p + d (cos ψ, sin ψ)``, from the origin.  The errors of k (relative, ε) and of the
    heading (δ) stay the same from step to step, so they grow with the distance; with p⊥ the
    position turned by 90°, ``Σ_p = σ_ε² p pᵀ + σ_δ² p⊥ p⊥ᵀ``, σ_δ taken step by step, plus what
    differs from step to step.  Height, roll and pitch are not known: their variances say so.

    A step whose heading is unknown is not walked; its length goes into the uncertainty, in every
    direction.  A restart of the stamps changes nothing but the headings.
    """

    def __init__(self, settings: PedometerSettings, common: CommonSettings) -> None:
        self.settings = settings
        self._compass = HeadingHistory(common.attitude_deviation)
        self._orientation = HeadingHistory(common.attitude_deviation)
        self.reset()

    def reset(self) -> None:
        """Return to the origin, known exactly."""
        self._x = self._y = 0.0
        self._turned_x = self._turned_y = 0.0
        self._own = 0.0
        self._lost = 0.0

    def configure(self, settings: PedometerSettings) -> None:
        """Take over changed settings without touching the position."""
        self.settings = settings

    def take_compass(self, imu: ImuSample) -> None:
        """Take a sample of the compass; raises `MissingAttitudeError` or `NotFiniteError`."""
        if self.settings.heading in ('compass', 'any'):
            if imu.orientation is None:
                raise MissingAttitudeError(
                    'compass/data carries no orientation: its yaw is all that is taken from it'
                )
            self._compass.add(imu)

    def take_orientation(self, imu: ImuSample) -> None:
        """Take a sample of the counted topic; raises `NotFiniteError`.

        Where it is all that gives a heading, raises `MissingAttitudeError` if it has none.
        """
        if self.settings.heading == 'orientation' and imu.orientation is None:
            raise MissingAttitudeError(
                'the Imu carries no orientation, and pedometer.heading is orientation: take a '
                'topic that has one (pedometer.input: imu/data), or set pedometer.heading to '
                'compass, or to none'
            )
        if self.settings.heading in ('orientation', 'any'):
            self._orientation.add(imu)

    def update(self, state: PedometerState) -> NavigationState | None:
        """Walk a step; return where that leads, or None without a heading or a step."""
        if state.duration == 0.0:
            return None
        length = state.step_length
        middle_ns = state.stamp_ns - round(0.5 * state.duration * NANOSECONDS)
        heading = self._heading(middle_ns)
        if heading is None:
            self._lost += length
            return None
        settings = self.settings
        c, s = cos(settings.heading_offset), sin(settings.heading_offset)
        east, north = c * heading.x - s * heading.y, s * heading.x + c * heading.y
        variance = heading.variance + settings.heading_deviation**2
        deviation = variance**0.5
        self._x += length * east
        self._y += length * north
        self._turned_x -= deviation * length * north
        self._turned_y += deviation * length * east
        self._own += (settings.step_deviation * length) ** 2
        return self._state(state, (east, north), variance)

    def _heading(self, stamp_ns: int) -> Heading | None:
        return self._compass.at(stamp_ns, HEADING_WITHIN_NS) or self._orientation.at(
            stamp_ns, HEADING_WITHIN_NS
        )

    def _state(
        self, state: PedometerState, direction: tuple[float, float], variance: float
    ) -> NavigationState:
        settings = self.settings
        k = settings.length_deviation**2
        x, y, tx, ty = self._x, self._y, self._turned_x, self._turned_y
        own = self._own + self._lost**2
        speed = state.step_length / state.duration
        east, north = direction
        vx, vy = speed * east, speed * north
        each = (settings.step_deviation * speed) ** 2
        return NavigationState(
            state.stamp_ns,
            (x, y, 0.0),
            (vx, vy, 0.0),
            quaternion_from_euler(0.0, 0.0, atan2(north, east)),
            _level(k * x * x + tx * tx + own, k * x * y + tx * ty, k * y * y + ty * ty + own),
            _level(
                k * vx * vx + variance * vy * vy + each,
                (k - variance) * vx * vy,
                k * vy * vy + variance * vx * vx + each,
            ),
            (UNMEASURED_VARIANCE, 0.0, 0.0, 0.0, UNMEASURED_VARIANCE, 0.0, 0.0, 0.0, variance),
        )


def _level(xx: float, xy: float, yy: float) -> Matrix:
    """Return the covariance, shape (3, 3), of what is known in the plane and not in height."""
    return (xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, UNMEASURED_VARIANCE)
