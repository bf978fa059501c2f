"""Integrate linear acceleration twice, with the documents' window and movement-end check."""

from __future__ import annotations

from concurrent.futures import Future

from dead_reckoning.core.acceleration_error import gravity_variance
from dead_reckoning.core.checks import (
    require_acceleration,
    require_covariances,
    require_rate,
    require_vector,
)
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import (
    DeadReckoningError,
    MissingAttitudeError,
    NotAtRestError,
    SupersededError,
)
from dead_reckoning.core.heading_wander import HeadingWander
from dead_reckoning.core.integration import Reading, integration
from dead_reckoning.core.integration.settings import AXES, IntegratorSettings
from dead_reckoning.core.mounting import carried
from dead_reckoning.core.movement_end import MovementEnd
from dead_reckoning.core.rest import RestWindow
from dead_reckoning.core.rotation import (
    isotropic,
    matrix_from_quaternion,
    normalized,
    rotate,
    rotate_back,
)
from dead_reckoning.core.samples import (
    NANOSECONDS,
    UNKNOWN,
    ZERO,
    ImuSample,
    LinearAcceleration,
    Matrix,
    NavigationState,
    Vector,
)
from dead_reckoning.core.stamps import Timeline
from dead_reckoning.core.work import Work

LONGEST_GAP = 3600.0
"""A gap [s] after which no more uncertainty comes: figures that large drown all others."""


