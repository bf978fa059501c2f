"""A sensor on a turning table, on its axis or beside it."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import ClassVar

import numpy as np

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import NO_STEPS, Array, Kinematics, kinematics
from dead_reckoning.sources.paths import ramp


@dataclass(frozen=True, kw_only=True)
class TurntableSettings(Settings, prefix='driver.turntable'):
    """A turn of the table, left-hand about z."""

    angle: float = parameter(
        radians(360.0), 'How far it turns; negative turns right', unit='rad',
        minimum=-1000.0, maximum=1000.0,
    )  # fmt: skip
    rate: float = parameter(
        radians(90.0), 'How fast it turns', unit='rad/s', minimum=0.001, maximum=100.0
    )
    ramp: float = parameter(
        0.5, 'Time to speed up and to slow down', unit='s', minimum=0.01, maximum=100.0
    )
    radius: float = parameter(
        0.1, 'From the axis to the sensor, which faces along the circle', unit='m',
        minimum=0.0, maximum=100.0,
    )  # fmt: skip
    start: float = parameter(3.0, 'Rest before it', unit='s', minimum=0.0, maximum=1000.0)


class Turntable:
    """Turn about z at a constant rate, with smooth ramps; the sensor starts at the origin."""

    Settings: ClassVar[type[Settings]] = TurntableSettings
    steps = NO_STEPS

    def __init__(self, settings: TurntableSettings) -> None:
        self._radius = settings.radius
        self._path = ramp(0.0, settings.angle, settings.rate, settings.ramp, settings.start)
        self.duration = float(self._path.times[-1])

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        angle, rate, push = self._path.at(time)
        nothing = np.zeros_like(angle)
        ahead = np.hstack([np.cos(angle), np.sin(angle), nothing])
        inward = np.hstack([-np.sin(angle), np.cos(angle), nothing])
        r = self._radius
        return kinematics(
            r * (np.array([0.0, 1.0, 0.0]) - inward),
            r * rate * ahead,
            r * (push * ahead + rate**2 * inward),
            np.hstack([nothing, nothing, angle]),
            np.hstack([nothing, nothing, rate]),
        )


MOTION = Turntable
