"""A walk with the sensor on the trunk: belt, pocket or hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.rest import GRAVITY
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
    sway: float = parameter(
        0.04, 'How far the trunk rolls and turns, once in two steps', unit='rad',
        minimum=0.0, maximum=0.5,
    )  # fmt: skip
    asymmetry: float = parameter(
        0.1, 'How much harder one foot lands than the other, as a part of the bounce',
        minimum=0.0, maximum=1.0,
    )  # fmt: skip
    heading: float = parameter(0.0, 'Direction of the walk', unit='rad', minimum=-7.0, maximum=7.0)
    start: float = parameter(3.0, 'Rest before it', unit='s', minimum=0.0, maximum=1000.0)

    def validate(self) -> None:
        """Raise `SettingsError` where a step is longer than the legs allow."""
        if self.step_length > 1.9 * self.leg_length:
            raise SettingsError(
                f'driver.walk.step_length: {self.step_length} m is more than 1.9 legs of '
                f'{self.leg_length} m; lengthen driver.walk.leg_length'
            )


HARMONICS = ((1, 1.0, 0.0), (2, 0.4, -10.0), (3, 0.38, -40.0), (4, 0.18, -130.0))
"""Of the trunk's upward acceleration in each step: number, size against the first, phase [°].

They are those of a sensor on the lower back, counted from when the foot lands (example data of
mobgap, Apache-2.0; walks at 92 to 103 steps a minute).
"""

FIRMNESS = 0.6
"""Part of a pendulum's lift that knees and ankles leave."""

SIDE = 0.02
"""How far the trunk goes to each side [m]."""

SURGE = 0.02
"""How far it runs ahead and falls behind, as a part of the step length."""

FALL = 0.85
"""Largest part of gravity with which the bounce may go down."""

RAMP_STEPS = 1.5
"""How many steps' time it takes to reach the cadence, and to stop."""


class Walk:
    """Everything repeats with the phase φ, which counts steps; foot k lands at φ = k − ½.

    A leg that swings over like a pendulum lifts the trunk by ``ℓ − √(ℓ² − (L/2)²)`` in each step
    of length L; knees and ankles take up part of it, which leaves 4 cm of a step of 0.7 m.
    Nothing but gravity pulls a trunk down, so at a high cadence, running, the bounce is smaller.
    On it ride the harmonics of the landing, an ebb of the speed after each landing, and, once in
    two steps, a sway to the side, a roll and a turn; one foot lands harder than the other.
    """

    Settings: ClassVar[type[Settings]] = WalkSettings

    def __init__(self, settings: WalkSettings) -> None:
        count, cadence = settings.steps, settings.cadence
        self._phase = ramp(0.0, float(count), cadence, RAMP_STEPS / cadence, settings.start)
        self.duration = float(self._phase.times[-1])
        self.steps = Steps(
            crossing_times(self._phase, (np.arange(count) + 0.5).tolist()),
            np.full(count, settings.step_length),
        )
        self._heading = settings.heading
        self._length = settings.step_length
        # Each of shape (waves, 1), to be multiplied with moments along the second axis.
        self._waves: Array = np.array(_waves(settings)).T[:, :, None]

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        phase, rate, push = self._phase.at(time)
        channels, size, number, late = self._waves
        angle = number * phase[:, 0] + late
        sine, cosine = np.sin(angle), np.cos(angle)
        place, slope, curve = np.zeros((3, len(time), 6))
        for sums, waves in (
            (place, size * (sine - np.sin(late))),
            (slope, size * number * cosine),
            (curve, -size * number**2 * sine),
        ):
            for channel, wave in zip(channels[:, 0].astype(int), waves, strict=True):
                sums[:, channel] += wave
        place[:, 0] += self._length * phase[:, 0]
        slope[:, 0] += self._length
        place[:, 5] += self._heading
        change = slope * rate
        c, s = np.cos(self._heading), np.sin(self._heading)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        position, velocity, acceleration = (
            np.einsum('ij,nj->ni', turn, part[:, :3])
            for part in (place, change, curve * rate**2 + slope * push)
        )
        return kinematics(position, velocity, acceleration, place[:, 3:], change[:, 3:])


def _waves(settings: WalkSettings) -> list[tuple[int, float, float, float]]:
    """List what swings with the phase as ``size · (sin(number · φ + late) − sin(late))``.

    The first of each tuple is the channel: way, side, height, roll, pitch, yaw.
    """
    step, stride = 2.0 * np.pi, np.pi
    largest = FALL * GRAVITY / (step * settings.cadence) ** 2
    leg, half = settings.leg_length, settings.step_length / 2.0
    bounce = min(FIRMNESS * (leg - float(np.sqrt(leg**2 - half**2))) / 2.0, largest)
    surge = min(SURGE * settings.step_length, largest / 2.0)
    return [
        (0, -surge, step, 0.0),
        (1, SIDE, stride, 0.0),
        *(
            # Upward acceleration ~ cos(k · (step · φ + π) + late): π, as the foot lands at φ = ½.
            (2, bounce * size / k**2, k * step, np.pi * k + np.radians(late) - np.pi / 2.0)
            for k, size, late in HARMONICS
        ),
        *(
            # Added where one foot lands, taken off where the other does.
            (2, sign * settings.asymmetry * bounce / part**2, part * step, 0.0)
            for sign, part in ((-1.0, 0.5), (1.0, 1.5))
        ),
        (3, settings.sway, stride, 0.0),
        (4, settings.sway / 2.0, step, 0.0),
        (5, -settings.sway, stride, 0.0),
    ]


MOTION = Walk
