"""Turn velocities and poses that something else measures into what the navigator can take."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

from dead_reckoning.core.checks import is_covariance, require_vector
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import AidingError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.mounting import Mountings, unmounted
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.rotation import (
    matrix_from_quaternion,
    normalized,
    rotate,
    rotate_covariance,
    yaw_from_quaternion,
)
from dead_reckoning.core.samples import (
    IDENTITY_QUATERNION,
    NANOSECONDS,
    UNMEASURED_VARIANCE,
    ZERO,
    Matrix,
    PoseSample,
    Quaternion,
    Vector,
    VelocitySample,
)

LONGEST_INTERVAL = 1.0
"""Time [s] that a refusal counts for at most."""

SMALLEST_VARIANCE = 1e-12
"""Variance [SI²] below which nothing is measured so well, and powers of its inverse overflow."""

ROUNDING = 1e-14
"""Part of a large variance below which a small one is lost when both are turned."""


class Aiding:
    """Hand over what is measured elsewhere, in the frames and at the points that a navigator has.

    It knows the sensor s, with the axes of the body b; points of the body are seen from s.
    ``lever_arm`` returns where s is on b, ``start`` where s was from the body in the world when
    both were at the origin, shapes (3,) [m].
    """

    def __init__(
        self,
        navigator: InertialNavigator,
        frames: FrameSettings | None = None,
        mountings: Mountings = unmounted,
        lever_arm: Callable[[], Vector] = lambda: ZERO,
        start: Callable[[], Vector] = lambda: ZERO,
    ) -> None:
        self._navigator = navigator
        self._frames = frames or FrameSettings()
        self._mountings = mountings
        self._lever_arm = lever_arm
        self._start = start
        self._last_ns: dict[int, int] = {}
        self._placed: object = None

    def take_twist(self, sample: VelocitySample) -> None:
        """Take a velocity of aiding/twist; raises `SampleError`."""
        settings = self._navigator.settings
        if settings.aiding_twist:
            self._take_velocity(sample, layout.BY_TWIST, settings.twist_lever_arm)

    def take_odometry(self, sample: VelocitySample) -> None:
        """Take the twist of aiding/odom; raises `SampleError`."""
        if self._navigator.settings.aiding_odom:
            self._take_velocity(sample, layout.BY_ODOM, ZERO)

    def take_pose(self, pose: PoseSample) -> None:
        """Take position and yaw of aiding/pose, of which the first one places the body.

        Raises `SampleError`.
        """
        navigator = self._navigator
        settings = navigator.settings
        if not settings.aiding_pose:
            return
        self._require_world(pose)
        _require(pose.position, pose.position_covariance, 'position')
        _require(ZERO, pose.attitude_covariance, 'orientation')
        attitude, variance = _attitude(pose), pose.attitude_covariance[8]
        arm = settings.pose_lever_arm
        if self._placed is not navigator.strides:  # since the last start of the navigator
            self._place(pose, arm, _held(pose.attitude_covariance))
            return
        interval = self._interval(layout.BY_POSE, pose.stamp_ns)
        value = _difference(pose.position, self._start())
        told = (
            layout.WORLD_POSITION, layout.BY_POSE, interval, *value,
            *_half(pose.position_covariance), *_difference(arm, self._lever_arm()),
        )  # fmt: skip
        navigator.follow(pose.stamp_ns, layout.VECTOR, told)
        self._last_ns[layout.BY_POSE] = pose.stamp_ns
        if variance < UNMEASURED_VARIANCE:
            yaw, patience = yaw_from_quaternion(attitude), settings.aiding_patience
            told = (yaw, variance, interval, 0.0, patience, layout.BY_POSE_YAW)
            navigator.follow(pose.stamp_ns, layout.YAW, told)

    def set_pose(self, pose: PoseSample) -> None:
        """Set the body to a pose: at its stamp, or now where that is 0; raises `SampleError`.

        Height, roll and pitch without a variance stay as they are, as a pose in a plane has none.
        """
        self._require_world(pose)
        x, y = pose.position_covariance[0], pose.position_covariance[4]
        yaw = pose.attitude_covariance[8]
        if not (x > 0.0 and y > 0.0 and yaw > 0.0):
            raise AidingError(
                f'set_pose has the variances {x} and {y} m² of x and y and {yaw} rad² of the yaw: '
                'give each one above 0, and 1e6 to what shall stay'
            )
        position_covariance = _flat(pose.position_covariance)
        attitude_covariance = pose.attitude_covariance
        if not min(attitude_covariance[0], attitude_covariance[4]) > 0.0:
            attitude_covariance = _held(attitude_covariance)
        _require(pose.position, position_covariance, 'position')
        _require(ZERO, attitude_covariance, 'orientation')
        self._place(pose, ZERO, attitude_covariance, position_covariance)

    def _place(
        self,
        pose: PoseSample,
        arm: Vector,
        attitude_covariance: Matrix,
        position_covariance: Matrix | None = None,
    ) -> None:
        navigator = self._navigator
        told = (
            *_difference(pose.position, self._start()),
            *_half(position_covariance or pose.position_covariance),
            *_attitude(pose),
            *_half(attitude_covariance),
            *_difference(self._lever_arm(), arm),
        )
        navigator.follow(pose.stamp_ns or navigator.newest_ns, layout.PLACE, told)
        self._placed = navigator.strides

    def _take_velocity(self, sample: VelocitySample, who: int, arm: Vector) -> None:
        frame_id, velocity, covariance = sample.frame_id, sample.velocity, sample.covariance
        _require(velocity, covariance, 'velocity')
        what = layout.BODY_VELOCITY
        if frame_id == self._frames.world:
            what = layout.WORLD_VELOCITY
        elif frame_id not in ('', self._frames.body):
            if self._frames.mounting == 'parameters':
                raise AidingError(
                    f'a velocity is in the frame {frame_id!r}, which is neither the body '
                    f'{self._frames.body!r} nor the world {self._frames.world!r}: a GNSS has to '
                    "name the world; else set frames.body to it, or frames.mounting to 'tf', "
                    'which knows it'
                )
            mounting = self._mountings(frame_id)
            rot_bs = matrix_from_quaternion(mounting.rotation)
            velocity, arm = rotate(rot_bs, velocity), mounting.translation
            covariance = _turned(rot_bs, covariance)
        covariance = _askew(covariance, velocity, self._navigator.settings.aiding_angle)
        told = (
            what, who, self._interval(who, sample.stamp_ns), *velocity, *_half(covariance),
            *_difference(arm, self._lever_arm()),
        )  # fmt: skip
        self._navigator.follow(sample.stamp_ns, layout.VECTOR, told)
        self._last_ns[who] = sample.stamp_ns

    def _interval(self, who: int, stamp_ns: int) -> float:
        """Return the time since the last one that was handed over [s]; 0 at the first.

        Where both have one stamp it is not 0, but so short that the second tells nothing new.
        """
        last_ns = self._last_ns.get(who)
        if last_ns is None:
            return 0.0
        return min(max(1, abs(stamp_ns - last_ns)) / NANOSECONDS, LONGEST_INTERVAL)

    def _require_world(self, pose: PoseSample) -> None:
        if pose.frame_id not in ('', self._frames.world):
            raise AidingError(
                f'a pose is in the frame {pose.frame_id!r}, and the world of this filter is '
                f'{self._frames.world!r}: send it there, or set frames.world'
            )


def _require(vector: Vector, covariance: Matrix, name: str) -> None:
    """Raise `SampleError` for a vector, or a covariance, shape (3, 3), of no measurement."""
    require_vector(vector, name, 'check where it comes from')
    xx, xy, xz, _, yy, yz, _, _, zz = covariance
    if is_covariance(covariance) and min(xx, yy, zz) >= SMALLEST_VARIANCE:
        rest = yy - xy * xy / xx
        if rest > 0.0 and zz - xz * xz / xx - (yz - xy * xz / xx) ** 2 / rest > 0.0:
            return
    raise AidingError(
        f'the covariance of the {name} is {covariance}: each axis needs a variance above 0, 1e6 '
        'where it is not measured, and no correlation of 1'
    )


def _turned(rot: Matrix, covariance: Matrix) -> Matrix:
    """Turn a covariance of which some axes may not be measured, and others be known well.

    What is not measured has `UNMEASURED_VARIANCE`, so that little is lost in its rounding, and
    that little is added.
    """
    scale = [min(1.0, sqrt(UNMEASURED_VARIANCE / covariance[i])) for i in (0, 4, 8)]
    a, b, c, d, e, f, g, h, i = (
        x * scale[k // 3] * scale[k % 3] for k, x in enumerate(covariance)
    )
    lost = ROUNDING * (a + e + i)
    return rotate_covariance(rot, (a + lost, b, c, d, e + lost, f, g, h, i + lost))


def _askew(covariance: Matrix, velocity: Vector, angle: float) -> Matrix:
    """Add what axes that are askew by an angle, one sigma [rad], make of a velocity."""
    variance = angle**2 * sum(v * v for v in velocity)
    xx, xy, xz, yx, yy, yz, zx, zy, zz = covariance
    return (xx + variance, xy, xz, yx, yy + variance, yz, zx, zy, zz + variance)


def _attitude(pose: PoseSample) -> Quaternion:
    """Return the attitude of a pose; none, which many send, where the yaw is not measured."""
    if pose.attitude_covariance[8] < UNMEASURED_VARIANCE:
        return normalized(pose.attitude)
    return IDENTITY_QUATERNION


def _half(covariance: Matrix) -> tuple[float, ...]:
    """Return the upper half of a covariance, shape (6,)."""
    return (*covariance[0:3], *covariance[4:6], covariance[8])


def _held(covariance: Matrix) -> Matrix:
    """Return the covariance of an attitude of which but the yaw is measured."""
    huge = UNMEASURED_VARIANCE
    return (huge, 0.0, 0.0, 0.0, huge, 0.0, 0.0, 0.0, covariance[8])


def _flat(covariance: Matrix) -> Matrix:
    """Return the covariance of a position, in a plane where the height has none."""
    a, b, _, c, d, _, _, _, variance = covariance
    if variance > 0.0:
        return covariance
    return (a, b, 0.0, c, d, 0.0, 0.0, 0.0, UNMEASURED_VARIANCE)


def _difference(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]
