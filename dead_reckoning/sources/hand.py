"""A hand on the body: what its tremor and its sway add to a motion, with exact truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import Array, Kinematics, Motion, Steps
from dead_reckoning.sources.paths import Path


@dataclass(frozen=True, kw_only=True)
class HandSettings(Settings, prefix='driver.hand'):
    """A hand that holds or pushes the body, and cannot keep still."""

    enabled: bool = parameter(False, 'Whether there is one')
    tremor: float = parameter(
        0.07, 'Its tremor between 6 and 12 Hz: acceleration along an axis, one sigma',
        unit='m/s²', minimum=0.0, maximum=100.0,
    )  # fmt: skip
    sway: float = parameter(
        0.001, 'Its sway between 0.1 and 0.5 Hz: way along an axis, one sigma',
        unit='m', minimum=0.0, maximum=1.0,
    )  # fmt: skip
    release: float = parameter(
        1e6, 'When it lets go; the body then comes to rest within half a second',
        unit='s', minimum=1.0, maximum=1e6,
    )  # fmt: skip


TREMOR = (6.0, 12.0)
"""Band of the tremor [Hz]."""

SWAY = (0.1, 0.5)
"""Band of the sway [Hz]."""

WAVES = 5
"""Sine waves of each band; every axis has phases of its own."""

FADE = 0.5
"""Time in which the hand takes hold at the start, and lets go [s]."""


class Held:
    """Add to a motion what a hand does, along the axes of the table; it turns nothing.

    Tremor and sway are sums of sine waves of random frequency and phase, equal in acceleration
    (tremor) or way (sway), so the truth stays exact.  A healthy hand held out trembles with
    0.015 to 0.35 m/s² at its dominant frequency, most often 0.1 m/s², which is one sigma of 0.07,
    at about 7 Hz (97 subjects; Arch Neurol 39(6), 1982,
    doi:10.1001/archneur.1982.00510180036009); the peak is between 6 and 12 Hz (Lakie et al. 2015,
    doi:10.1113/JP270464).  The sway is a choice, no measurement.
    """

    Settings: ClassVar[type[Settings]] = HandSettings

    def __init__(self, motion: Motion, settings: HandSettings, seed: int) -> None:
        """``seed`` draws frequencies and phases."""
        self._motion = motion
        self._hold = Path(
            [0.0, FADE, settings.release, settings.release + FADE], [[0.0], [1.0], [1.0], [0.0]]
        )
        random = np.random.default_rng([seed, 1])
        tremor, sway = (2.0 * np.pi * random.uniform(*band, WAVES) for band in (TREMOR, SWAY))
        self._rate: Array = np.concatenate((tremor, sway))
        sizes = (settings.tremor / tremor**2, np.full(WAVES, settings.sway))
        size = np.sqrt(2.0 / WAVES) * np.concatenate(sizes)[:, None]
        phase = random.uniform(0.0, 2.0 * np.pi, (2 * WAVES, 3))
        # sin(ωt + φ) = sin ωt cos φ + cos ωt sin φ: what each axis takes of the waves.
        self._of_sine: Array = size * np.cos(phase)
        self._of_cosine: Array = size * np.sin(phase)
        self.duration = max(motion.duration, settings.release + FADE)

    @property
    def steps(self) -> Steps:
        """The steps of the motion."""
        return self._motion.steps

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        truth = self._motion.at(time)
        angle = time[:, None] * self._rate
        sine, cosine = np.sin(angle), np.cos(angle)
        way = sine @ self._of_sine + cosine @ self._of_cosine
        sine, cosine = -self._rate * sine, self._rate * cosine
        speed = cosine @ self._of_sine + sine @ self._of_cosine
        push = (self._rate * sine) @ self._of_sine - (self._rate * cosine) @ self._of_cosine
        hold, grip, jerk = self._hold.at(time)
        return Kinematics(
            truth.position + hold * way,
            truth.velocity + hold * speed + grip * way,
            truth.acceleration + hold * push + 2.0 * grip * speed + jerk * way,
            truth.euler,
            truth.euler_rate,
        )
