"""Refuse what no estimator can use, before it changes anything."""

from __future__ import annotations

from math import isfinite

from dead_reckoning.core.errors import NotFiniteError
from dead_reckoning.core.samples import ImuSample


def require_finite(imu: ImuSample) -> None:
    """Raise `NotFiniteError` where a covariance or the angular velocity holds NaN or an infinity.

    One such covariance would stay in that of a state for good; the angular velocity is handed on
    to the state.
    """
    for what, covariance in (
        ('specific force', imu.specific_force_covariance),
        ('orientation', imu.orientation_covariance),
        ('angular velocity', imu.angular_velocity_covariance),
    ):
        if not isfinite(sum(covariance)):
            raise NotFiniteError(f'the covariance of the {what} is {covariance}: check the driver')
    rate = imu.angular_velocity
    if rate is not None and not isfinite(sum(rate)):
        raise NotFiniteError(
            f'the angular velocity is {rate}: check the driver; what is not measured has −1 as '
            'angular_velocity_covariance[0]'
        )
