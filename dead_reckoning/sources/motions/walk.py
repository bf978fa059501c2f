"""A walk with the sensor on the trunk: belt, pocket or hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import Array, Kinematics, Steps, kinematics
from dead_reckoning.sources.paths import crossing_times, ramp


@dataclass(frozen=True, kw_only=True)
class WalkSettings(Settings, prefix='driver.walk'):
    """A straight walk of a number of steps."""

    steps: int = parameter(60, 'Number of steps', minimum=1, maximum=1_000_000)
    cadence: float = parameter(1.8, 'Steps per second', unit='Hz', minimum=0.3, maximum=4.0)
    step_length: float = parameter(0.7, 'Length of a step', unit='m', minimum=0.05, maximum=3.0)
    leg_length: float = parameter(
        0.9, 'From hip to ground, which sets how far the trunk bounces', unit='m',
        minimum=0.2, maximum=2.0,
    )  # fmt: skip
    heading: float = parameter(
        0.0, 'Direction of the walk, and yaw of the body', unit='rad', minimum=-7.0, maximum=7.0
    )
    roll: float = parameter(
        0.0, 'Roll of the device as it is worn; at π/2 its y axis is up, as for AN-900',
        unit='rad', minimum=-3.2, maximum=3.2,
    )  # fmt: skip
    start: float = parameter(3.0, 'Rest before it', unit='s', minimum=0.0, maximum=1000.0)

    def validate(self) -> None:
        """Raise `SettingsError` where a step is longer than the legs allow."""
        if self.step_length > 1.9 * self.leg_length:
            raise SettingsError(
                f'driver.walk.step_length: {self.step_length} m is more than 1.9 legs of '
                f'{self.leg_length} m; lengthen driver.walk.leg_length'
            )


class Walk:
    """Everything repeats with the phase φ, which counts steps; foot k lands at φ = k − ½.

    A leg that swings over like a pendulum lifts the trunk by ``ℓ − √(ℓ² − (L/2)²)`` in each step
    of length L; knees and ankles take up part of it, here two fifths, which makes 4 cm of a step
    of 0.7 m.  On it ride the shock of the landing, as a second harmonic, a sway to the side once
    in two steps, and an ebb and flow of the speed.
    """

    Settings: ClassVar[type[Settings]] = WalkSettings
    FIRMNESS = 0.6
    SHOCK = 0.12
    SWAY = 0.02
    SURGE = 0.02
    RAMP_STEPS = 1.5

    def __init__(self, settings: WalkSettings) -> None:
        self._length = settings.step_length
        leg, half = settings.leg_length, settings.step_length / 2.0
        self._bounce = self.FIRMNESS * (leg - np.sqrt(leg**2 - half**2)) / 2.0
        self._heading = settings.heading
        self._roll = settings.roll
        self._phase = ramp(
            0.0,
            float(settings.steps),
            settings.cadence,
            self.RAMP_STEPS / settings.cadence,
            settings.start,
        )
        self.duration = float(self._phase.times[-1])
        count = settings.steps
        self.steps = Steps(
            crossing_times(self._phase, (np.arange(count) + 0.5).tolist()),
            np.full(count, self._length),
        )

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        phase, rate, push = (part[:, 0] for part in self._phase.at(time))
        place, slope, curve = self._shape(phase)
        c, s = np.cos(self._heading), np.sin(self._heading)
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        euler = np.zeros((len(time), 3))
        euler[:, 0], euler[:, 2] = self._roll, self._heading
        return kinematics(
            place @ turn,
            slope * rate[:, None] @ turn,
            (curve * rate[:, None] ** 2 + slope * push[:, None]) @ turn,
            euler,
            np.zeros_like(euler),
        )

    def _shape(self, phase: Array) -> tuple[Array, Array, Array]:
        """Return the place along, beside and above the way, and two derivatives by the phase."""
        whole, half = 2.0 * np.pi * phase, np.pi * phase
        one, two, side = 2.0 * np.pi, 4.0 * np.pi, np.pi
        shock, surge = self.SHOCK * self._bounce, self.SURGE * self._length
        # Lowest when the foot lands, at φ = k − ½; the shock peaks a little after that.
        place = [
            self._length * phase + surge * np.sin(whole),
            self.SWAY * np.sin(half),
            self._bounce * (np.cos(whole) - 1.0) - shock * (np.cos(2.0 * whole) - 1.0),
        ]
        slope = [
            self._length + surge * one * np.cos(whole),
            self.SWAY * side * np.cos(half),
            -self._bounce * one * np.sin(whole) + shock * two * np.sin(2.0 * whole),
        ]
        curve = [
            -surge * one**2 * np.sin(whole),
            -self.SWAY * side**2 * np.sin(half),
            -self._bounce * one**2 * np.cos(whole) + shock * two**2 * np.cos(2.0 * whole),
        ]
        return tuple(np.column_stack(part) for part in (place, slope, curve))  # type: ignore[return-value]


MOTION = Walk
