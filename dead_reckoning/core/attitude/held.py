"""Hold the tilt that gravity showed at rest; yaw comes from the compass, where there is one."""

from __future__ import annotations

from math import degrees

from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.compass_yaw import CompassYaw
from dead_reckoning.core.rest import level_variances
from dead_reckoning.core.rest_search import Stillness
from dead_reckoning.core.rotation import euler_from_gravity, isotropic, quaternion_from_euler
from dead_reckoning.core.samples import ImuSample, Matrix, Quaternion, Vector


class HeldAttitude:
    """Keep roll and pitch from the first rest on; yaw is that of the compass, or 0.

    The tilt is known to `common.attitude_deviation` and to what the rest showed of it, a yaw of 0
    to the former; the yaw of a compass as well as its message says (`CompassYaw`).
    """

    def __init__(self, common: CommonSettings, compass: CompassYaw) -> None:
        self._compass = compass
        self._unaided = isotropic(common.attitude_deviation)
        self.reset()

    def reset(self) -> None:
        """Forget the attitude."""
        self.attitude: Quaternion | None = None
        """Takes the sensor into the world; None before the first rest."""
        self.covariance: Matrix = self._unaided
        """Of the attitude, shape (3, 3) [rad²], about the axes of the world."""
        self._tilt = (0.0, 0.0)
        self._tilt_variance = self._unaided[0]
        self._yaw: tuple[float, float] | None = None

    def require(self, imu: ImuSample) -> None:
        """Take any sample."""

    def level(self, still: Stillness, stamp_ns: int) -> str:
        """Take roll and pitch from a rest; return them in words."""
        self._tilt = roll, pitch = euler_from_gravity(still.force.mean)
        self._tilt_variance = self._unaided[0] + level_variances(still.force)[1]
        self._yaw = self._compass.at(stamp_ns)
        self._set()
        return f'roll {degrees(roll):.3f}°, pitch {degrees(pitch):.3f}°'

    def advance(self, imu: ImuSample, step_ns: int | None) -> None:
        """Carry the attitude on to a sample."""
        yaw = self._compass.at(imu.stamp_ns)
        if self.attitude is not None and yaw != self._yaw:
            self._yaw = yaw
            self._set()

    def rate(self, imu: ImuSample) -> tuple[Vector | None, Matrix]:
        """Return what the sample says."""
        return imu.angular_velocity, imu.angular_velocity_covariance

    def follow_compass(self, stamp_ns: int) -> None:
        """Leave it to the next sample."""

    def _set(self) -> None:
        yaw, variance = self._yaw or (0.0, self._unaided[8])
        self.attitude = quaternion_from_euler(*self._tilt, yaw)
        tilt = self._tilt_variance
        self.covariance = (tilt, 0.0, 0.0, 0.0, tilt, 0.0, 0.0, 0.0, variance)
