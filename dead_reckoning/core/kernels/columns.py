"""Read rows of columns as tuples, and say which rows hold what estimators use as it is."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.checks import is_covariance, is_measurable
from dead_reckoning.core.samples import Matrix, Quaternion, Vector

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]

IN_ONE_PIECE: tuple[Literal['C'], Literal['A'], Literal['W']] = ('C', 'A', 'W')
"""Contiguous, aligned, writable: what kernels are compiled for."""


class ImuColumns(NamedTuple):
    """Columns of an `ImuBlock`, as a kernel takes them."""

    stamp_ns: Stamps
    force: Array
    force_covariance: Array
    rate: Array
    rate_covariance: Array
    orientation: Array
    orientation_covariance: Array


def imu_columns(block: Any) -> ImuColumns:
    """Return the columns of an `ImuBlock`, each in one piece: kernels are compiled for that."""
    return ImuColumns(
        np.require(block.stamp_ns, np.int64, IN_ONE_PIECE),
        *(
            in_one_piece(column)
            for column in (
                block.specific_force,
                block.specific_force_covariance,
                block.angular_velocity,
                block.angular_velocity_covariance,
                block.orientation,
                block.orientation_covariance,
            )
        ),
    )


def in_one_piece(column: Array) -> Array:
    """Return a column as kernels take it: itself, if it is contiguous and may be written."""
    return np.require(column, np.float64, IN_ONE_PIECE)


def vector(column: Array, i: int) -> Vector:
    """Return a row of three."""
    return column[i, 0], column[i, 1], column[i, 2]


def quaternion(column: Array, i: int) -> Quaternion:
    """Return a row of four."""
    return column[i, 0], column[i, 1], column[i, 2], column[i, 3]


def matrix(column: Array, i: int) -> Matrix:
    """Return a row of nine."""
    a, b, c = column[i, 0], column[i, 1], column[i, 2]
    d, e, f = column[i, 3], column[i, 4], column[i, 5]
    g, h, j = column[i, 6], column[i, 7], column[i, 8]
    return a, b, c, d, e, f, g, h, j


def put_vector(column: Array, i: int, values: Vector) -> None:
    """Write a row of three."""
    column[i, 0], column[i, 1], column[i, 2] = values


def put_quaternion(column: Array, i: int, values: Quaternion) -> None:
    """Write a row of four."""
    column[i, 0], column[i, 1], column[i, 2], column[i, 3] = values


def put_matrix(column: Array, i: int, values: Matrix) -> None:
    """Write a row of nine."""
    a, b, c, d, e, f, g, h, j = values
    column[i, 0], column[i, 1], column[i, 2] = a, b, c
    column[i, 3], column[i, 4], column[i, 5] = d, e, f
    column[i, 6], column[i, 7], column[i, 8] = g, h, j


def triple(array: Array) -> Vector:
    """Return an array of three as a vector."""
    return array[0], array[1], array[2]


def put(array: Array, values: Vector) -> None:
    """Write a vector into an array of three."""
    array[0], array[1], array[2] = values


def is_unknown(covariance: Matrix) -> bool:
    """Say whether a covariance is all zeros, which says nothing (REP-145)."""
    a, b, c, d, e, f, g, h, j = covariance
    return a == b == c == d == e == f == g == h == j == 0.0


def measured(covariance: Array, i: int) -> bool:
    """Say whether something measures what this is the covariance of."""
    return not covariance[i, 0] < 0.0


def usable(imu: ImuColumns, i: int) -> bool:
    """Say whether all that a row measures can be used, as `checks` has it."""
    if measured(imu.force_covariance, i) and not (
        is_measurable(vector(imu.force, i)) and is_covariance(matrix(imu.force_covariance, i))
    ):
        return False
    if measured(imu.rate_covariance, i) and not (
        is_measurable(vector(imu.rate, i)) and is_covariance(matrix(imu.rate_covariance, i))
    ):
        return False
    return not measured(imu.orientation_covariance, i) or is_covariance(
        matrix(imu.orientation_covariance, i)
    )
