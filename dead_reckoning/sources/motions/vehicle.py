"""A vehicle that drives a figure of eight, with stops."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import NO_STEPS, Array, Kinematics, kinematics
from dead_reckoning.sources.paths import Path


@dataclass(frozen=True, kw_only=True)
class VehicleSettings(Settings, prefix='driver.vehicle'):
    """A figure of eight, nose ahead, with stops on the way."""

    length: float = parameter(
        40.0, 'From end to end of the eight', unit='m', minimum=1.0, maximum=10_000.0
    )
    width: float = parameter(20.0, 'Width of its loops', unit='m', minimum=0.5, maximum=10_000.0)
    loops: int = parameter(2, 'How often the eight is driven', minimum=1, maximum=10_000)
    loop_time: float = parameter(
        40.0, 'How long an eight takes, stops left out', unit='s', minimum=1.0, maximum=100_000.0
    )
    stops: int = parameter(3, 'Stops in each eight', minimum=1, maximum=100)
    pause: float = parameter(4.0, 'How long a stop is', unit='s', minimum=0.1, maximum=10_000.0)
    start: float = parameter(3.0, 'Rest before it', unit='s', minimum=0.0, maximum=1000.0)


class Vehicle:
    """Drive ``(½·length·sin u, ½·width·sin 2u)``, u running from stop to stop with least jerk.

    The body faces the way it drives (no slip), so velocity lies along its x axis.
    """

    Settings: ClassVar[type[Settings]] = VehicleSettings
    steps = NO_STEPS

    def __init__(self, settings: VehicleSettings) -> None:
        legs = settings.loops * settings.stops
        leg_time = settings.loop_time / settings.stops
        begin = settings.start + (leg_time + settings.pause) * np.arange(legs)
        ends = 2.0 * np.pi / settings.stops * np.arange(legs + 1)
        times = np.column_stack([begin, begin + leg_time]).ravel()
        values = np.column_stack([ends[:-1], ends[1:]]).ravel()
        self._path = Path(times.tolist(), values[:, None])
        self.duration = float(times[-1])
        self._size = 0.5 * settings.length, 0.5 * settings.width

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        u, rate, push = (part[:, 0] for part in self._path.at(time))
        a, b = self._size
        nothing = np.zeros_like(u)
        x, dx, ddx = a * np.sin(u), a * np.cos(u), -a * np.sin(u)
        y, dy, ddy = b * np.sin(2 * u), 2 * b * np.cos(2 * u), -4 * b * np.sin(2 * u)
        yaw = np.arctan2(dy, dx)
        yaw_rate = (dx * ddy - dy * ddx) / (dx**2 + dy**2) * rate
        return kinematics(
            np.column_stack([x, y, nothing]),
            np.column_stack([dx * rate, dy * rate, nothing]),
            np.column_stack([ddx * rate**2 + dx * push, ddy * rate**2 + dy * push, nothing]),
            np.column_stack([nothing, nothing, yaw]),
            np.column_stack([nothing, nothing, yaw_rate]),
        )


MOTION = Vehicle
