"""Keep the latest yaw of a compass, and say how far it can be believed."""

from __future__ import annotations

from dead_reckoning.core.checks import LARGEST_VARIANCE
from dead_reckoning.core.errors import MissingAttitudeError, NotFiniteError
from dead_reckoning.core.rotation import normalized, yaw_from_quaternion
from dead_reckoning.core.samples import NANOSECONDS, UNKNOWN, ImuSample
from dead_reckoning.core.stamps import RESTART_NS, Timeline


class CompassYaw:
    """Hold each yaw until the next one comes.

    Between two messages the yaw is not interpolated, which would have to wait for the second, and
    not extrapolated, which would double the noise.  For ``timeout`` [s] it is as good as its
    message says; after that its deviation grows by ``turn_deviation`` [rad/s].  A stale or late
    message is refused; stamps that go back by more than 1 s start anew.
    """

    def __init__(self, timeout: float, turn_deviation: float, deviation: float) -> None:
        """``deviation`` [rad] stands in for a variance that a message does not give."""
        self._timeout = timeout
        self._turn_deviation = turn_deviation
        self._fallback = deviation**2
        self.reset()

    def reset(self) -> None:
        """Forget the yaw."""
        self._timeline = Timeline()
        self._last: tuple[int, float, float] | None = None
        self.interval: float | None = None
        """Time between the last two messages [s]; None while there is only one."""

    def take(self, imu: ImuSample) -> None:
        """Take a message, an Imu with an orientation.

        Raises `SampleError`, and then the last yaw stays.
        """
        if imu.orientation is None:
            raise MissingAttitudeError(
                'compass/data carries no orientation: its yaw is all that is taken from it'
            )
        covariance = imu.orientation_covariance
        yaw = yaw_from_quaternion(normalized(imu.orientation))
        variance = self._fallback if covariance == UNKNOWN else covariance[8]
        if not 0.0 <= variance <= LARGEST_VARIANCE:  # NaN too
            raise NotFiniteError(f'the variance of the yaw is {variance}: check the compass')
        step_ns = self._timeline.advance(imu.stamp_ns)
        self.interval = None if step_ns is None else step_ns / NANOSECONDS
        self._last = (imu.stamp_ns, yaw, variance)

    def age(self, stamp_ns: int) -> float | None:
        """Return how old the yaw is at a stamp [s]; None where there is none of this run."""
        if self._last is None or self._last[0] - stamp_ns > RESTART_NS:
            return None  # a yaw from the future is one from before the stamps went back
        return max(0, stamp_ns - self._last[0]) / NANOSECONDS

    def stale(self, stamp_ns: int) -> bool:
        """Say whether there was a yaw, and it is older than the timeout."""
        age = self.age(stamp_ns)
        return age is not None and age > self._timeout

    def at(self, stamp_ns: int) -> tuple[float, float] | None:
        """Return yaw [rad] and variance [rad²] at a stamp; None without a compass."""
        age = self.age(stamp_ns)
        if self._last is None or age is None:
            return None
        _, yaw, variance = self._last
        grown = self._turn_deviation * max(0.0, age - self._timeout)
        return yaw, variance + grown * grown
