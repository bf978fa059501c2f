"""A walk with the sensor on the foot: stance, swing, stance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import Array, Kinematics, Steps, kinematics
from dead_reckoning.sources.paths import Path


@dataclass(frozen=True, kw_only=True)
class GaitSettings(Settings, prefix='driver.gait'):
    """Strides of one foot, with the sensor on its instep."""

    strides: int = parameter(20, 'Number of strides', minimum=1, maximum=1_000_000)
    stride_length: float = parameter(
        1.4, 'From stance to stance of this foot', unit='m', minimum=0.0, maximum=5.0
    )
    stride_time: float = parameter(
        1.1, 'From stance to stance', unit='s', minimum=0.3, maximum=10.0
    )
    stance: float = parameter(
        0.35, 'Part of a stride in which the foot stands still', minimum=0.05, maximum=0.95
    )
    clearance: float = parameter(
        0.14, 'How high the foot swings', unit='m', minimum=0.0, maximum=1.0
    )
    pitch: float = parameter(
        1.2, 'How far the toe points down after it leaves', unit='rad', minimum=0.0, maximum=1.4
    )
    shock: float = parameter(
        20.0, 'Jolt of the landing, back and up', unit='m/s²', minimum=0.0, maximum=1000.0
    )
    rise: float = parameter(
        0.0, 'Height won with each stride: stairs and ramps', unit='m', minimum=-1.0, maximum=1.0
    )
    turn: float = parameter(
        0.0, 'Turn to the left with each stride', unit='rad', minimum=-3.2, maximum=3.2
    )
    start: float = parameter(3.0, 'Rest before it', unit='s', minimum=0.0, maximum=1000.0)


SWING = np.array(
    [
        # way, sideways, height, roll, pitch, yaw at each tenth of the swing
        [0.000, 0.000, 0.00, 0.00, 0.00, 0.00],
        [0.004, 0.000, 0.08, 0.00, 0.12, 0.00],
        [0.024, 0.001, 0.32, -0.18, 0.47, 0.00],
        [0.096, 0.011, 0.85, -0.29, 0.94, -0.09],
        [0.233, 0.022, 0.97, -0.13, 0.83, -0.02],
        [0.414, 0.031, 0.64, 0.07, 0.47, 0.06],
        [0.626, 0.033, 0.21, 0.09, 0.10, 0.08],
        [0.836, 0.022, 0.12, 0.00, -0.22, 0.07],
        [0.964, 0.008, 0.22, -0.07, -0.39, 0.04],
        [0.992, 0.000, 0.07, 0.00, -0.17, 0.01],
        [1.000, 0.000, 0.00, 0.00, 0.00, 0.00],
    ]
)
"""Knots of a swing: way and sideways as parts of the stride's length, height of the clearance,
angles of the toe-down pitch.

They are medians over 53 strides of two feet, measured by cameras: the middle between heel and
ball, from the example data of gaitmap (MIT; Küderle et al. 2024, doi:10.1109/OJEMB.2024.3356791).
"""

LANDING = 0.8
"""Part of the swing after which the heel lands."""

SHOCK_TIME = 0.012
"""Half of the time that the jolt of the landing takes [s], unless the swing is very short."""


class Gait:
    """The left foot stands, rolls off over its toe, swings forward, lands on its heel and stands.

    In stance it neither moves nor turns, so each stance is exactly where the one before ends.
    Between stances it takes the way of least jerk through the knots of `SWING`; the jolt of the
    landing is a dip of ``−(1 − u²)⁴`` in it.  ``steps`` holds the strides of this foot.
    """

    Settings: ClassVar[type[Settings]] = GaitSettings

    def __init__(self, settings: GaitSettings) -> None:
        count = settings.strides
        self._settings = settings
        self._swing_time = (1.0 - settings.stance) * settings.stride_time
        yaw = settings.turn * np.arange(count + 1, dtype=np.float64)
        middle = 0.5 * (yaw[:-1] + yaw[1:])
        strides = np.column_stack(
            [
                settings.stride_length * np.cos(middle),
                settings.stride_length * np.sin(middle),
                np.full(count, settings.rise),
            ]
        )
        self._ahead: Array = np.column_stack([np.cos(middle), np.sin(middle), np.zeros(count)])
        self._left: Array = np.column_stack([-np.sin(middle), np.cos(middle), np.zeros(count)])
        self._feet: Array = np.concatenate((np.zeros((1, 3)), np.cumsum(strides, axis=0)))
        self._yaw: Array = yaw
        self._swing = Path.of_least_jerk(np.linspace(0.0, 1.0, len(SWING)).tolist(), SWING)
        self._shock_time = min(SHOCK_TIME, 0.1 * self._swing_time)
        begin = settings.start + settings.stride_time * np.arange(count, dtype=np.float64)
        self.duration = float(begin[-1]) + self._swing_time
        self.steps = Steps(
            begin + LANDING * self._swing_time,
            np.full(count, float(np.hypot(settings.stride_length, settings.rise))),
        )

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        settings = self._settings
        since = time - settings.start
        stride = np.floor(since / settings.stride_time).astype(int)
        stride = np.clip(stride, 0, settings.strides - 1)
        within = since - stride * settings.stride_time
        parts = self._swing.at(within / self._swing_time)
        jolts = self._jolt(within - LANDING * self._swing_time)
        place: list[Array] = []
        angles: list[Array] = []
        for order, (part, jolt) in enumerate(zip(parts, jolts, strict=True)):
            part = part / self._swing_time**order
            place.append(self._place(stride, part, jolt))
            angles.append(settings.pitch * part[:, 3:])
            angles[order][:, 2] += settings.turn * part[:, 0]
        place[0] += self._feet[stride]
        angles[0][:, 2] += self._yaw[stride]
        return kinematics(place[0], place[1], place[2], angles[0], angles[1])

    def _place(self, stride: NDArray[np.int_], part: Array, jolt: Array) -> Array:
        """Return where the foot is against its last stance, or a derivative of that."""
        settings = self._settings
        way, side, height = part[:, 0], part[:, 1], part[:, 2]
        ahead = settings.stride_length * way - 0.6 * jolt
        up = settings.rise * way + (settings.clearance + max(settings.rise, 0.0)) * height
        place: Array = self._ahead[stride] * ahead[:, None]
        place += self._left[stride] * (settings.stride_length * side)[:, None]
        place[:, 2] = up + 0.8 * jolt
        return place

    def _jolt(self, since: Array) -> tuple[Array, Array, Array]:
        """Return the dip of the landing [m] and two derivatives, at times since it [s]."""
        u = np.clip(since / self._shock_time, -1.0, 1.0)
        depth = self._settings.shock * self._shock_time**2 / 8.0
        w = 1.0 - u**2
        return (
            -depth * w**4,
            depth * 8.0 * u * w**3 / self._shock_time,
            depth * (8.0 * w**3 - 48.0 * u**2 * w**2) / self._shock_time**2,
        )


MOTION = Gait
