"""Look for a stretch of rest, and check what a sensor at rest must show."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from math import acos, degrees, inf, sqrt

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.errors import GravityError, MountingError, NotAtRestError
from dead_reckoning.core.rotation import variance_along
from dead_reckoning.core.samples import NANOSECONDS, UNKNOWN, Matrix, Vector

GRAVITY = 9.80665
"""Standard gravity [m/s²] (ISO 80000-3)."""

MINIMUM_SAMPLES = 5
GRAVITY_TOLERANCE = 0.10
UP_AXIS_TOLERANCE = 60.0

COSINES = 4
"""Cosines over a window that show how far its mean may be off; fewer than `MINIMUM_SAMPLES`."""


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """What a window at rest showed: mean and standard deviation per axis, both shape (3,).

    ``mean_covariance``, shape (3, 3), says how well the mean is known.
    """

    mean: Vector
    deviation: Vector
    count: int
    mean_covariance: Matrix = UNKNOWN


class RestWindow:
    """Average a vector over a stretch of time in which it must not vary.

    ``duration`` [s] of samples are taken; the standard deviation of each axis must stay below
    ``deviation`` (unit of the vector).  A window that failed starts anew with the next sample.
    """

    def __init__(self, duration: float, deviation: float, unit: str = 'm/s²') -> None:
        self._duration_ns = round(duration * NANOSECONDS)
        self._deviation = deviation
        self._unit = unit
        self._clear()

    def _clear(self) -> None:
        self._start_ns = 0
        self._values = array('d')  # of all axes, one sample after the other

    def add(self, stamp_ns: int, vector: Vector) -> Rest | None:
        """Take one sample; return the rest once the window is full, None before.

        Raises `NotAtRestError` when the full window varied too much.
        """
        if not self._values:
            self._start_ns = stamp_ns
        self._values.extend(vector)
        n = len(self._values) // 3
        if stamp_ns - self._start_ns < self._duration_ns or n < MINIMUM_SAMPLES:
            return None
        vectors = np.reshape(self._values, (n, 3))
        origin = vectors[0]
        vectors = vectors - origin  # else rounding would show as a deviation
        mean = tuple((origin + vectors.mean(axis=0)).tolist())
        spread = tuple(vectors.std(axis=0).tolist())
        self._clear()
        if max(spread) > self._deviation:
            raise NotAtRestError(
                f'not at rest: the standard deviation of an axis was {max(spread):.3g} '
                f'{self._unit} over {self._duration_ns / NANOSECONDS:g} s, allowed are '
                f'{self._deviation:g}: '
                'hold the device still'
            )
        return Rest(mean, spread, n, _covariance_of_mean(vectors))


def _covariance_of_mean(vectors: NDArray[np.float64]) -> Matrix:
    """Say how well the mean of n vectors, shape (n, 3), is known, though each resembles the next.

    The amplitudes of slow cosines over the window vary as the mean does (Lazarus et al. 2018,
    doi:10.1080/07350015.2018.1506926); docs/gravity.md, "How well a rest is known".
    """
    n = len(vectors)
    half_waves = np.outer(np.arange(1, COSINES + 1), np.pi / n * (np.arange(n) + 0.5))
    amplitudes = np.sqrt(2.0) / n * np.cos(half_waves) @ vectors
    return tuple((amplitudes.T @ amplitudes / COSINES).ravel().tolist())


def level_variances(force: Rest) -> tuple[float, float]:
    """Say how well a rest shows gravity: variances of magnitude [m²/s⁴] and of tilt [rad²].

    That of the tilt is of each of the two horizontal axes.
    """
    x, y, z = force.mean
    square = x * x + y * y + z * z
    along = variance_along(force.mean, force.mean_covariance) / square
    across = sum(force.mean_covariance[::4]) - along
    return along, 0.5 * max(0.0, across) / square


def check_gravity(specific_force: Vector) -> float:
    """Return the magnitude of the specific force at rest [m/s²], shape (3,), any frame.

    Raises `GravityError`, which names the causes, when it is not within 10 % of gravity.
    """
    magnitude = sqrt(sum(f * f for f in specific_force))
    if abs(magnitude - GRAVITY) <= GRAVITY_TOLERANCE * GRAVITY:
        return magnitude
    causes = sorted(_CAUSES, key=lambda cause: not cause[0] <= magnitude <= cause[1])
    raise GravityError(
        f'at rest the specific force is {magnitude:.4g} m/s² where {GRAVITY:g} ± 10 % is gravity; '
        f'most likely {causes[0][2]}; else {"; ".join(words for _, _, words in causes[1:])}'
    )


_CAUSES = (
    (0.0, 0.5, 'gravity is removed already (take the raw topic)'),
    (0.9, 1.1, 'the unit is g instead of m/s² (multiply by 9.80665)'),
    (900.0, 1100.0, 'the unit is mg instead of m/s² (multiply by 0.00980665)'),
    (
        0.0, inf,
        "the sensor's range, supply or scale is set wrong (driver.range_g, driver.supply)",
    ),
)  # fmt: skip


def check_up_axis(specific_force: Vector) -> None:
    """Raise `MountingError` when the force at rest, shape (3,), is over 60° off the z axis."""
    magnitude = sqrt(sum(f * f for f in specific_force))
    angle = degrees(acos(max(-1.0, min(1.0, specific_force[2] / magnitude))))
    if angle > UP_AXIS_TOLERANCE:
        raise MountingError(
            f'at rest the specific force is {angle:.0f}° off the up axis (z): if the sensor is '
            'mounted that way, say so by frames.mounting_rotation, or in TF where frames.mounting '
            'is tf; else the sign is turned (at rest +g belongs on the up axis), the device is '
            'upside down, or its axes or attitude are NED where ENU is meant'
        )
