"""A square in the plane, with a rest at each corner: AN3397's mouse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import NO_STEPS, Array, Kinematics, kinematics
from dead_reckoning.sources.paths import Path


@dataclass(frozen=True, kw_only=True)
class SquareSettings(Settings, prefix='driver.square'):
    """A square: four slides, +x, +y, −x, −y, back to where it began."""

    side: float = parameter(0.3, 'Length of a side', unit='m', minimum=0.001, maximum=1000.0)
    side_duration: float = parameter(
        0.8, 'How long a side takes', unit='s', minimum=0.01, maximum=1000.0
    )
    pause: float = parameter(0.7, 'Rest at each corner', unit='s', minimum=0.0, maximum=1000.0)
    start: float = parameter(3.0, 'Rest before it', unit='s', minimum=0.0, maximum=1000.0)


class Square:
    """Four slides of least jerk."""

    Settings: ClassVar[type[Settings]] = SquareSettings
    steps = NO_STEPS

    def __init__(self, settings: SquareSettings) -> None:
        corners = settings.side * np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]])
        begin = settings.start + (settings.side_duration + settings.pause) * np.arange(4)
        times = np.column_stack([begin, begin + settings.side_duration]).ravel()
        values = np.column_stack([corners[:-1], corners[1:]]).reshape(-1, 3)
        if settings.pause == 0.0:
            keep = [0, 1, 3, 5, 7]
            times, values = times[keep], values[keep]
        self.duration = float(times[-1])
        self._path = Path(times.tolist(), values)

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        return kinematics(*self._path.at(time))


MOTION = Square
