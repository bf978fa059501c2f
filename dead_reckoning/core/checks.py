"""Refuse what no estimator can use, before it changes anything."""

from __future__ import annotations

from functools import lru_cache
from math import isfinite

from dead_reckoning.core.errors import MissingAccelerationError, NotFiniteError
from dead_reckoning.core.samples import ImuSample, LinearAcceleration, Matrix, Vector

LARGEST = 1e6
"""Magnitude [SI] beyond which a force or a rate is no measurement; its powers stay finite."""

LARGEST_VARIANCE = 1e12
"""Variance [SI²] beyond which a covariance drowns all others in rounding."""

CORRELATION = 1.01
"""Square of a correlation that is still taken for a rounded 1."""


def require_vector(vector: Vector, name: str, remedy: str = 'check the driver') -> None:
    """Raise `NotFiniteError` for a vector, shape (3,), that nothing can have measured."""
    if not is_measurable(vector):
        raise NotFiniteError(f'the {name} is {vector}: {remedy}')


def is_measurable(vector: Vector) -> bool:
    """Say whether something can have measured a vector, shape (3,)."""
    x, y, z = vector
    low, high = -LARGEST, LARGEST
    return low <= x <= high and low <= y <= high and low <= z <= high  # NaN is not


@lru_cache(maxsize=64)  # drivers send the same one with each sample
def require_covariance(covariance: Matrix, name: str) -> None:
    """Raise `NotFiniteError` for what is no covariance, shape (3, 3): one would stay for good.

    That is one with NaN, an infinity, a variance that is negative or beyond `LARGEST_VARIANCE`, or
    a correlation beyond 1.
    """
    if is_covariance(covariance):
        return
    raise NotFiniteError(
        f'the covariance of the {name} is {covariance}, which is none: check the driver; zeros '
        'mean that it is unknown, a first -1 that nothing is measured'
    )


def is_covariance(covariance: Matrix) -> bool:
    """Say whether a matrix, shape (3, 3), can be a covariance."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = covariance
    return (
        0.0 <= xx <= LARGEST_VARIANCE
        and 0.0 <= yy <= LARGEST_VARIANCE
        and 0.0 <= zz <= LARGEST_VARIANCE
        and isfinite(xy + xz + yx + yz + zx + zy)
        and max(xy * xy, yx * yx) <= CORRELATION * xx * yy
        and max(xz * xz, zx * zx) <= CORRELATION * xx * zz
        and max(yz * yz, zy * zy) <= CORRELATION * yy * zz
    )


def require_acceleration(acceleration: LinearAcceleration) -> None:
    """Raise `NotFiniteError` where an acceleration, or its vertical variance, can't be used."""
    require_vector(acceleration.acceleration, 'linear acceleration')
    if not isfinite(acceleration.covariance[8]):
        raise NotFiniteError(
            f'the covariance of the linear acceleration is {acceleration.covariance}, which is '
            'none: check where it comes from; zeros mean that it is unknown'
        )


def require_force(imu: ImuSample) -> None:
    """Raise `SampleError` where the specific force is not measured, or can't be."""
    if not is_measurable(imu.specific_force):  # one call fewer than `require_vector` as a rule
        require_vector(imu.specific_force, 'specific force')
    if imu.specific_force_covariance[0] < 0.0:
        raise MissingAccelerationError(
            'linear_acceleration_covariance[0] is -1, so this Imu measures no acceleration: '
            'subscribe to the topic of an accelerometer'
        )


def require_covariances(imu: ImuSample) -> None:
    """Raise `NotFiniteError` for a covariance of force or orientation that is none."""
    if not imu.specific_force_covariance[0] < 0.0:  # else another device measured the force
        require_covariance(imu.specific_force_covariance, 'specific force')
    if imu.orientation is not None:
        require_covariance(imu.orientation_covariance, 'orientation')


def require_rate(imu: ImuSample) -> None:
    """Raise `NotFiniteError` for an angular velocity, or its covariance, that can't be used.

    An Imu without one passes.
    """
    if imu.angular_velocity is not None:
        require_vector(
            imu.angular_velocity,
            'angular velocity',
            'check the driver; where there is no gyro, set angular_velocity_covariance[0] to -1',
        )
        require_covariance(imu.angular_velocity_covariance, 'angular velocity')
