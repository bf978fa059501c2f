"""Remove gravity from the specific force: CH Robotics, "Using Accelerometers", section 2."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass
from math import degrees, isfinite

from dead_reckoning.core.checks import require_finite_covariances
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import (
    DeadReckoningError,
    MissingAccelerationError,
    MissingAttitudeError,
    MountingError,
    NotAtRestError,
    NotFiniteError,
    NotLevelledError,
    SupersededError,
)
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.rest import GRAVITY, Rest, RestWindow, check_gravity, check_up_axis
from dead_reckoning.core.rotation import (
    cross_covariance,
    euler_from_gravity,
    isotropic,
    matrix_from_quaternion,
    normalized,
    quaternion_from_euler,
    rotate,
    rotate_covariance,
)
from dead_reckoning.core.samples import (
    IDENTITY,
    IDENTITY_QUATERNION,
    UNKNOWN,
    ImuSample,
    LinearAcceleration,
    Matrix,
    Quaternion,
)
from dead_reckoning.core.stamps import Timeline
from dead_reckoning.core.work import Work


@dataclass(frozen=True, kw_only=True)
class GravitySettings(Settings, prefix='gravity'):
    """How `GravityRemoval` learns the attitude and the magnitude of gravity."""

    attitude: str = parameter(
        'rest',
        'Source of the attitude: message (the orientation of imu/data) or rest (roll and pitch '
        'from the gravity vector at rest, held; yaw 0)',
        choices=('message', 'rest'),
    )
    magnitude: float = parameter(
        GRAVITY, 'Gravity, until it is measured at rest', unit='m/s²', minimum=9.7, maximum=9.9
    )
    measure: bool = parameter(
        True,
        'Take the magnitude of gravity from the first rest: a sensor may well rest at 1.008 g. '
        'With attitude: rest it is always measured',
    )
    rest_duration: float = parameter(
        0.5, 'How long the device must rest to be levelled', unit='s', minimum=0.05, maximum=60.0
    )
    rest_deviation: float = parameter(
        0.3,
        'Largest standard deviation of an axis that still counts as rest',
        unit='m/s²',
        minimum=1e-6,
        maximum=5.0,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Levelled:
    """What `GravityRemoval` makes of a sample.

    ``imu`` is the sample with the attitude that was used, ``acceleration`` the linear acceleration
    in the world.
    """

    imu: ImuSample
    acceleration: LinearAcceleration


class GravityRemoval:
    """Rotate the specific force into the world and take gravity off it.

    ``a_w = rot_ws · f_s − (0, 0, g)``, with covariance
    ``Σ_a = rot_ws Σ_f rot_wsᵀ + [rot_ws f]× Σ_θ [rot_ws f]×ᵀ`` (docs/gravity.md).

    Attitude `message` takes the orientation of each sample; `rest` holds the roll and pitch that
    gravity showed at the first rest, and no sample passes before.  The first sample starts the
    search for rest.  A stale stamp is refused; one that goes back by more than 1 s starts all
    over.  A gap changes nothing, as no state depends on the time between samples.
    """

    def __init__(self, settings: GravitySettings, common: CommonSettings, frames: FrameSettings):
        self.settings = settings
        self.findings: list[DeadReckoningError] = []
        """What the last rest showed to be wrong, for whoever reports it and clears it."""
        self.levelled = ''
        """What the last levelling found, in words."""
        self._world_frame = frames.world
        self._noise = isotropic(common.noise_deviation)
        self._tilt = isotropic(common.attitude_deviation)
        self._timeline = Timeline()
        self._levelling = Work()
        self._start_over()

    def reset(self) -> None:
        """Forget attitude and gravity and look for rest anew, as at the first sample."""
        self._timeline.reset()
        self._start_over()
        self._levelling.fail(SupersededError('a reset came meanwhile: ask again'))

    def _start_over(self) -> None:
        self.gravity = self.settings.magnitude
        """Gravity [m/s²], as set or as measured at rest."""
        self._searching = self.settings.attitude == 'rest' or self.settings.measure
        self._begin_rest(self._searching)
        self._quaternion: Quaternion | None = None
        self._rot_ws: Matrix = IDENTITY

    @property
    def restarts(self) -> int:
        """How often the stamps went back by more than 1 s."""
        return self._timeline.restarts

    def level(self) -> Future[str]:
        """Take attitude (with `rest`) and the magnitude of gravity from the coming samples.

        The future ends with a sentence for the user, or with `NotAtRestError` or `GravityError`;
        what was known before stays in force until then.
        """
        self._begin_rest(True)
        return self._levelling.begin()

    def update(self, imu: ImuSample) -> Levelled:
        """Remove gravity from one sample.

        Raises `SampleError` (not finite, no acceleration, no attitude, stale stamp, not levelled
        yet), and then the attitude is what it was.
        """
        force_s = imu.specific_force
        if not isfinite(force_s[0] + force_s[1] + force_s[2]):
            raise NotFiniteError(f'the specific force is {force_s}: check the driver')
        require_finite_covariances(imu)
        if imu.specific_force_covariance[0] < 0.0:
            raise MissingAccelerationError(
                'linear_acceleration_covariance[0] is -1, so this Imu measures no acceleration: '
                'subscribe to the topic of an accelerometer'
            )
        from_message = self.settings.attitude == 'message'
        attitude = self._attitude_of(imu) if from_message else self._quaternion
        restarts = self._timeline.restarts
        self._timeline.advance(imu.stamp_ns)
        if self._timeline.restarts != restarts:
            self._start_over()
            self._levelling.fail(NotAtRestError('the stamps went back meanwhile: ask again'))
            attitude = attitude if from_message else None
        if self._window is not None:
            self._look_for_rest(self._window, imu, attitude)
            if not from_message:
                attitude = self._quaternion
        if attitude is None:
            raise NotLevelledError(
                'waiting for rest: the attitude is taken from gravity, so keep the device still '
                f'for {self.settings.rest_duration:g} s'
            )
        tilt = imu.orientation_covariance if from_message else UNKNOWN
        if tilt == UNKNOWN:
            tilt = self._tilt
        rot_ws = matrix_from_quaternion(attitude) if from_message else self._rot_ws
        noise = imu.specific_force_covariance
        if noise == UNKNOWN:
            noise = self._noise
        force_w = rotate(rot_ws, force_s)
        tilted = cross_covariance(force_w, tilt)
        noisy = rotate_covariance(rot_ws, noise)
        acceleration = LinearAcceleration(
            imu.stamp_ns,
            self._world_frame,
            (force_w[0], force_w[1], force_w[2] - self.gravity),
            tuple([t + n for t, n in zip(tilted, noisy)]),  # type: ignore[arg-type]  # noqa: B905
        )
        if not from_message:
            imu = ImuSample(
                imu.stamp_ns,
                imu.frame_id,
                force_s,
                noise,
                imu.angular_velocity,
                imu.angular_velocity_covariance,
                attitude,
                tilt,
            )
        return Levelled(imu, acceleration)

    def _attitude_of(self, imu: ImuSample) -> Quaternion:
        quaternion = imu.orientation
        if quaternion is None:
            raise MissingAttitudeError(
                'the Imu carries no orientation, and gravity.attitude is message: take a topic '
                'that has one, or set gravity.attitude to rest'
            )
        return normalized(quaternion)

    def _begin_rest(self, wanted: bool) -> None:
        settings = self.settings
        self._window = (
            RestWindow(settings.rest_duration, settings.rest_deviation) if wanted else None
        )

    def _look_for_rest(
        self, window: RestWindow, imu: ImuSample, attitude: Quaternion | None
    ) -> None:
        try:
            rest = window.add(imu.stamp_ns, imu.specific_force)
            if rest is None:
                return
            said = self._level_at(rest, attitude)
        except DeadReckoningError as error:
            # The window is empty again; until the first rest is found the search goes on.
            if not self._searching:
                self._window = None
            if not self._levelling.running and not isinstance(error, NotAtRestError):
                self.findings.append(error)
            self._levelling.fail(error)
        else:
            self._window = None
            self._searching = False
            self.levelled = said
            self._levelling.succeed(said)

    def _level_at(self, rest: Rest, attitude: Quaternion | None) -> str:
        magnitude = check_gravity(rest.mean)
        if self.settings.attitude == 'message':
            seen = rotate(matrix_from_quaternion(attitude or IDENTITY_QUATERNION), rest.mean)
        else:
            seen = rest.mean
        try:
            check_up_axis(seen)
        except MountingError as warning:
            self.findings.append(warning)
        self.gravity = magnitude
        said = f'gravity is {magnitude:.4f} m/s²'
        if self.settings.attitude == 'rest':
            roll, pitch = euler_from_gravity(rest.mean)
            self._quaternion = quaternion_from_euler(roll, pitch, 0.0)
            self._rot_ws = matrix_from_quaternion(self._quaternion)
            said += f', roll {degrees(roll):.3f}°, pitch {degrees(pitch):.3f}°'
        return said
