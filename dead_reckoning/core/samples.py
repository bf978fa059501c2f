"""What flows through a chain: samples in, states out; frozen values, no behaviour.

Vectors, quaternions and matrices are plain tuples of floats: three numbers of a message are read,
rotated and written far faster in scalar Python than through arrays of three.  Batch work on whole
recordings uses arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

Vector: TypeAlias = tuple[float, float, float]
"""Shape (3,): x, y, z."""

Quaternion: TypeAlias = tuple[float, float, float, float]
"""Shape (4,): x, y, z, w, in the order of geometry_msgs; unit length."""

Matrix: TypeAlias = tuple[float, float, float, float, float, float, float, float, float]
"""Shape (3, 3), row by row, as ROS lays covariances out."""

ZERO: Vector = (0.0, 0.0, 0.0)
IDENTITY_QUATERNION: Quaternion = (0.0, 0.0, 0.0, 1.0)
IDENTITY: Matrix = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
UNKNOWN: Matrix = (0.0,) * 9
"""The covariance that says nothing (REP-145): unknown, never certain."""

NOT_MEASURED: Matrix = (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""The covariance of what the device does not measure (REP-145)."""

UNMEASURED_VARIANCE = 1e6
"""Variance of what nothing measures, where a message can't say so: huge, as 0 means certain."""

NANOSECONDS = 1_000_000_000


@dataclass(frozen=True, slots=True, eq=False)
class ImuSample:
    """One reading of an inertial sensor, as sensor_msgs/Imu carries it.

    ``stamp_ns``
        time of measurement [ns].
    ``frame_id``
        the sensor's frame s.
    ``specific_force``, ``specific_force_covariance``
        shapes (3,) [m/s²] and (3, 3) [m²/s⁴], frame s: gravity in it, +g on the up axis at rest.
        A covariance of zeros is unknown.
    ``angular_velocity``, ``angular_velocity_covariance``
        shapes (3,) [rad/s] and (3, 3) [rad²/s²], frame s; None where the device has no gyro.
    ``orientation``, ``orientation_covariance``
        quaternion that takes s into the world w, and its covariance, shape (3, 3) [rad²], about
        the axes of w; None where the device has no attitude.
    """

    stamp_ns: int
    frame_id: str
    specific_force: Vector
    specific_force_covariance: Matrix = UNKNOWN
    angular_velocity: Vector | None = None
    angular_velocity_covariance: Matrix = UNKNOWN
    orientation: Quaternion | None = None
    orientation_covariance: Matrix = UNKNOWN


@dataclass(frozen=True, slots=True, eq=False)
class LinearAcceleration:
    """Acceleration of the sensor with gravity removed, in the world.

    ``stamp_ns``
        time of measurement [ns].
    ``frame_id``
        the world frame w.
    ``acceleration``, ``covariance``
        shapes (3,) [m/s²] and (3, 3) [m²/s⁴], frame w.
    """

    stamp_ns: int
    frame_id: str
    acceleration: Vector
    covariance: Matrix = UNKNOWN


@dataclass(frozen=True, slots=True, eq=False)
class VelocitySample:
    """A velocity that something else measures: wheels, a GNSS, an optical flow.

    ``stamp_ns``
        time of measurement [ns].
    ``frame_id``
        the frame whose axes it has, and whose origin it is the velocity of; in the world frame,
        that of a point of the body.
    ``velocity``, ``covariance``
        shapes (3,) [m/s] and (3, 3) [m²/s²].
    """

    stamp_ns: int
    frame_id: str
    velocity: Vector
    covariance: Matrix


@dataclass(frozen=True, slots=True, eq=False)
class PoseSample:
    """Where the body is, as something else measures it, or as a user sets it.

    ``stamp_ns``
        time of measurement [ns].
    ``frame_id``
        the world frame w.
    ``position``, ``position_covariance``
        shapes (3,) [m] and (3, 3) [m²], frame w.
    ``attitude``, ``attitude_covariance``
        quaternion that takes the body into w, and its covariance, shape (3, 3) [rad²], about the
        axes of w.
    """

    stamp_ns: int
    frame_id: str
    position: Vector
    position_covariance: Matrix
    attitude: Quaternion
    attitude_covariance: Matrix


@dataclass(frozen=True, slots=True, eq=False)
class NavigationState:
    """Where the body is, how fast it moves, and how well both are known, in the world w.

    ``stamp_ns``
        time of the sample behind it [ns].
    ``position``, ``position_covariance``
        shapes (3,) [m] and (3, 3) [m²], frame w.
    ``velocity``, ``velocity_covariance``
        shapes (3,) [m/s] and (3, 3) [m²/s²], frame w (an Odometry message carries them in the
        body's frame; the wire turns them).  The covariance is that of the velocity as the body
        sees it: a body whose heading is not known does not slide sideways.
    ``attitude``, ``attitude_covariance``
        quaternion that takes the body into w, and its covariance, shape (3, 3) [rad²], about the
        axes of w.
    ``angular_velocity``, ``angular_velocity_covariance``
        shapes (3,) [rad/s] and (3, 3) [rad²/s²], frame of the body; None where nothing
        measures it.
    ``stationary``
        whether the estimator holds the body for resting.
    ``pose_cross_covariance``
        of position (rows) and attitude, shape (3, 3) [m rad]; zeros where it is not known.
    ``twist_cross_covariance``
        of velocity (rows, frame w) and rate of turn (frame of the body), shape (3, 3) [m rad/s²];
        zeros where it is not known.
    """

    stamp_ns: int
    position: Vector
    velocity: Vector
    attitude: Quaternion = IDENTITY_QUATERNION
    position_covariance: Matrix = UNKNOWN
    velocity_covariance: Matrix = UNKNOWN
    attitude_covariance: Matrix = UNKNOWN
    angular_velocity: Vector | None = None
    angular_velocity_covariance: Matrix = UNKNOWN
    stationary: bool = False
    pose_cross_covariance: Matrix = UNKNOWN
    twist_cross_covariance: Matrix = UNKNOWN
