"""Estimate the attitude from gyro and gravity, with the yaw of a compass where there is one."""

from __future__ import annotations

from math import degrees, exp, remainder, sqrt, tau

from dead_reckoning.core.attitude.gyro_bias import GyroBias
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.compass_yaw import CompassYaw
from dead_reckoning.core.errors import MissingRateError
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest import level_variances
from dead_reckoning.core.rest_search import Stillness
from dead_reckoning.core.rotation import (
    composed,
    euler_from_gravity,
    isotropic,
    matrix_from_quaternion,
    normalized,
    quaternion_from_euler,
    quaternion_from_turn,
    rotate,
    yaw_from_quaternion,
)
from dead_reckoning.core.samples import (
    IDENTITY,
    NANOSECONDS,
    UNKNOWN,
    ZERO,
    ImuSample,
    Matrix,
    Quaternion,
    Vector,
)

FREE_FALL = 0.1
"""Part of gravity below which the smoothed force is no direction to level by."""


class EstimatedAttitude:
    """Turn with the gyro, and bring the smoothed specific force back to the vertical.

    The gyro carries the attitude from sample to sample, so in the world the specific force is
    gravity plus accelerations that average out; two low-passes of `tilt_time` leave gravity, as in
    VQF (Laidig and Seel 2023, doi:10.1016/j.inffus.2022.10.014).  Rests renew the bias of the gyro
    (`GyroBias`).  Yaw follows the compass over `compass_time`, or the gyro alone.  Derived in
    docs/attitude.md.

    It starts from a rest.  Over a gap the attitude is held, and is known less well.
    """

    def __init__(self, settings: GravitySettings, common: CommonSettings, compass: CompassYaw):
        self._settings = settings
        self._compass = compass
        self._level_variance = common.attitude_deviation**2
        self._rate_variance = common.rate_deviation**2
        self._turn_deviation = common.turn_deviation
        self.reset()

    def reset(self) -> None:
        """Forget attitude and bias."""
        self.attitude: Quaternion | None = None
        """Takes the sensor into the world; None before the first rest."""
        self.bias = GyroBias(self._settings)
        """Bias of the gyro."""
        self._rot_ws: Matrix = IDENTITY
        self._rate: Vector = ZERO
        self._force: Vector = ZERO  # after the first low-pass, world
        self._gravity = 0.0  # after the second, which points up
        self._compassed = False
        # Variances [rad²], where nothing else is said.
        self._motion = 0.0  # of accelerations that have not averaged out [m²/s⁴]
        self._lost = 0.0  # of the tilt, by gaps
        self._shaken = 0.0  # of the tilt, by the noise of the gyro
        self._yaw_variance = 0.0  # of what the gyro gave the yaw
        self._yaw_bias = 0.0  # covariance of that with the bias [rad²/s]
        self._compass_deviation = 0.0  # of what the compass gave the yaw [rad]
        self._turned: Vector = ZERO  # by the gyro, and not yet corrected [rad], world

    def require(self, imu: ImuSample) -> None:
        """Raise `SampleError` where a sample is of no use."""
        if imu.angular_velocity is None:
            raise MissingRateError(
                'the Imu measures no angular velocity, and gravity.attitude is estimate: take the '
                'topic of a device with a gyro, or set gravity.attitude to rest'
            )

    def level(self, still: Stillness, stamp_ns: int) -> str:
        """Take tilt and bias from a rest; return them in words.

        The yaw stays what it was; at first it is that of the compass, or 0.  Raises
        `CalibrationError` where the gyro shows more than a bias.
        """
        assert still.rate is not None
        self.bias.set(still.rate)
        roll, pitch = euler_from_gravity(still.force.mean)
        first = self.attitude is None
        yaw = 0.0 if self.attitude is None else yaw_from_quaternion(self.attitude)
        self._set(quaternion_from_euler(roll, pitch, yaw))
        self._gravity = sqrt(sum(f * f for f in still.force.mean))
        self._force = (0.0, 0.0, self._gravity)
        self._motion = level_variances(still.force)[1] * self._gravity**2
        self._lost = self._yaw_bias = 0.0
        self._turned = (0.0, 0.0, self._turned[2])
        if first:
            self._yaw_variance = self._level_variance
            if not self._compass.stale(stamp_ns):
                self.follow_compass(stamp_ns)
        said = ', '.join(f'{degrees(b):.3f}' for b in self.bias.value)
        return f'roll {degrees(roll):.3f}°, pitch {degrees(pitch):.3f}°, gyro bias {said} °/s'

    def advance(self, imu: ImuSample, step_ns: int | None) -> None:
        """Carry the attitude on to a sample."""
        rate = imu.angular_velocity
        assert rate is not None
        before, self._rate = self._rate, rate
        if self.attitude is None or step_ns is None:
            return
        dt = step_ns / NANOSECONDS
        self.bias.wander(dt)
        if dt > self._settings.max_gap:
            hidden = (self._turn_deviation * dt) ** 2
            self._lost += hidden
            self._yaw_variance += hidden
            return
        self._turn(self.attitude, dt, before, rate)
        self._follow_gravity(dt, imu.specific_force)
        self._yaw_bias *= 1.0 - self.bias.learn(imu, self._rot_ws)
        self._spread(dt, imu.angular_velocity_covariance)

    def rate(self, imu: ImuSample) -> tuple[Vector | None, Matrix]:
        """Take the bias off; what is not known of it and of the sensitivity adds to the noise."""
        assert imu.angular_velocity is not None
        x, y, z = (r - b for r, b in zip(imu.angular_velocity, self.bias.value, strict=True))
        scale = self._scale_variance
        noise = imu.angular_velocity_covariance
        if noise == UNKNOWN:
            noise = isotropic(sqrt(self._rate_variance))
        xx, xy, xz, _, yy, yz, _, _, zz = noise
        bias = self.bias.variance
        xx, yy, zz = xx + bias + scale(x), yy + bias + scale(y), zz + bias + scale(z)
        return (x, y, z), (xx, xy, xz, xy, yy, yz, xz, yz, zz)

    def follow_compass(self, stamp_ns: int) -> None:
        """Turn the yaw towards that of the compass, all the way with its first message."""
        found = self._compass.at(stamp_ns)
        if found is None or self.attitude is None:
            return
        yaw, variance = found
        gain = 1.0
        if self._compassed and self._compass.interval is not None:
            gain = 1.0 - exp(-self._compass.interval / self._settings.compass_time)
            drifted = self._yaw_variance + self._scale_variance(self._turned[2])
            if drifted > gain / (1.0 - gain + 1e-12) * variance:
                # It has drifted further than the compass is wrong: no need to follow slowly.
                gain = drifted / (drifted + variance)
        self._compassed = True
        turn = gain * remainder(yaw - yaw_from_quaternion(self.attitude), tau)
        self._turn_world(self.attitude, quaternion_from_turn((0.0, 0.0, turn)))
        left = 1.0 - gain
        self._compass_deviation = left * self._compass_deviation + gain * sqrt(variance)
        self._yaw_variance *= left * left
        self._yaw_bias *= left
        self._turned = (self._turned[0], self._turned[1], left * self._turned[2])

    @property
    def covariance(self) -> Matrix:
        """Of the attitude, shape (3, 3) [rad²], about the axes of the world."""
        x, y, z = self._turned
        lag = 2.0 * self._settings.tilt_time  # a constant bias tilts it by lag · bias
        tilt = (
            self._level_variance
            + self._motion / self._gravity**2
            + self._lost
            + self._shaken
            + lag * lag * self.bias.variance
            + self._scale_variance(x)
            + self._scale_variance(y)
        )
        yaw = self._yaw_variance + self._compass_deviation**2 + self._scale_variance(z)
        return (tilt, 0.0, 0.0, 0.0, tilt, 0.0, 0.0, 0.0, yaw)

    def _set(self, attitude: Quaternion) -> None:
        self.attitude = normalized(attitude)
        self._rot_ws = matrix_from_quaternion(self.attitude)

    def _turn_world(self, attitude: Quaternion, turn: Quaternion) -> None:
        """Turn the attitude about the world, and with it what is kept there."""
        self._set(composed(turn, attitude))
        self._force = rotate(matrix_from_quaternion(turn), self._force)

    def _turn(self, attitude: Quaternion, dt: float, before: Vector, after: Vector) -> None:
        """Integrate the rate, linear between two samples, to second order in ``dt``."""
        bx, by, bz = self.bias.value
        x0, y0, z0 = before[0] - bx, before[1] - by, before[2] - bz
        x1, y1, z1 = after[0] - bx, after[1] - by, after[2] - bz
        half, coning = 0.5 * dt, dt * dt / 12.0
        turn = (
            half * (x0 + x1) + coning * (y0 * z1 - z0 * y1),
            half * (y0 + y1) + coning * (z0 * x1 - x0 * z1),
            half * (z0 + z1) + coning * (x0 * y1 - y0 * x1),
        )
        self._set(composed(attitude, quaternion_from_turn(turn)))
        x, y, z = rotate(self._rot_ws, turn)
        forget = exp(-half / self._settings.tilt_time)
        tx, ty, tz = self._turned
        self._turned = (forget * tx + x, forget * ty + y, tz + z)

    def _follow_gravity(self, dt: float, force_s: Vector) -> None:
        """Smooth the force in the world, and turn the world so that it points up."""
        keep = exp(-dt / self._settings.tilt_time)
        x, y, z = rotate(self._rot_ws, force_s)
        ax, ay, az = self._force
        ax, ay, az = x + keep * (ax - x), y + keep * (ay - y), z + keep * (az - z)
        self._force = (ax, ay, az)
        gx, gy, gz = ax - keep * ax, ay - keep * ay, az + keep * (self._gravity - az)
        if self.attitude is not None and gz > FREE_FALL * self._gravity:
            length = sqrt(gx * gx + gy * gy + gz * gz)
            # The shortest turn that takes (gx, gy, gz) to the vertical.
            self._turn_world(self.attitude, normalized((gy, -gx, 0.0, length + gz)))
            self._gravity = length
        ax, ay, _ = self._force
        excess = ax * ax + ay * ay
        self._motion = excess + keep * (self._motion - excess)

    def _spread(self, dt: float, covariance: Matrix) -> None:
        """Let grow what is not known."""
        noise = self._rate_variance
        if covariance != UNKNOWN:
            noise = (covariance[0] + covariance[4] + covariance[8]) / 3.0
        self._shaken = 1.25 * self._settings.tilt_time * noise * dt
        self._lost *= exp(-dt / self._settings.tilt_time)
        bias = self.bias.variance
        self._yaw_variance += dt * (2.0 * self._yaw_bias + dt * bias + dt * noise)
        self._yaw_bias += dt * bias

    def _scale_variance(self, turned: float) -> float:
        return (self._settings.rate_scale_deviation * turned) ** 2