class Integrator:
    """Integrate linear acceleration to velocity and position, in the world.

    Here samples are checked, the calibrated offset is taken off, the discrimination window and the
    movement-end check of AN3397 and the mbed tutorial look along the axes of the sensor; an
    `Integration`, chosen by `integrator.method`, goes from acceleration to position.  Time steps
    come from the stamps.  docs/integrator.md derives it.

    The first sample only sets the start.  A stale stamp is refused.  One that goes back by more
    than 1 s starts all over.  Over a gap nothing is integrated and the covariance grows.  A
    clipped sample shows in the covariance its driver gives it.  While the movement-end check holds
    the body for resting, position stays as it is, and so does its covariance.
    """

    def __init__(self, settings: IntegratorSettings, common: CommonSettings):
        """Raise `DependencyError` where the method needs a package that is not installed."""
        self.settings = settings
        self.offset: Vector = ZERO
        """Residual offset along the axes of the sensor, shape (3,) [m/s²], as calibrated."""
        self.gaps = 0
        """Gaps longer than `max_gap` so far."""
        self._attitude_fallback = isotropic(common.attitude_deviation)
        self._noise_fallback = isotropic(common.noise_deviation)
        self._rate_fallback = isotropic(common.rate_deviation)
        self._turn_fallback = isotropic(common.turn_deviation)
        self._timeline = Timeline()
        self._integration = integration(settings)
        self._axes = [AXES.index(axis) for axis in settings.axes]
        self._wander: HeadingWander | None = None
        if len(self._axes) == 1:
            self._wander = HeadingWander(settings.heading_deviation, self._axes[0])
        self._movement_end = MovementEnd()
        self._stationary = False
        self._start_w: Vector = ZERO
        self._calibration = Work()
        self._window: RestWindow | None = None

    def reset(self) -> None:
        """Return to the origin at rest; the calibrated offset and the settings stay."""
        self._timeline.reset()
        self._give_up_calibration(SupersededError('a reset came meanwhile: ask again'))

    @property
    def restarts(self) -> int:
        """How often the stamps went back by more than 1 s."""
        return self._timeline.restarts

    def configure(self, settings: IntegratorSettings) -> None:
        """Take over changed settings, all at once, without touching the state."""
        self.settings = settings

    def calibrate(self) -> Future[str]:
        """Learn the residual offset from the coming samples, at rest.

        The future ends with a sentence for the user, or with `NotAtRestError`.
        """
        self._window = RestWindow(
            self.settings.calibration_duration, self.settings.calibration_deviation
        )
        return self._calibration.begin()

    @staticmethod
    def require(imu: ImuSample) -> None:
        """Raise `SampleError` where an Imu is of no use, whatever acceleration it comes with."""
        if imu.orientation is None:
            raise MissingAttitudeError(
                'the Imu with the stamp of this acceleration carries no orientation: take '
                'imu/data from gravity_removal, or from a driver that knows its attitude'
            )
        normalized(imu.orientation)
        if not imu.specific_force_covariance[0] < 0.0:  # else another device measured the force
            require_vector(imu.specific_force, 'specific force')
        require_covariances(imu)
        require_rate(imu)

    def update(
        self, acceleration: LinearAcceleration, imu: ImuSample, lever_arm: Vector = ZERO
    ) -> NavigationState:
        """Integrate one sample; ``imu`` gives the attitude at the same stamp.

        ``lever_arm``, shape (3,) [m], axes of ``imu``, leads from the body's origin to the sensor
        that is integrated; what comes out is the state of the body (`carried`).

        Raises `SampleError` (not finite, no attitude, stale stamp), and then nothing changed.
        """
        require_acceleration(acceleration)
        self.require(imu)
        assert imu.orientation is not None
        orientation = normalized(imu.orientation)
        restarts = self._timeline.restarts
        step_ns = self._timeline.advance(imu.stamp_ns)
        if self._timeline.restarts != restarts:
            self._give_up_calibration(NotAtRestError('the stamps went back meanwhile: ask again'))
        rotation = matrix_from_quaternion(orientation)
        reading = self._read(acceleration, rotation, imu)
        dt = min((step_ns or 0) / NANOSECONDS, LONGEST_GAP)
        gap = dt > self.settings.max_gap
        if step_ns is None or gap:
            self._movement_end.clear()
        self._movement_end.add(reading.accel_s, self.settings)
        if step_ns is None:
            self._integration.start(reading)
            self._start_w = rotate(rotation, lever_arm)
        elif gap:
            self.gaps += 1
            self._integration.gap(dt, reading)
        elif self._stationary and reading.kept_s == ZERO:
            self._integration.hold(dt, reading)
        else:
            self._integration.step(dt, reading)
        stationary = self._stationary = self._check_movement_end(reading)
        position, velocity = self._integration.position, self._integration.velocity
        position_covariance, velocity_covariance = self._integration.covariances(stationary)
        if self._wander is not None:
            if step_ns is None:
                self._wander.reset()
            self._wander.step(dt, reading.rot_ws, velocity)
            position_covariance, velocity_covariance = self._wander.added(
                position_covariance, velocity_covariance, velocity
            )
        scale_variance = self.settings.scale_deviation**2
        rate_covariance = imu.angular_velocity_covariance
        if rate_covariance == UNKNOWN:
            measured = imu.angular_velocity is not None
            rate_covariance = self._rate_fallback if measured else self._turn_fallback
        state = NavigationState(
            imu.stamp_ns,
            position,
            velocity,
            orientation,
            _scaled(position_covariance, position, scale_variance),
            _scaled(velocity_covariance, velocity, scale_variance),
            reading.attitude_covariance,
            imu.angular_velocity,
            UNKNOWN if imu.angular_velocity is None else rate_covariance,
            stationary,
        )
        if lever_arm == ZERO:
            return state
        return carried(state, rotation, lever_arm, self._start_w, rate_covariance)

    def _read(self, acceleration: LinearAcceleration, rot_ws: Matrix, imu: ImuSample) -> Reading:
        accel_w = acceleration.acceleration
        measured_s = rotate_back(rot_ws, accel_w)
        if self._window is not None:
            self._calibrate_with(self._window, imu.stamp_ns, measured_s)
        low, high = self.settings.window_minimum, self.settings.window_maximum
        accel_s, kept_s = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
        for index in self._axes:
            value = accel_s[index] = measured_s[index] - self.offset[index]
            if not low <= value <= high:
                kept_s[index] = value
        attitude_covariance = imu.orientation_covariance
        if attitude_covariance == UNKNOWN:
            attitude_covariance = self._attitude_fallback
        noise = imu.specific_force_covariance
        elsewhere = noise[0] < 0.0  # another device measured it
        if noise == UNKNOWN or elsewhere:
            noise = self._noise_fallback
        gravity = 0.0
        if not elsewhere:
            gravity = gravity_variance(acceleration, rot_ws, attitude_covariance, noise)
        return Reading(
            rot_ws,
            accel_w,
            (accel_s[0], accel_s[1], accel_s[2]),
            (kept_s[0], kept_s[1], kept_s[2]),
            attitude_covariance,
            gravity,
            noise,
        )

    def _ended(self) -> list[int]:
        """List the axes of the sensor along which the movement has ended."""
        if self.settings.movement_end == 'off':
            return []
        return [axis for axis in self._axes if self._movement_end.ended(axis, self.settings)]

    def _check_movement_end(self, reading: Reading) -> bool:
        """Say whether the body rests; what is inside the window then has no velocity.

        A sample outside may be the tremor of a rest or begin a movement: it is integrated, and
        counts only if one inside follows before the movement shows.
        """
        ended = self._ended()
        inside = [axis for axis in ended if reading.kept_s[axis] == 0.0]
        if len(ended) == len(self._axes):
            if len(inside) == len(ended):
                self._integration.stop()
                return True
            return self._stationary
        if inside and self.settings.movement_end == 'each':
            self._integration.stop_along(inside, reading)
        return False

    def _give_up_calibration(self, error: DeadReckoningError) -> None:
        self._window = None
        self._calibration.fail(error)

    def _calibrate_with(self, window: RestWindow, stamp_ns: int, measured_s: Vector) -> None:
        try:
            rest = window.add(stamp_ns, measured_s)
        except NotAtRestError as error:
            self._give_up_calibration(error)
            return
        if rest is not None:
            self._window = None
            self.offset = rest.mean
            said = ', '.join(f'{value:.4f}' for value in rest.mean)
            self._calibration.succeed(f'offset along x, y, z: {said} m/s²')


def _scaled(covariance: Matrix, vector: Vector, variance: float) -> Matrix:
    """Add to a covariance, shape (3, 3), that the whole vector may be too long or too short."""
    x, y, z = vector
    xx, xy, xz, _, yy, yz, _, _, zz = covariance
    xy, xz, yz = xy + variance * x * y, xz + variance * x * z, yz + variance * y * z
    xx, yy, zz = xx + variance * x * x, yy + variance * y * y, zz + variance * z * z
    return (xx, xy, xz, xy, yy, yz, xz, yz, zz)
