"""Integrate linear acceleration twice, with the documents' window and movement-end check."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass
from math import isfinite, sqrt

from dead_reckoning.core.bias_growth import BiasGrowth
from dead_reckoning.core.checks import require_finite_covariances
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import (
    DeadReckoningError,
    MissingAttitudeError,
    NotAtRestError,
    NotFiniteError,
    SettingsError,
    SupersededError,
)
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.rest import GRAVITY, RestWindow
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

AXES = ('x', 'y', 'z')


@dataclass(frozen=True, kw_only=True)
class IntegratorSettings(Settings, prefix='integrator'):
    """How `Integrator` integrates, and when it holds the body for resting."""

    method: str = parameter(
        'trapezoid',
        'trapezoid (AN3397 and mbed, first order between samples) or euler (CH Robotics '
        'section 3, the value before each step)',
        choices=('trapezoid', 'euler'),
    )
    axes: tuple[str, ...] = parameter(
        AXES, 'Axes of the sensor along which it moves; the others are held at zero', choices=AXES
    )
    window_minimum: float = parameter(
        -0.05,
        'Discrimination window: an acceleration along an axis of the sensor from window_minimum '
        'to window_maximum counts as none',
        unit='m/s²',
        maximum=0.0,
        mutable=True,
    )
    window_maximum: float = parameter(
        0.05, 'Upper end of the discrimination window', unit='m/s²', minimum=0.0, mutable=True
    )
    movement_end: str = parameter(
        'all',
        'Movement-end check, which returns the velocity to zero: all (once all axes are quiet '
        'together), each (axis by axis, as the documents do) or off',
        choices=('all', 'each', 'off'),
        mutable=True,
    )
    movement_end_samples: int = parameter(
        25,
        'Consecutive samples inside the window that end a movement',
        minimum=1,
        maximum=1_000_000,
        mutable=True,
    )
    max_gap: float = parameter(
        0.5,
        'Longest time between samples that is integrated; over a longer one position and velocity '
        'are held and uncertainty grows',
        unit='s',
        minimum=0.001,
        maximum=60.0,
    )
    gap_acceleration: float = parameter(
        1.0, 'One sigma of the acceleration that a gap may hide', unit='m/s²', minimum=0.0
    )
    offset_deviation: float = parameter(
        0.01,
        'One sigma of the constant offset that calibration leaves on an axis',
        unit='m/s²',
        minimum=0.0,
    )
    stationary_deviation: float = parameter(
        0.01,
        'One sigma of the velocity that the movement-end check may overlook',
        unit='m/s',
        minimum=0.0,
    )
    calibration_duration: float = parameter(
        1.0, 'How long ~/calibrate averages', unit='s', minimum=0.05, maximum=600.0
    )
    calibration_deviation: float = parameter(
        0.3,
        'Largest standard deviation of an axis at which ~/calibrate still believes in rest',
        unit='m/s²',
        minimum=1e-6,
        maximum=5.0,
    )

    def validate(self) -> None:
        """Raise `SettingsError` where the window holds nothing but zero and the check needs it."""
        if self.movement_end != 'off' and self.window_minimum == self.window_maximum:
            raise SettingsError(
                'integrator.window_maximum: 0.0 leaves the movement-end check nothing that counts '
                'as quiet; widen the window or set integrator.movement_end to off'
            )


class Integrator:
    """Integrate linear acceleration to velocity and position, in the world.

    AN3397 and the mbed tutorial: discrimination window, trapezoid twice, movement-end check; CH
    Robotics section 3 for `euler`.  The window looks along the axes of the sensor, the integration
    runs in the world; time steps come from the stamps.  docs/integrator.md derives it.

    The first sample only sets the start.  A stale stamp is refused.  One that goes back by more
    than 1 s starts all over.  Over a gap nothing is integrated and the covariance grows.  A
    clipped sample shows in the covariance its driver gives it.  While the movement-end check holds
    the body for resting, position stays as it is, and so does its covariance.
    """

    def __init__(self, settings: IntegratorSettings, common: CommonSettings):
        self.settings = settings
        self.offset: Vector = ZERO
        """Residual offset along the axes of the sensor, shape (3,) [m/s²], as calibrated."""
        self.gaps = 0
        """Gaps longer than `max_gap` so far."""
        self._attitude_fallback = isotropic(common.attitude_deviation)
        self._noise_fallback = isotropic(common.noise_deviation)
        self._timeline = Timeline()
        self._growth = BiasGrowth(
            settings.offset_deviation, [axis in settings.axes for axis in AXES]
        )
        self._calibration = Work()
        self._window: RestWindow | None = None
        self.reset()

    def reset(self) -> None:
        """Return to the origin at rest; the calibrated offset and the settings stay."""
        self._timeline.reset()
        self._start_over()
        self._give_up_calibration(SupersededError('a reset came meanwhile: ask again'))

    def _start_over(self) -> None:
        self._position: Vector = ZERO
        self._velocity: Vector = ZERO
        self._acceleration: Vector = ZERO
        self._quiet = [0, 0, 0]
        self._stationary = False
        self._growth.reset()

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

    def update(self, acceleration: LinearAcceleration, imu: ImuSample) -> NavigationState:
        """Integrate one sample; ``imu`` gives the attitude at the same stamp.

        Raises `SampleError` (not finite, no attitude, stale stamp), and then nothing changed.
        """
        accel_w = acceleration.acceleration
        if not isfinite(accel_w[0] + accel_w[1] + accel_w[2]):
            raise NotFiniteError(f'the linear acceleration is {accel_w}: check its source')
        if imu.orientation is None:
            raise MissingAttitudeError(
                'the Imu with the stamp of this acceleration carries no orientation: take '
                'imu/data from gravity_removal, or from a driver that knows its attitude'
            )
        require_finite_covariances(imu)
        orientation = normalized(imu.orientation)
        restarts = self._timeline.restarts
        step_ns = self._timeline.advance(imu.stamp_ns)
        if self._timeline.restarts != restarts:
            self._start_over()
            self._give_up_calibration(NotAtRestError('the stamps went back meanwhile: ask again'))
        rot_ws = matrix_from_quaternion(orientation)
        accel_s = rotate_back(rot_ws, accel_w)
        if self._window is not None:
            self._calibrate_with(self._window, imu.stamp_ns, accel_s)
        kept_w = rotate(rot_ws, self._discriminate(accel_s))
        attitude_covariance = imu.orientation_covariance
        if attitude_covariance == UNKNOWN:
            attitude_covariance = self._attitude_fallback
        if step_ns is not None:
            dt = step_ns / NANOSECONDS
            if dt > self.settings.max_gap:
                self._pass_gap(dt)
            elif not (self._stationary and self._is_held()):
                noise = imu.specific_force_covariance
                if noise == UNKNOWN or noise[0] < 0.0:  # unknown, or another device measured it
                    noise = self._noise_fallback
                self._growth.step(
                    dt,
                    rot_ws,
                    (accel_w[0], accel_w[1], accel_w[2] + GRAVITY),
                    attitude_covariance,
                    noise,
                )
                self._integrate(dt, kept_w)
        self._acceleration = kept_w
        stationary = self._stationary = self._check_movement_end(rot_ws)
        position_covariance, velocity_covariance = self._growth.covariances(
            self.settings.stationary_deviation**2 if stationary else 0.0
        )
        return NavigationState(
            imu.stamp_ns,
            self._position,
            self._velocity,
            orientation,
            position_covariance,
            velocity_covariance,
            attitude_covariance,
            imu.angular_velocity,
            imu.angular_velocity_covariance,
            stationary,
        )

    def _discriminate(self, accel_s: Vector) -> Vector:
        settings = self.settings
        kept = [0.0, 0.0, 0.0]
        for index, axis in enumerate(AXES):
            value = accel_s[index] - self.offset[index]
            if axis not in settings.axes:
                continue
            if settings.window_minimum <= value <= settings.window_maximum:
                self._quiet[index] += 1
            else:
                self._quiet[index] = 0
                kept[index] = value
        return (kept[0], kept[1], kept[2])

    def _integrate(self, dt: float, accel_w: Vector) -> None:
        a, v, p = self._acceleration, self._velocity, self._position
        if self.settings.method == 'trapezoid':
            half = 0.5 * dt
            velocity = (
                v[0] + half * (a[0] + accel_w[0]),
                v[1] + half * (a[1] + accel_w[1]),
                v[2] + half * (a[2] + accel_w[2]),
            )
            self._position = (
                p[0] + half * (v[0] + velocity[0]),
                p[1] + half * (v[1] + velocity[1]),
                p[2] + half * (v[2] + velocity[2]),
            )
        else:
            velocity = (v[0] + dt * a[0], v[1] + dt * a[1], v[2] + dt * a[2])
            self._position = (p[0] + dt * v[0], p[1] + dt * v[1], p[2] + dt * v[2])
        self._velocity = velocity

    def _pass_gap(self, dt: float) -> None:
        self.gaps += 1
        self._quiet = [min(quiet, 1) for quiet in self._quiet]
        speed = sqrt(sum(v * v for v in self._velocity))
        self._growth.gap(dt, speed, self.settings.gap_acceleration)

    def _still(self) -> list[bool]:
        settings = self.settings
        needed = settings.movement_end_samples
        return [self._quiet[AXES.index(axis)] >= needed for axis in settings.axes]

    def _is_held(self) -> bool:
        return self.settings.movement_end != 'off' and all(self._still())

    def _check_movement_end(self, rot_ws: Matrix) -> bool:
        settings = self.settings
        still = self._still()
        if settings.movement_end == 'off' or not any(still):
            return False
        if all(still):
            self._velocity = ZERO
            self._growth.stop()
            return True
        if settings.movement_end == 'each':
            velocity_s = list(rotate_back(rot_ws, self._velocity))
            for axis, ended in zip(settings.axes, still, strict=True):
                if ended:
                    index = AXES.index(axis)
                    velocity_s[index] = 0.0
                    self._growth.stop_along((rot_ws[index], rot_ws[3 + index], rot_ws[6 + index]))
            self._velocity = rotate(rot_ws, (velocity_s[0], velocity_s[1], velocity_s[2]))
        return False

    def _give_up_calibration(self, error: DeadReckoningError) -> None:
        self._window = None
        self._calibration.fail(error)

    def _calibrate_with(self, window: RestWindow, stamp_ns: int, accel_s: Vector) -> None:
        try:
            rest = window.add(stamp_ns, accel_s)
        except NotAtRestError as error:
            self._give_up_calibration(error)
            return
        if rest is not None:
            self._window = None
            self.offset = rest.mean
            said = ', '.join(f'{value:.4f}' for value in rest.mean)
            self._calibration.succeed(f'offset along x, y, z: {said} m/s²')
