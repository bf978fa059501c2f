"""Refuse what no estimator can use, before it changes anything."""

from __future__ import annotations

from math import isfinite

from dead_reckoning.core.errors import NotFiniteError
from dead_reckoning.core.samples import ImuSample


def require_finite_covariances(imu: ImuSample) -> None:
    """Raise `NotFiniteError` where a covariance of force or attitude holds NaN or an infinity.

    One such sample would stay in the covariance of a state for good.
    """
    for covariance in (imu.specific_force_covariance, imu.orientation_covariance):
        if not isfinite(sum(covariance)):
            raise NotFiniteError(f'a covariance is {covariance}: check the driver')
