"""Where gravity removal takes the attitude from, a file each, behind one interface."""

from __future__ import annotations

from typing import Protocol

from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.compass_yaw import CompassYaw
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest_search import Stillness
from dead_reckoning.core.samples import ImuSample, Matrix, Quaternion, Vector


class AttitudeSource(Protocol):
    """Know the attitude at each sample.

    `GravityRemoval` asks `require` whether a sample will do, gives it to `advance`, and takes
    `attitude` and `covariance`; a rest that it finds goes to `level`.
    """

    @property
    def attitude(self) -> Quaternion | None:
        """Takes the sensor into the world; None while it is not known."""

    @property
    def covariance(self) -> Matrix:
        """Of the attitude, shape (3, 3) [rad²], about the axes of the world."""

    def reset(self) -> None:
        """Forget the attitude."""

    def require(self, imu: ImuSample) -> None:
        """Raise `SampleError` where a sample is of no use; change nothing."""

    def advance(self, imu: ImuSample, step_ns: int | None) -> None:
        """Carry the attitude on to a sample, ``step_ns`` [ns] after the last one, if any."""

    def level(self, still: Stillness, stamp_ns: int) -> str:
        """Learn from a rest; return in words what it showed.

        Raises `CalibrationError` where it can't have been one.
        """

    def rate(self, imu: ImuSample) -> tuple[Vector | None, Matrix]:
        """Return the rate of turn of a sample and its covariance, as well as they are known."""

    def follow_compass(self, stamp_ns: int) -> None:
        """Take note that the compass has a new yaw."""


def attitude_source(
    settings: GravitySettings, common: CommonSettings, compass: CompassYaw
) -> AttitudeSource:
    """Return the source that the settings name."""
    if settings.attitude == 'message':
        from dead_reckoning.core.attitude.message import MessageAttitude

        return MessageAttitude(common)
    if settings.attitude == 'estimate':
        from dead_reckoning.core.attitude.estimated import EstimatedAttitude

        return EstimatedAttitude(settings, common, compass)
    from dead_reckoning.core.attitude.held import HeldAttitude

    return HeldAttitude(common, compass)
