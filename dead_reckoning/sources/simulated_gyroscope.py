"""A simulated gyroscope beside the accelerometer: the true rate of turn, and what spoils it."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians, sqrt

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.gyroscope import Gyroscope
from dead_reckoning.core.parameters import Settings, parameter

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class GyroSettings(Settings, prefix='driver.gyro'):
    """A gyroscope beside the accelerometer; range and noise are those of a board, too."""

    enabled: bool = parameter(
        False, 'Whether there is one beside the simulated accelerometer; a board has one or not'
    )
    range: float = parameter(
        radians(2000.0), 'Largest rate of turn, ±; 2000 °/s is usual on a foot',
        unit='rad/s', minimum=0.01, maximum=1000.0,
    )  # fmt: skip
    noise: float = parameter(
        radians(0.01), 'Density of its noise, as data sheets give it: one reading at a rate r of '
        'conversions has noise · √(r/2) as one sigma; 0 for none',
        unit='rad/s/√Hz', minimum=0.0, maximum=1.0,
    )  # fmt: skip
    bias: tuple[float, float, float] = parameter(
        (radians(0.3), radians(-0.2), radians(0.1)), 'Bias of x, y, z at the start',
        unit='rad/s', minimum=-10.0, maximum=10.0, length=3,
    )  # fmt: skip
    bias_walk: float = parameter(
        radians(0.001), 'How the bias wanders: after t seconds it has moved by bias_walk · √t, '
        'one sigma', unit='rad/s/√s', minimum=0.0, maximum=1.0,
    )  # fmt: skip
    scale_error: tuple[float, float, float] = parameter(
        (0.003, -0.003, 0.003), 'Relative error of the scale of x, y, z',
        minimum=-0.5, maximum=0.5, length=3,
    )  # fmt: skip
    resolution: float = parameter(
        radians(2000.0) / 32_768, 'Size of one count; 0 for no rounding', unit='rad/s',
        minimum=0.0, maximum=1.0,
    )  # fmt: skip

    def model(self, sample_rate: float) -> Gyroscope | None:
        """Return the gyroscope as it reads at a rate of conversions [Hz]; None without one."""
        return self.gyroscope(sample_rate) if self.enabled else None

    def gyroscope(self, sample_rate: float) -> Gyroscope:
        """Return it wherever there is one."""
        return Gyroscope(
            range=self.range,
            noise=self.noise * sqrt(0.5 * sample_rate),
            resolution=self.resolution,
        )


class SimulatedGyroscope:
    """Read ``(1 + scale error)·ω + bias + noise``, rounded and kept within the range.

    The bias is a random walk.  The same settings and seed give the same readings, however they are
    cut into calls, and they leave the noise of the accelerometer as it is.
    """

    STREAM = 1
    """Sets its random numbers apart from those of other sensors with the same seed."""

    def __init__(
        self, settings: GyroSettings, model: Gyroscope, sample_rate: float, seed: int
    ) -> None:
        """``sample_rate`` of the conversions [Hz]."""
        self._model = model
        self._scale: Array = 1.0 + np.array(settings.scale_error)
        self._bias: Array = np.array(settings.bias)
        self._walk = settings.bias_walk / sqrt(sample_rate)
        self._random = np.random.default_rng((seed, self.STREAM))

    def read(self, rate_s: Array) -> Array:
        """Return the next readings for the true rates, both of shape (n, 3) [rad/s], frame s."""
        chance = self._random.standard_normal((len(rate_s), 6))
        steps = np.concatenate((self._bias[None], self._walk * chance[:, 3:]))
        bias = np.cumsum(steps, axis=0)
        self._bias = bias[-1]
        return self._model.reading(
            self._scale * rate_s + bias[:-1] + self._model.noise * chance[:, :3]
        )
