"""A simulated accelerometer: a motion with its exact truth, seen through the sensor's faults."""

from __future__ import annotations

from collections.abc import Sequence
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
from dead_reckoning.sources.one_pole import OnePole
from dead_reckoning.sources.simulated_gyroscope import SimulatedGyroscope
from dead_reckoning.sources.truth import true_states

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class SimulatedSettings(Settings, prefix='driver.simulated'):
    """What the simulated sensor suffers from, and how the table it moves on is tilted."""

    seed: int = parameter(1, 'Seed of the noise', minimum=0)
    noise: bool = parameter(True, 'Whether it has the noise that driver.noise says')
    clip: bool = parameter(True, 'Whether its output stops at the ends of the swing')
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
        0.0, 'How much warmer it gets once it runs', unit='K', minimum=-100.0, maximum=100.0
    )
    warming_time: float = parameter(
        60.0, 'Time in which it has got warmer by 63 % of that', unit='s',
        minimum=0.1, maximum=100_000.0,
    )  # fmt: skip
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
            clip=False,
            quantise=False,
            offset=(0.0,) * 3,
            sensitivity_error=(0.0,) * 3,
            cross_axis=(0.0,) * 6,
            nonlinearity=0.0,
            low_pass=False,
            axis_delay=0.0,
        )


REFERENCE_TEMPERATURE = 25.0
"""At which the data sheets state offset and sensitivity [°C]."""

BENDING = 2.0
"""Full scales up to which the characteristic bends, so that it rises everywhere."""

SETTLING = 5.0
"""Time constants in the wake time of a sensor: it has settled to 0.7 % then."""


class SimulatedAccelerometer:
    """Read a sensor that moves: conversion k happens ``k / sample_rate`` after the start.

    The force passes, in this order: misalignment and cross-axis sensitivity; scale, nonlinearity,
    offset and their drift; supply; low-pass; noise; swing; sleep; ADC (docs/simulator.md).  The
    same settings and seed give the same counts, however they are cut into calls.
    """

    def __init__(
        self,
        settings: SimulatedSettings,
        part: Part,
        model: Accelerometer,
        motion: Motion,
        sample_rate: float,
        start_ns: int = 0,
        gyroscope: SimulatedGyroscope | None = None,
    ) -> None:
        """``sample_rate`` [Hz]; ``start_ns`` the stamp at which the motion begins.

        A ``gyroscope`` is read in the moment of each conversion of x.
        """
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
        self._low_pass = OnePole(part.low_pass if settings.low_pass else (0.0,) * 3, sample_rate)
        self._supply = 1.0 + settings.supply_error if part.ratiometric else 1.0
        low, high = model.swing
        if part.ratiometric:  # the upper rail is the supply
            high = (high + part.swing_margin) * self._supply - part.swing_margin
        self._swing = (low, high) if settings.clip else (-np.inf, np.inf)
        delay = settings.axis_delay
        self._delays = (0.0, delay, 2.0 * delay) if delay else (0.0,)
        self._gyroscope = gyroscope

    def available(self, now_ns: int) -> int:
        """Return how many conversions have happened by ``now_ns`` and were not read yet."""
        happened = floor((now_ns - self._start_ns) * self._rate / NANOSECONDS) + 1
        return max(0, happened - self._taken)

    def read(self, count: int) -> Conversions:
        """Return the next ``count`` conversions."""
        time = np.arange(self._taken, self._taken + count) / self._rate
        self._taken += count
        truth = self._motion.at(np.concatenate([time + delay for delay in self._delays]))
        output = self._low_pass.filter(self._output(self._force(truth, count), time))
        if self._settings.noise:
            output = output + self._model.noise * self._random.standard_normal(output.shape)
        output = self._awake(np.clip(output, *self._swing), time)
        gyroscope = self._gyroscope
        rates = gyroscope.read(truth.angular_velocity[:count]) if gyroscope else None
        return Conversions(
            self._start_ns + np.round(time * NANOSECONDS).astype(np.int64),
            self._model.convert(output, quantise=self._settings.quantise),
            rates,
        )

    def truth(self, stamp_ns: int) -> NavigationState:
        """Return where the body really is at a stamp."""
        return self.truths([stamp_ns])[0]

    def truths(self, stamps_ns: Sequence[int]) -> list[NavigationState]:
        """Return where the body really is at each of many stamps."""
        return true_states(self._motion, self._rot_wt, stamps_ns, self._start_ns)

    def _force(self, truth: Kinematics, count: int) -> Array:
        """Return the specific force, shape (n, 3) [m/s²], frame s.

        ``truth`` holds the moments of x, then those of y and of z if they differ.
        """
        lifted = truth.acceleration + self._rot_wt.T @ np.array([0.0, 0.0, GRAVITY])
        rotation = truth.rotation
        moments = [slice(count * k, count * (k + 1)) for k in range(len(self._delays))]
        return np.column_stack(
            [
                np.einsum('nj,nj->n', rotation[moment, :, axis], lifted[moment])
                for axis, moment in enumerate(moments * (3 // len(moments)))
            ]
        )

    def _output(self, force_s: Array, time: Array) -> Array:
        """Return the output of the sensor, shape (n, 3) [unit], before its low-pass."""
        settings, part, model = self._settings, self._part, self._model
        warmed = -settings.warming * np.expm1(-time / settings.warming_time)
        warmer = (settings.temperature + warmed - REFERENCE_TEMPERATURE)[:, None]
        scale = 1.0 + np.array(settings.sensitivity_error) + part.sensitivity_drift * warmer
        seen = np.einsum('nj,kj->nk', force_s, self._mixing) * scale
        share = np.minimum(np.abs(seen) / (model.range_g * GRAVITY), BENDING)
        seen = seen * (1.0 + settings.nonlinearity * share)
        seen = seen + np.array(settings.offset) + part.offset_drift * GRAVITY * warmer
        return model.output(seen) * self._supply

    def _awake(self, output: Array, time: Array) -> Array:
        """Return the output of a sensor that sleeps, at zero, and settles once it is woken."""
        if self._settings.sleep_until == 0.0:
            return output
        since = np.maximum(time - self._settings.sleep_until, 0.0)
        settled: Array = -np.expm1(-SETTLING / self._part.wake_time * since)
        return np.multiply(output, settled[:, None])
