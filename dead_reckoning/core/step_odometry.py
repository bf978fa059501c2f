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

SECOND_ORDER = 0.75**0.5
"""A heading that is wrong by δ makes a step shorter along it by δ²/2, whose square is ¾ σ⁴."""


class StepOdometry:
    """Add up steps × length along the heading in the middle of each step.

    ``p ← p + d (cos ψ, sin ψ)``, from the origin.  The errors of k (relative, ε) and of the
    direction of walking stay the same from step to step, so they grow with the distance; that of
    the heading drifts, as `_HeadingError` says.  Added is what differs from step to step.  Height,
    roll and pitch are not known: their variances say so.  docs/pedometer.md has the equations.

    A step whose heading is unknown is not walked; its length goes into the uncertainty, in every
    direction.  A restart of the stamps changes nothing but the headings.
    """

    def __init__(self, settings: PedometerSettings, common: CommonSettings) -> None:
        self.settings = settings
        self._compass = HeadingHistory(common.attitude_deviation)
        self._orientation = HeadingHistory(common.attitude_deviation)
        self._navigator = HeadingHistory(common.attitude_deviation)
        self.reset()

    def reset(self) -> None:
        """Return to the origin, known exactly."""
        self._x = self._y = 0.0
        self._turned_x = self._turned_y = 0.0
        self._bent_x = self._bent_y = 0.0
        self._errors = [_HeadingError() for _ in self._sources]
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

    def take_navigator(self, state: NavigationState) -> None:
        """Take a state of the inertial navigator; raises `NotFiniteError`."""
        self._navigator.take(state.stamp_ns, state.attitude, state.attitude_covariance)

    def update(self, state: PedometerState) -> NavigationState | None:
        """Walk a step; return where that leads, or None without a heading or a step."""
        if state.duration == 0.0:
            return None
        length = state.step_length
        middle_ns = state.stamp_ns - round(0.5 * state.duration * NANOSECONDS)
        found = self._heading(middle_ns)
        if found is None:
            self._lost += length
            return None
        heading, error = found
        settings = self.settings
        c, s = cos(settings.heading_offset), sin(settings.heading_offset)
        east, north = c * heading.x - s * heading.y, s * heading.x + c * heading.y
        error.step(heading.variance, -length * north, length * east)
        self._x += length * east
        self._y += length * north
        self._turned_x -= settings.heading_deviation * length * north
        self._turned_y += settings.heading_deviation * length * east
        self._own += (settings.step_deviation * length) ** 2
        variance = heading.variance + settings.heading_deviation**2
        self._bent_x += SECOND_ORDER * variance * length * east
        self._bent_y += SECOND_ORDER * variance * length * north
        return self._state(state, (east, north), variance)

    @property
    def _sources(self) -> tuple[HeadingHistory, ...]:
        return (self._compass, self._orientation, self._navigator)

    def _heading(self, stamp_ns: int) -> tuple[Heading, _HeadingError] | None:
        for source, error in zip(self._sources, self._errors, strict=True):
            heading = source.at(stamp_ns, HEADING_WITHIN_NS)
            if heading is not None:
                return heading, error
        return None

    def _state(
        self, state: PedometerState, direction: tuple[float, float], variance: float
    ) -> NavigationState:
        settings = self.settings
        k = settings.length_deviation**2
        x, y, tx, ty = self._x, self._y, self._turned_x, self._turned_y
        bx, by = self._bent_x, self._bent_y
        own = self._own + self._lost**2
        xx, xy, yy = map(sum, zip(*(error.spread for error in self._errors), strict=True))
        speed = state.step_length / state.duration
        east, north = direction
        vx, vy = speed * east, speed * north
        each = (settings.step_deviation * speed) ** 2
        return NavigationState(
            state.stamp_ns,
            (x, y, 0.0),
            (vx, vy, 0.0),
            quaternion_from_euler(0.0, 0.0, atan2(north, east)),
            _level(
                k * x * x + tx * tx + bx * bx + xx + own,
                k * x * y + tx * ty + bx * by + xy,
                k * y * y + ty * ty + by * by + yy + own,
            ),
            _level(
                k * vx * vx + variance * vy * vy + each,
                (k - variance) * vx * vy,
                k * vy * vy + variance * vx * vx + each,
            ),
            (UNMEASURED_VARIANCE, 0.0, 0.0, 0.0, UNMEASURED_VARIANCE, 0.0, 0.0, 0.0, variance),
        )


class _HeadingError:
    """Carry the error of a heading into the position, by the variances that its source gives.

    Where the variance grows, what is new of the error has nothing to do with the old.  Where it
    falls, something was measured: of the best estimate before and after, errors have the lesser
    variance for their covariance, so that of position and heading shrinks by the same part.  A
    variance that stays is one error all along, as that of a mounting.
    """

    def __init__(self) -> None:
        self.spread = (0.0, 0.0, 0.0)
        """Covariance of the position by this error: xx, xy, yy [m²]."""
        self._x = self._y = 0.0  # covariance of position and heading [m rad]
        self._variance = 0.0

    def step(self, variance: float, dx: float, dy: float) -> None:
        """Take a step that a heading turned by 1 rad moves by ``dx``, ``dy`` [m]."""
        if variance < self._variance:
            self._x *= variance / self._variance
            self._y *= variance / self._variance
        self._variance = variance
        x, y = self._x, self._y
        xx, xy, yy = self.spread
        self.spread = (
            xx + 2.0 * x * dx + variance * dx * dx,
            xy + x * dy + y * dx + variance * dx * dy,
            yy + 2.0 * y * dy + variance * dy * dy,
        )
        self._x, self._y = x + variance * dx, y + variance * dy


def _level(xx: float, xy: float, yy: float) -> Matrix:
    """Return the covariance, shape (3, 3), of what is known in the plane and not in height."""
    return (xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, UNMEASURED_VARIANCE)
