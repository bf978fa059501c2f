"""Turn what a sensor measures into the axes of its body, and carry what comes of it to the body.

Derived in docs/mounting.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import MissingMountingError, SettingsError
from dead_reckoning.core.rotation import (
    composed,
    cross_matrix,
    inverse,
    matrix_from_quaternion,
    product,
    quaternion_from_euler,
    rotate,
    rotate_covariance,
    similarity,
    transposed,
)
from dead_reckoning.core.samples import (
    IDENTITY_QUATERNION,
    ZERO,
    ImuSample,
    Matrix,
    NavigationState,
    Quaternion,
    Vector,
)


@dataclass(frozen=True, slots=True, eq=False)
class Mounting:
    """Say how a sensor s sits on the body b.

    ``rotation``
        quaternion that takes s into b.
    ``translation``
        where the sensor is, its lever arm, shape (3,) [m], frame b.
    """

    rotation: Quaternion = IDENTITY_QUATERNION
    translation: Vector = ZERO

    def to_body(self, imu: ImuSample) -> ImuSample:
        """Return a sample in the axes of b, measured where it was; its orientation is that of b.

        With the identity that is the sample itself.
        """
        return _turned(imu, self.rotation)

    def to_sensor(self, imu: ImuSample) -> ImuSample:
        """Return a sample in the axes of s again."""
        return _turned(imu, inverse(self.rotation))


Mountings: TypeAlias = Callable[[str], Mounting]
"""Gives the mounting of the sensor that a frame id names; raises `MissingMountingError` while it
is not known."""


def unmounted(frame_id: str) -> Mounting:
    """Return the mounting of a sensor that is the body itself."""
    return IDENTITY_MOUNTING


IDENTITY_MOUNTING = Mounting()


def is_turned(mountings: Mountings, frame_id: str) -> bool:
    """Say whether the axes of a sensor are not those of its body, or are not known."""
    try:
        return mountings(frame_id).rotation != IDENTITY_QUATERNION
    except MissingMountingError:
        return True


def mountings_of(frames: FrameSettings) -> Mountings:
    """Return the mounting that the parameters hold, whatever the frame id.

    Raises `SettingsError` where it is to come from TF, which only a node can hear.
    """
    if frames.mounting != 'parameters':
        raise SettingsError(
            f'frames.mounting: {frames.mounting!r} needs a node that hears TF; here give the '
            "mounting by frames.mounting_rotation and _translation, with 'parameters'"
        )
    mounting = Mounting(
        quaternion_from_euler(*frames.mounting_rotation), frames.mounting_translation
    )
    return lambda _: mounting


def carried(
    state: NavigationState,
    rot_wb: Matrix,
    lever_arm: Vector,
    start_w: Vector,
    rate_covariance: Matrix,
) -> NavigationState:
    """Carry the state of a sensor to the body on which it sits at ``lever_arm`` r.

    ``p_b = p_s + start_w − rot_wb·r`` and ``v_b = v_s − rot_wb·(ω × r)``.  ``start_w`` is rot_wb·r
    where the way began, shape (3,) [m]: both begin at the origin.  Without a rate of turn ω the
    velocity stays that of the sensor; ``rate_covariance``, shape (3, 3) [rad²/s²], frame b, says
    how well ω is known, or else how fast the body may turn.
    """
    now = rotate(rot_wb, lever_arm)
    moved = (start_w[0] - now[0], start_w[1] - now[1], start_w[2] - now[2])
    x, y, z = lever_arm
    a, b, c = state.angular_velocity or ZERO
    slower = rotate(rot_wb, (c * y - b * z, a * z - c * x, b * x - a * y))
    by_turn, by_rate = cross_matrix(moved), product(rot_wb, cross_matrix((-x, -y, -z)))
    position, of_pose = _carried(
        state.position_covariance, state.pose_cross_covariance, state.attitude_covariance, by_turn
    )
    velocity, of_twist = _carried(
        state.velocity_covariance, state.twist_cross_covariance, rate_covariance, by_rate
    )
    return replace(
        state,
        position=_sum(state.position, moved),
        velocity=_sum(state.velocity, slower),
        position_covariance=position,
        velocity_covariance=velocity,
        pose_cross_covariance=of_pose,
        twist_cross_covariance=of_twist,
    )


def _carried(own: Matrix, cross: Matrix, turn: Matrix, m: Matrix) -> tuple[Matrix, Matrix]:
    """Return the covariance of a − m θ, and that of it with θ; those of a, both, θ are given."""
    minus = product(tuple(-x for x in m), transposed(cross))  # type: ignore[arg-type]
    carried = _sum(own, similarity(m, turn), minus, transposed(minus))
    return carried, _sum(cross, product(tuple(-x for x in m), turn))  # type: ignore[arg-type]


def _turned(imu: ImuSample, q_bs: Quaternion) -> ImuSample:
    if q_bs == IDENTITY_QUATERNION:
        return imu
    rot_bs = matrix_from_quaternion(q_bs)
    rate, orientation = imu.angular_velocity, imu.orientation
    if orientation is not None:
        orientation = composed(orientation, inverse(q_bs))
    return ImuSample(
        imu.stamp_ns,
        imu.frame_id,
        rotate(rot_bs, imu.specific_force),
        _turned_covariance(rot_bs, imu.specific_force_covariance),
        None if rate is None else rotate(rot_bs, rate),
        _turned_covariance(rot_bs, imu.angular_velocity_covariance),
        orientation,
        imu.orientation_covariance,
    )


def _turned_covariance(rot_bs: Matrix, covariance: Matrix) -> Matrix:
    # A first element of −1 says that there is no measurement, in any axes.
    return covariance if covariance[0] < 0.0 else rotate_covariance(rot_bs, covariance)


def _sum(*terms: tuple[float, ...]) -> Any:
    return tuple(map(sum, zip(*terms, strict=True)))
