"""A body that does not move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import NO_STEPS, Array, Kinematics, kinematics


@dataclass(frozen=True, kw_only=True)
class RestSettings(Settings, prefix='driver.rest'):
    """Where the body rests."""

    position: tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.0), 'Where it rests', unit='m', length=3
    )


class Rest:
    """A body that does not move."""

    Settings: ClassVar[type[Settings]] = RestSettings
    duration = 0.0
    steps = NO_STEPS

    def __init__(self, settings: RestSettings) -> None:
        self._position = np.array(settings.position)

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        nothing = np.zeros((len(time), 3))
        return kinematics(nothing + self._position, nothing, nothing)


MOTION = Rest
