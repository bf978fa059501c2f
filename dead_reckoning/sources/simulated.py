"""A simulated accelerometer: a motion with its exact truth, seen through the sensor's faults."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import matrix_from_quaternion, quaternion_from_euler
from dead_reckoning.core.samples import NANOSECONDS, NavigationState
from dead_reckoning.core.sensors import Part
from dead_reckoning.sources.motions import Kinematics, Motion
from dead_reckoning.sources.truth import true_state

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class SimulatedSettings(Settings, prefix='driver.simulated'):
    """What the simulated sensor suffers from, and how the table it moves on is tilted."""

    seed: int = parameter(1, 'Seed of the noise', minimum=0)
    noise: bool = parameter(True, 'Whether it has the noise that driver.noise says')
    quantise: bool = parameter(True, 'Whether it rounds to whole counts')
    offset: tuple[float, float, float] = parameter(
        (0.3, -0.2, 0.4), 'Offset of x, y, z at zero g', unit='m/s²',
        minimum=-100.0, maximum=100.0, length=3,
    )  # fmt: skip
    sensitivity_error: tuple[float, float, float] = parameter(
        (0.005, -0.005, 0.005), 'Relative error of the sensitivity of x, y, z',
        minimum=-0.5, maximum=0.5, length=3,
    )  # fmt: skip
    cross_axis: tuple[float, float, float, float, float, float] = parameter(
        (0.002, -0.001, 0.001, 0.002, -0.002, 0.001),
        'Misalignment and cross-axis sensitivity: parts of y and z that show on x, of x and z on '
        'y, of x and y on z',
        minimum=-0.5, maximum=0.5, length=6,
    )  # fmt: skip
    nonlinearity: float = parameter(
        0.002, 'Bend of the characteristic at full scale, as a part of it',
        minimum=-0.2, maximum=0.2,
    )  # fmt: skip
    supply_error: float = parameter(
        0.0, 'Relative error of the supply, to which an analogue sensor is ratiometric',
        minimum=-0.3, maximum=0.3,
    )  # fmt: skip
    temperature: float = parameter(
        25.0, 'Temperature at the start; offset and sensitivity drift away from 25 °C', unit='°C',
        minimum=-60.0, maximum=150.0,
    )  # fmt: skip
    warming: float = parameter(
        0.0, 'How fast the temperature changes', unit='K/s', minimum=-10.0, maximum=10.0
    )
    low_pass: bool = parameter(True, "Whether it has the sensor's low-pass")
    axis_delay: float = parameter(
        0.00002, 'Time from the conversion of x to that of y, and of y to that of z', unit='s',
        minimum=0.0, maximum=0.1,
    )  # fmt: skip
    sleep_until: float = parameter(
        0.0, 'Time at which the sensor is woken; it sleeps before, and then settles', unit='s',
        minimum=0.0, maximum=1000.0,
    )  # fmt: skip
    attitude: tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.0), 'Roll, pitch and yaw of the table', unit='rad',
        minimum=-3.2, maximum=3.2, length=3,
    )  # fmt: skip

    @classmethod
    def ideal(cls) -> SimulatedSettings:
        """Return the settings of a sensor without faults."""
        return cls(
            noise=False,
            quantise=False,
            offset=(0.0,) * 3,
            sensitivity_error=(0.0,) * 3,
            cross_axis=(0.0,) * 6,
            nonlinearity=0.0,
            low_pass=False,
            axis_delay=0.0,
        )


REFERENCE_TEMPERATURE = 25.0


class SimulatedAccelerometer:
    """Read a sensor that moves: conversion k happens ``k / sample_rate`` after the start.

    The force passes, in this order: misalignment and cross-axis sensitivity; scale, nonlinearity,
    offset and their drift; supply; low-pass; noise; sleep; the swing and the ADC.  The same
    settings and seed give the same counts, however they are read in pieces.
    """

    def __init__(
        self,
        settings: SimulatedSettings,
        part: Part,
        model: Accelerometer,
        motion: Motion,
        sample_rate: float,
        start_ns: int = 0,
    ) -> None:
        """``sample_rate`` [Hz]; ``start_ns`` the stamp at which the motion begins."""
        self._settings = settings
        self._part = part
        self._model = model
        self._motion = motion
        self._rate = sample_rate
        self._start_ns = start_ns
        self._taken = 0
        self._random = np.random.default_rng(settings.seed)
        self._rot_wt: Array = np.reshape(
            matrix_from_quaternion(quaternion_from_euler(*settings.attitude)), (3, 3)
        )
        a, b, c, d, e, f = settings.cross_axis
        self._mixing: Array = np.array([[1.0, a, b], [c, 1.0, d], [e, f, 1.0]])
        # What the low-pass forgets from one conversion to the next, per axis.
        corner = np.array(part.low_pass) if settings.low_pass else np.zeros(3)
        self._memory: Array = np.where(
            corner > 0.0, np.exp(-2.0 * np.pi * corner / sample_rate), 0
        )
        self._filtered: Array | None = None

    def available(self, now_ns: int) -> int:
        """Return how many conversions have happened by ``now_ns`` and were not read yet."""
        happened = floor((now_ns - self._start_ns) * self._rate / NANOSECONDS) + 1
        return max(0, happened - self._taken)

    def read(self, count: int) -> Conversions:
        """Return the next ``count`` conversions."""
        time = np.arange(self._taken, self._taken + count) / self._rate
        self._taken += count
        output = self._low_passed(self._output(self._force(time), time))
        if self._settings.noise:
            output = output + self._model.noise * self._random.standard_normal(output.shape)
        counts = self._model.counts(self._awake(output, time), quantise=self._settings.quantise)
        return Conversions(self._start_ns + np.round(time * NANOSECONDS).astype(np.int64), counts)

    def truth(self, stamp_ns: int) -> NavigationState:
        """Return where the body really is at a stamp."""
        return true_state(self._motion, self._rot_wt, stamp_ns, self._start_ns)

    def _force(self, time: Array) -> Array:
        """Return the specific force, shape (n, 3) [m/s²], each axis at its own moment."""
        delay = self._settings.axis_delay
        if delay == 0.0:
            return self._force_of(self._motion.at(time))
        parts = [self._force_of(self._motion.at(time + k * delay))[:, k] for k in range(3)]
        return np.column_stack(parts)

    def _force_of(self, truth: Kinematics) -> Array:
        gravity_t = self._rot_wt.T @ np.array([0.0, 0.0, GRAVITY])
        force: Array = np.einsum('nji,nj->ni', truth.rotation, truth.acceleration + gravity_t)
        return force

    def _output(self, force_s: Array, time: Array) -> Array:
        settings, part, model = self._settings, self._part, self._model
        warmer = settings.temperature + settings.warming * time - REFERENCE_TEMPERATURE
        warmer = warmer[:, None]
        scale = 1.0 + np.array(settings.sensitivity_error) + part.sensitivity_drift * warmer
        seen = force_s @ self._mixing.T * scale
        full = model.range_g * GRAVITY
        seen = seen + settings.nonlinearity * seen * np.abs(seen) / full
        seen = seen + np.array(settings.offset) + part.offset_drift * GRAVITY * warmer
        supply = 1.0 + settings.supply_error if part.ratiometric else 1.0
        return model.output(seen) * supply

    def _low_passed(self, output: Array) -> Array:
        if not self._memory.any() or not len(output):
            return output
        state = output[0] if self._filtered is None else self._filtered
        filtered = np.empty_like(output)
        for k, now in enumerate(output):
            state = now + self._memory * (state - now)
            filtered[k] = state
        self._filtered = state
        return filtered

    def _awake(self, output: Array, time: Array) -> Array:
        """Return the output of a sensor that sleeps, at zero, and settles once it is woken."""
        since = time - self._settings.sleep_until
        if since[0] > 20.0 * self._part.wake_time or self._settings.sleep_until == 0.0:
            return output
        risen = np.where(since > 0.0, 1.0 - np.exp(-5.0 * since / self._part.wake_time), 0.0)
        woken: Array = output * risen[:, None]
        return woken
