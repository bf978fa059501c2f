"""Read and write messages in place: the bytes that `wire` reads and writes, as arrays of doubles.

Four bytes before a message aligns its doubles, so the stamp is the second of them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from dead_reckoning.core.kernels.columns import (
    Array,
    ImuColumns,
    matrix,
    measured,
    put,
    quaternion,
    vector,
)
from dead_reckoning.core.kernels.integrator import StateColumns
from dead_reckoning.core.kernels.memory import IMU_DOUBLES, ODOMETRY_DOUBLES
from dead_reckoning.core.rotation import (
    matrix_from_quaternion,
    product,
    rotate_back,
    rotate_covariance,
    transposed,
)
from dead_reckoning.core.samples import NANOSECONDS, UNMEASURED_VARIANCE, Matrix


def read_imu(message: Array, stamp_ns: Any) -> ImuColumns:
    """Read an Imu as `wire.decode_imu` does, in place; no stamp is 0."""
    seconds, nanoseconds = message.view(np.int32)[2], message.view(np.uint32)[3]
    whole = np.int64(nanoseconds) < NANOSECONDS
    stamp_ns[0] = np.int64(seconds) * NANOSECONDS + np.int64(nanoseconds) if whole else 0
    doubles = message[len(message) - IMU_DOUBLES :]
    if not doubles[4] >= 0.0 or not doubles[:4].any():
        doubles[:4] = 0.0
        doubles[4] = -1.0
    if not doubles[16] >= 0.0:
        doubles[13:16] = 0.0
        doubles[16] = -1.0
    return ImuColumns(
        stamp_ns,
        doubles[25:28].reshape((1, 3)),
        doubles[28:37].reshape((1, 9)),
        doubles[13:16].reshape((1, 3)),
        doubles[16:25].reshape((1, 9)),
        doubles[:4].reshape((1, 4)),
        doubles[4:13].reshape((1, 9)),
    )


def write_odometry(stamp_ns: int, state: StateColumns, odometry: Array) -> None:
    """Write an Odometry as `wire.odometry_encoder` does; the frames are there already."""
    odometry.view(np.int32)[2] = stamp_ns // NANOSECONDS
    odometry.view(np.uint32)[3] = stamp_ns % NANOSECONDS
    d = odometry[len(odometry) - ODOMETRY_DOUBLES :]
    attitude = quaternion(state.attitude, 0)
    rot_wb = matrix_from_quaternion(attitude)
    put(d[:3], vector(state.position, 0))
    d[3], d[4], d[5], d[6] = attitude
    _put_blocks(
        d[7:43], matrix(state.position_covariance, 0), matrix(state.attitude_covariance, 0)
    )
    put(d[43:46], rotate_back(rot_wb, vector(state.velocity, 0)))
    velocity = rotate_covariance(transposed(rot_wb), matrix(state.velocity_covariance, 0))
    put(d[46:49], vector(state.angular_velocity, 0))
    huge = UNMEASURED_VARIANCE
    rate = (huge, 0.0, 0.0, 0.0, huge, 0.0, 0.0, 0.0, huge)
    if measured(state.angular_velocity_covariance, 0):
        rate = matrix(state.angular_velocity_covariance, 0)
    _put_blocks(d[49:], velocity, rate)


def write_cross(of_pose: Matrix, of_twist: Matrix, odometry: Array) -> None:
    """Write what an Odometry, written already, says of position with attitude, twist with rate."""
    d = odometry[len(odometry) - ODOMETRY_DOUBLES :]
    rot_wb = matrix_from_quaternion((d[3], d[4], d[5], d[6]))
    _put_cross(d[7:43], of_pose)
    _put_cross(d[49:], product(transposed(rot_wb), of_twist))


def _put_cross(out: Array, cross: Matrix) -> None:
    """Write a covariance, shape (3, 3), and its transpose, beside the diagonal of (6, 6)."""
    for row in range(3):
        for column in range(3):
            out[6 * row + 3 + column] = cross[3 * row + column]
            out[6 * (3 + column) + row] = cross[3 * row + column]


def _put_blocks(out: Array, first: Matrix, second: Matrix) -> None:
    """Write two covariances, shape (3, 3), on the diagonal of one, shape (6, 6)."""
    for row in range(3):
        for column in range(3):
            out[6 * row + column] = first[3 * row + column]
            out[21 + 6 * row + column] = second[3 * row + column]
