"""Look for rest in force and, where a gyro matters, in rate of turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from dead_reckoning.core.errors import NotAtRestError
from dead_reckoning.core.rest import Rest, RestWindow
from dead_reckoning.core.samples import ImuSample


@dataclass(frozen=True, slots=True, eq=False)
class Stillness:
    """A stretch of rest: the specific force [m/s²] and, with a gyro, the rate of turn [rad/s]."""

    force: Rest
    rate: Rest | None


class RestRules(Protocol):
    """Settings that say how long a rest is [s], and how still [m/s², rad/s]."""

    @property
    def rest_duration(self) -> float: ...  # noqa: D102
    @property
    def rest_deviation(self) -> float: ...  # noqa: D102
    @property
    def rest_rate_deviation(self) -> float: ...  # noqa: D102


class RestSearch:
    """Fill one window after the other until one shows rest."""

    def __init__(self, settings: RestRules, with_rate: bool) -> None:
        self._force = RestWindow(settings.rest_duration, settings.rest_deviation)
        self._rate: RestWindow | None = None
        if with_rate:
            self._rate = RestWindow(
                settings.rest_duration, settings.rest_rate_deviation, unit='rad/s'
            )

    def add(self, imu: ImuSample) -> Stillness | None:
        """Take one sample; return what a full window at rest showed, None before.

        Raises `NotAtRestError` when the full window varied too much; the next sample begins anew.
        """
        turned: NotAtRestError | None = None
        rate: Rest | None = None
        if self._rate is not None and imu.angular_velocity is not None:
            try:
                rate = self._rate.add(imu.stamp_ns, imu.angular_velocity)
            except NotAtRestError as error:
                turned = error  # both windows are full at once, and both must begin anew
        force = self._force.add(imu.stamp_ns, imu.specific_force)
        if turned is not None:
            raise turned
        return None if force is None else Stillness(force, rate)
