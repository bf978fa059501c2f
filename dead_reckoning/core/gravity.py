"""Remove gravity from the specific force: CH Robotics, "Using Accelerometers", section 2."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass

from dead_reckoning.core.attitude import attitude_source
from dead_reckoning.core.checks import require_covariances, require_force, require_rate
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.compass_yaw import CompassYaw
from dead_reckoning.core.errors import (
    DeadReckoningError,
    GapError,
    MountingError,
    NotAtRestError,
    NotLevelledError,
    StaleCompassError,
    SupersededError,
)
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest import check_gravity, check_up_axis, level_variances
from dead_reckoning.core.rest_search import RestSearch, Stillness
from dead_reckoning.core.rotation import (
    cross_covariance,
    isotropic,
    matrix_from_quaternion,
    rotate,
    rotate_covariance,
)
from dead_reckoning.core.samples import (
    IDENTITY,
    IDENTITY_QUATERNION,
    NANOSECONDS,
    UNKNOWN,
    ImuSample,
    LinearAcceleration,
    Matrix,
    Quaternion,
)
from dead_reckoning.core.stamps import Timeline
from dead_reckoning.core.work import Work


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
    ``Σ_a = rot_ws Σ_f rot_wsᵀ + [rot_ws f]× Σ_θ [rot_ws f]×ᵀ + diag(0, 0, σ_g²)``
    (docs/gravity.md).

    Attitude `message` takes the orientation of each sample.  `rest` holds the roll and pitch that
    gravity showed at the first rest (`HeldAttitude`), `estimate` carries them on with the gyro
    (`EstimatedAttitude`), both with the yaw of a compass where there is one; before the first rest
    no sample passes.  The first sample starts the search for rest.  A stale stamp is refused; one
    that goes back by more than 1 s starts all over.  A gap changes nothing but an estimate.
    """

    def __init__(self, settings: GravitySettings, common: CommonSettings, frames: FrameSettings):
        self.settings = settings
        self.findings: list[DeadReckoningError] = []
        """What the last rest showed to be wrong, for whoever reports it and clears it."""
        self.levelled = ''
        """What the last levelling found, in words."""
        self._world_frame = frames.world
        self._noise = isotropic(common.noise_deviation)
        self._timeline = Timeline()
        self._levelling = Work()
        self._compass = CompassYaw(
            settings.compass_timeout, common.turn_deviation, common.attitude_deviation
        )
        self._attitude = attitude_source(settings, common, self._compass)
        self._rotation: tuple[Quaternion, Matrix] = (IDENTITY_QUATERNION, IDENTITY)
        self._start_over()

    def reset(self) -> None:
        """Forget attitude and gravity and look for rest anew, as at the first sample."""
        self._timeline.reset()
        self._compass.reset()
        self._start_over()
        self._levelling.fail(SupersededError('a reset came meanwhile: ask again'))

    def _start_over(self) -> None:
        self.gravity = self.settings.magnitude
        """Gravity [m/s²], as set or as measured at rest."""
        self._gravity_variance = 0.0
        self._attitude.reset()
        self._searching = self.settings.attitude != 'message' or self.settings.measure
        self._begin_rest(self._searching)
        self._stale = False

    @property
    def restarts(self) -> int:
        """How often the stamps went back by more than 1 s."""
        return self._timeline.restarts

    def level(self) -> Future[str]:
        """Take the tilt (but with `message`) and the magnitude of gravity from the coming samples.

        The future ends with a sentence for the user, or with `NotAtRestError` or `GravityError`;
        what was known before stays in force until then.
        """
        self._begin_rest(True)
        return self._levelling.begin()

    def follow_compass(self, compass: ImuSample) -> None:
        """Take a message of a compass, an Imu with an orientation.

        Raises `SampleError` (no orientation, not finite, stale stamp), and then nothing changed.
        """
        self._compass.take(compass)
        self._attitude.follow_compass(compass.stamp_ns)

    def update(self, imu: ImuSample) -> Levelled:
        """Remove gravity from one sample.

        Raises `SampleError` (not finite, no acceleration, no attitude, no angular velocity, stale
        stamp, not levelled yet), and then the attitude is what it was.
        """
        force_s = imu.specific_force
        require_force(imu)
        require_covariances(imu)
        require_rate(imu)
        self._attitude.require(imu)
        restarts = self._timeline.restarts
        step_ns = self._timeline.advance(imu.stamp_ns)
        if self._timeline.restarts != restarts:
            self._start_over()
            self._levelling.fail(NotAtRestError('the stamps went back meanwhile: ask again'))
        self._attitude.advance(imu, step_ns)
        self._watch_gap(step_ns)
        if self._search is not None:
            self._look_for_rest(self._search, imu)
        attitude = self._attitude.attitude
        if attitude is None:
            raise NotLevelledError(
                'waiting for rest: the attitude is taken from gravity, so keep the device still '
                f'for {self.settings.rest_duration:g} s'
            )
        self._watch_compass(imu.stamp_ns)
        if self._rotation[0] is not attitude:
            self._rotation = (attitude, matrix_from_quaternion(attitude))
        rot_ws = self._rotation[1]
        tilt = self._attitude.covariance
        noise = imu.specific_force_covariance
        if noise == UNKNOWN:
            noise = self._noise
        force_w = rotate(rot_ws, force_s)
        tilted = cross_covariance(force_w, tilt)
        noisy = rotate_covariance(rot_ws, noise)
        *covariance, vertical = [t + n for t, n in zip(tilted, noisy)]  # noqa: B905
        acceleration = LinearAcceleration(
            imu.stamp_ns,
            self._world_frame,
            (force_w[0], force_w[1], force_w[2] - self.gravity),
            (*covariance, vertical + self._gravity_variance),  # type: ignore[arg-type]
        )
        if self.settings.attitude != 'message':
            imu = ImuSample(
                imu.stamp_ns,
                imu.frame_id,
                force_s,
                noise,
                *self._attitude.rate(imu),
                attitude,
                tilt,
            )
        return Levelled(imu, acceleration)

    def _watch_gap(self, step_ns: int | None) -> None:
        if step_ns is None or self.settings.attitude != 'estimate':
            return
        if step_ns > self.settings.max_gap * NANOSECONDS and self._attitude.attitude is not None:
            self.findings.append(
                GapError(
                    f'no samples for {step_ns / NANOSECONDS:.3g} s: the attitude is held, its '
                    'uncertainty grows; if the sensor is that slow, raise gravity.max_gap'
                )
            )

    def _watch_compass(self, stamp_ns: int) -> None:
        stale = self._compass.stale(stamp_ns)
        if stale and not self._stale:
            self.findings.append(
                StaleCompassError(
                    f'no compass/data for {self.settings.compass_timeout:g} s: '
                    'the yaw grows uncertain; is the compass still there?'
                )
            )
        self._stale = stale

    def _begin_rest(self, wanted: bool) -> None:
        self._search = (
            RestSearch(self.settings, with_rate=self.settings.attitude == 'estimate')
            if wanted
            else None
        )

    def _look_for_rest(self, search: RestSearch, imu: ImuSample) -> None:
        try:
            still = search.add(imu)
            if still is None:
                return
            said = self._level_at(still, imu.stamp_ns)
        except DeadReckoningError as error:
            # The window is empty again; until the first rest is found the search goes on.
            if not self._searching:
                self._search = None
            if not self._levelling.running and not isinstance(error, NotAtRestError):
                self.findings.append(error)
            self._levelling.fail(error)
        else:
            self._search = None
            self._searching = False
            self.levelled = said
            self._levelling.succeed(said)

    def _level_at(self, still: Stillness, stamp_ns: int) -> str:
        magnitude = check_gravity(still.force.mean)
        seen = still.force.mean
        if self.settings.attitude == 'message':
            attitude = self._attitude.attitude or IDENTITY_QUATERNION
            seen = rotate(matrix_from_quaternion(attitude), seen)
        found = self._attitude.level(still, stamp_ns)
        try:
            check_up_axis(seen)
        except MountingError as warning:
            self.findings.append(warning)
        self.gravity = magnitude
        self._gravity_variance, _ = level_variances(still.force)
        return f'gravity is {magnitude:.4f} m/s²' + (f', {found}' if found else '')
