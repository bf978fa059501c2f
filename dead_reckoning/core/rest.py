"""Look for a stretch of rest, and check what a sensor at rest must show."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, degrees, inf, sqrt

from dead_reckoning.core.errors import GravityError, MountingError, NotAtRestError
from dead_reckoning.core.samples import NANOSECONDS, Vector

GRAVITY = 9.80665
"""Standard gravity [m/s²] (ISO 80000-3)."""

MINIMUM_SAMPLES = 5
GRAVITY_TOLERANCE = 0.10
UP_AXIS_TOLERANCE = 60.0


@dataclass(frozen=True, slots=True, eq=False)
class Rest:
    """What a window at rest showed: mean and standard deviation per axis, both shape (3,)."""

    mean: Vector
    deviation: Vector
    count: int


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
        self._count = 0
        self._start_ns = 0
        self._origin: Vector = (0.0, 0.0, 0.0)
        self._sum = [0.0, 0.0, 0.0]
        self._squares = [0.0, 0.0, 0.0]

    def add(self, stamp_ns: int, vector: Vector) -> Rest | None:
        """Take one sample; return the rest once the window is full, None before.

        Raises `NotAtRestError` when the full window varied too much.
        """
        if self._count == 0:
            self._start_ns, self._origin = stamp_ns, vector
        self._count += 1
        for axis in range(3):
            difference = vector[axis] - self._origin[axis]
            self._sum[axis] += difference
            self._squares[axis] += difference * difference
        if stamp_ns - self._start_ns < self._duration_ns or self._count < MINIMUM_SAMPLES:
            return None
        n = self._count
        means = [s / n for s in self._sum]
        spread = [sqrt(max(0.0, q / n - m * m)) for q, m in zip(self._squares, means, strict=True)]
        mean = tuple(o + m for o, m in zip(self._origin, means, strict=True))
        self._clear()
        if max(spread) > self._deviation:
            raise NotAtRestError(
                f'not at rest: the standard deviation of an axis was {max(spread):.3g} '
                f'{self._unit} over {self._duration_ns / NANOSECONDS:g} s, allowed are '
                f'{self._deviation:g}: '
                'hold the device still'
            )
        return Rest(mean, (spread[0], spread[1], spread[2]), n)  # type: ignore[arg-type]


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
