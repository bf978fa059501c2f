"""Take the attitude that a message carries."""

from __future__ import annotations

from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import MissingAttitudeError
from dead_reckoning.core.rest_search import Stillness
from dead_reckoning.core.rotation import isotropic, normalized
from dead_reckoning.core.samples import UNKNOWN, ImuSample, Matrix, Quaternion, Vector


class MessageAttitude:
    """Hand on orientation and covariance of each Imu.

    An unknown covariance is replaced by that of `common.attitude_deviation`.
    """

    def __init__(self, common: CommonSettings) -> None:
        self._fallback = isotropic(common.attitude_deviation)
        self.reset()

    def reset(self) -> None:
        """Forget the attitude."""
        self.attitude: Quaternion | None = None
        """Takes the sensor into the world."""
        self.covariance: Matrix = self._fallback
        """Of the attitude, shape (3, 3) [rad²], about the axes of the world."""

    def require(self, imu: ImuSample) -> None:
        """Raise `SampleError` where a sample is of no use."""
        if imu.orientation is None:
            raise MissingAttitudeError(
                'the Imu carries no orientation, and gravity.attitude is message: take a topic '
                'that has one, or set gravity.attitude to rest or estimate'
            )
        normalized(imu.orientation)

    def level(self, still: Stillness, stamp_ns: int) -> str:
        """Learn nothing: the message says it all."""
        return ''

    def advance(self, imu: ImuSample, step_ns: int | None) -> None:
        """Take the attitude of a sample."""
        assert imu.orientation is not None
        self.attitude = normalized(imu.orientation)
        covariance = imu.orientation_covariance
        self.covariance = self._fallback if covariance == UNKNOWN else covariance

    def rate(self, imu: ImuSample) -> tuple[Vector | None, Matrix]:
        """Return what the sample says."""
        return imu.angular_velocity, imu.angular_velocity_covariance

    def follow_compass(self, stamp_ns: int) -> None:
        """Ignore it: the message knows better."""
