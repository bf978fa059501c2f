"""A simulated accelerometer: a motion with its exact truth, seen through the sensor's faults."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.accelerometer import AnalogAccelerometer
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import matrix_from_quaternion, quaternion_from_euler
from dead_reckoning.core.samples import NANOSECONDS, NavigationState, Vector
from dead_reckoning.sources.motions import Motion

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class SimulatedSettings(Settings, prefix='driver.simulated'):
    """What the simulated sensor suffers from, and how the table it moves on is tilted."""

    seed: int = parameter(1, 'Seed of the noise', minimum=0)
    noise: bool = parameter(True, 'Whether it has the noise that driver.noise says')
    quantise: bool = parameter(True, 'Whether the ADC rounds to whole counts')
    offset: tuple[float, float, float] = parameter(
        (0.3, -0.2, 0.4), 'Offset of x, y, z at zero g', unit='m/s²',
        minimum=-100.0, maximum=100.0, length=3,
    )  # fmt: skip
    sensitivity_error: tuple[float, float, float] = parameter(
        (0.005, -0.005, 0.005), 'Relative error of the sensitivity of x, y, z',
        minimum=-0.5, maximum=0.5, length=3,
    )  # fmt: skip
    attitude: tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.0), 'Roll, pitch and yaw of the table', unit='rad',
        minimum=-3.2, maximum=3.2, length=3,
    )  # fmt: skip


class SimulatedAccelerometer:
    """Read a sensor that moves: conversion k happens ``k / sample_rate`` after the start.

    The same settings and seed give the same counts, however they are read in pieces.
    """

    def __init__(
        self,
        settings: SimulatedSettings,
        model: AnalogAccelerometer,
        motion: Motion,
        sample_rate: float,
        start_ns: int = 0,
    ) -> None:
        """``sample_rate`` [Hz]; ``start_ns`` the stamp at which the motion begins."""
        self._settings = settings
        self._model = model
        self._motion = motion
        self._rate = sample_rate
        self._start_ns = start_ns
        self._taken = 0
        self._random = np.random.default_rng(settings.seed)
        self._quaternion = quaternion_from_euler(*settings.attitude)
        self._rot_wt: Array = np.reshape(matrix_from_quaternion(self._quaternion), (3, 3))

    def available(self, now_ns: int) -> int:
        """Return how many conversions have happened by ``now_ns`` and were not read yet."""
        happened = floor((now_ns - self._start_ns) * self._rate / NANOSECONDS) + 1
        return max(0, happened - self._taken)

    def read(self, count: int) -> Conversions:
        """Return the next ``count`` conversions."""
        index = np.arange(self._taken, self._taken + count)
        self._taken += count
        time = index / self._rate
        truth = self._motion.at(time)
        # The body keeps the attitude of the table, so the table's axes are the sensor's.
        gravity_s = self._rot_wt.T @ np.array([0.0, 0.0, GRAVITY])
        force_s = truth.acceleration + gravity_s
        settings = self._settings
        scale = 1.0 + np.array(settings.sensitivity_error)
        volts = self._model.volts(scale * force_s + np.array(settings.offset))
        if settings.noise:
            volts = volts + self._model.noise * self._random.standard_normal(volts.shape)
        counts = self._model.counts(volts, quantise=settings.quantise)
        return Conversions(self._start_ns + np.round(time * NANOSECONDS).astype(np.int64), counts)

    def truth(self, stamp_ns: int) -> NavigationState:
        """Return where the body really is at a stamp."""
        truth = self._motion.at(np.array([(stamp_ns - self._start_ns) / NANOSECONDS]))
        return NavigationState(
            stamp_ns,
            self._vector(self._rot_wt @ truth.position[0]),
            self._vector(self._rot_wt @ truth.velocity[0]),
            self._quaternion,
            stationary=not truth.velocity.any(),
        )

    def _vector(self, array: Array) -> Vector:
        x, y, z = array.tolist()
        return (x, y, z)
