"""A ride in a lift: up, and down again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import NO_STEPS, Array, Kinematics, kinematics
from dead_reckoning.sources.paths import ramp


@dataclass(frozen=True, kw_only=True)
class LiftSettings(Settings, prefix='driver.lift'):
    """A ride in a lift."""

    height: float = parameter(
        3.0, 'How high it goes; negative goes down', unit='m', minimum=-1000.0, maximum=1000.0
    )
    speed: float = parameter(1.0, 'Speed on the way', unit='m/s', minimum=0.01, maximum=100.0)
    ramp: float = parameter(
        1.2, 'Time to speed up and to slow down', unit='s', minimum=0.01, maximum=100.0
    )
    start: float = parameter(3.0, 'Rest before it', unit='s', minimum=0.0, maximum=1000.0)


class Lift:
    """Speed up, ride, slow down, along z."""

    Settings: ClassVar[type[Settings]] = LiftSettings
    steps = NO_STEPS

    def __init__(self, settings: LiftSettings) -> None:
        self._path = ramp(0.0, settings.height, settings.speed, settings.ramp, settings.start)
        self.duration = float(self._path.times[-1])

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        up = np.array([0.0, 0.0, 1.0])
        return kinematics(*(part * up for part in self._path.at(time)))


MOTION = Lift
