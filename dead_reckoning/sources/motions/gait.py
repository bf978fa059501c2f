"""A walk with the sensor on the foot: stance, swing, stance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import Array, Kinematics, Steps, kinematics
from dead_reckoning.sources.paths import Path


@dataclass(frozen=True, kw_only=True)
class GaitSettings(Settings, prefix='driver.gait'):
    """Strides of one foot."""

    strides: int = parameter(20, 'Number of strides', minimum=1, maximum=100_000)
    stride_length: float = parameter(
        1.4, 'From stance to stance of this foot', unit='m', minimum=0.0, maximum=4.0
    )
    stride_time: float = parameter(
        1.1, 'From stance to stance', unit='s', minimum=0.3, maximum=10.0
    )
    stance: float = parameter(
        0.4, 'Part of a stride in which the foot stands', minimum=0.05, maximum=0.95
    )
    clearance: float = parameter(
        0.12, 'How high the foot swings', unit='m', minimum=0.0, maximum=1.0
    )
    pitch: float = parameter(
        0.7, 'How far the toe points down after it leaves', unit='rad', minimum=0.0, maximum=1.4
    )
    rise: float = parameter(
        0.0, 'Height won with each stride: stairs and ramps', unit='m', minimum=-1.0, maximum=1.0
    )
    turn: float = parameter(
        0.0, 'Turn to the left with each stride', unit='rad', minimum=-3.2, maximum=3.2
    )
    start: float = parameter(3.0, 'Rest before it', unit='s', minimum=0.0, maximum=1000.0)


class Gait:
    """The foot stands, points its toe down, swings forward, lifts the toe, lands and stands.

    Knots of a swing, as parts of its time: off (0), toe down (0.2), halfway (0.5), toe up (0.85),
    down (1); between them quintic polynomials.  The foot does not move at all in stance.
    """

    Settings: ClassVar[type[Settings]] = GaitSettings
    TOE_UP = -0.35
    """Pitch before landing, as a part of the toe-down pitch, the other way."""

    def __init__(self, settings: GaitSettings) -> None:
        count, length = settings.strides, settings.stride_length
        swing = (1.0 - settings.stance) * settings.stride_time
        begin = settings.start + settings.stride_time * np.arange(count)
        parts = np.array([0.0, 0.2, 0.5, 0.85, 1.0])
        times = (begin[:, None] + swing * parts).ravel()
        yaw = settings.turn * np.arange(count + 1)
        ahead = np.column_stack([np.cos(yaw), np.sin(yaw)])
        middle = 0.5 * (ahead[:-1] + ahead[1:])
        feet = np.zeros((count + 1, 6))
        feet[1:, :2] = np.cumsum(length * middle, axis=0)
        feet[:, 2] = settings.rise * np.arange(count + 1)
        feet[:, 5] = yaw
        values = np.empty((count, len(parts), 6))
        rates = np.zeros_like(values)
        ways = np.array([0.0, 0.06, 0.5, 0.94, 1.0])
        values[:] = feet[:-1, None] + ways[:, None] * np.diff(feet, axis=0)[:, None]
        lift = settings.clearance + max(settings.rise, 0.0)
        values[:, :, 2] += lift * np.array([0.0, 0.55, 1.0, 0.25, 0.0])
        values[:, :, 4] = settings.pitch * np.array([0.0, 1.0, 0.35, self.TOE_UP, 0.0])
        speed = np.diff(feet, axis=0) / swing
        rates[:, 1:4] = speed[:, None] * np.array([0.7, 1.75, 0.7])[:, None]
        rates[:, 1, 2] += 1.6 * lift / swing
        rates[:, 3, 2] -= 1.6 * lift / swing
        rates[:, 2, 4] = -2.2 * settings.pitch / swing
        self._path = Path(times.tolist(), values.reshape(-1, 6), rates.reshape(-1, 6))
        self.duration = float(times[-1])
        ends = np.asarray(begin + swing, dtype=np.float64)
        self.steps = Steps(ends, np.full(count, float(np.hypot(length, settings.rise))))

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        value, rate, push = self._path.at(time)
        return kinematics(value[:, :3], rate[:, :3], push[:, :3], value[:, 3:], rate[:, 3:])


MOTION = Gait
