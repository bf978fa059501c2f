"""Smooth paths through knots, with exact derivatives: what simulated motions are made of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Powers of τ in 0 … 1 whose value, slope and curvature at both ends are given: rows are the
# coefficients of τ⁰ … τ⁵, columns (value, slope, curvature) at 0 and at 1.
_HERMITE = np.linalg.inv(
    np.array(
        [
            [1, 0, 0, 0, 0, 0],
            [0, 1, 0, 0, 0, 0],
            [0, 0, 2, 0, 0, 0],
            [1, 1, 1, 1, 1, 1],
            [0, 1, 2, 3, 4, 5],
            [0, 0, 2, 6, 12, 20],
        ],
        dtype=float,
    )
)


class Path:
    """Go through knots by quintic polynomials: value, rate and acceleration are continuous.

    ``times``, shape (k,) [s]; ``values``, shape (k, c), at the knots; ``rates`` and
    ``accelerations``, the same shape, zero if not given.  Before the first and after the last knot
    the path stays where it is, so the rates there must be zero.
    """

    def __init__(
        self,
        times: Sequence[float],
        values: ArrayLike,
        rates: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
    ) -> None:
        self.times: Array = np.asarray(times, dtype=float)
        value = np.asarray(values, dtype=float)
        rate = np.zeros_like(value) if rates is None else np.asarray(rates, dtype=float)
        zero = np.zeros_like(value)
        push = zero if accelerations is None else np.asarray(accelerations, dtype=float)
        h = np.diff(self.times)[:, None]
        ends = np.stack(
            [
                value[:-1],
                rate[:-1] * h,
                push[:-1] * h**2,
                value[1:],
                rate[1:] * h,
                push[1:] * h**2,
            ],
            axis=1,
        )
        self._coefficients: Array = np.einsum('pe,kec->kpc', _HERMITE, ends)
        self._h: Array = h

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Return value, rate and acceleration at ``time``, shape (n,): each of shape (n, c)."""
        clipped = np.clip(time, self.times[0], self.times[-1])
        piece = np.clip(np.searchsorted(self.times, clipped, 'right') - 1, 0, len(self._h) - 1)
        h = self._h[piece]
        tau = (clipped - self.times[piece])[:, None] / h
        c = self._coefficients[piece]
        value = np.zeros_like(c[:, 0])
        slope = np.zeros_like(value)
        curvature = np.zeros_like(value)
        for power in range(5, -1, -1):  # Horner, with the derivatives beside it
            curvature = curvature * tau + 2.0 * slope
            slope = slope * tau + value
            value = value * tau + c[:, power]
        outside = ((time < self.times[0]) | (time > self.times[-1]))[:, None]
        return value, np.where(outside, 0.0, slope / h), np.where(outside, 0.0, curvature / h**2)


def ramp(start: float, end: float, speed: float, ramp_time: float, begin: float = 0.0) -> Path:
    """Go from ``start`` to ``end`` at ``speed``, with smooth ramps of ``ramp_time`` [s].

    The path has one channel and begins to move at ``begin`` [s].
    """
    way = end - start
    sign = 1.0 if way >= 0.0 else -1.0
    # A quintic that goes from rest to a speed in a time covers half of speed · time.
    ramp_time = min(ramp_time, abs(way) / speed)
    cruise = abs(way) / speed - ramp_time
    part = sign * speed * ramp_time / 2.0
    times = [begin, begin + ramp_time, begin + ramp_time + cruise, begin + 2 * ramp_time + cruise]
    values = [start, start + part, end - part, end]
    rates = [0.0, sign * speed, sign * speed, 0.0]
    if cruise < 1e-9:
        del times[2], values[2], rates[2]
    return Path(times, np.array(values)[:, None], np.array(rates)[:, None])


def crossing_times(path: Path, levels: Sequence[float]) -> Array:
    """Return when a rising path of one channel passes each level [s], to a nanosecond."""
    low = np.full(len(levels), path.times[0])
    high = np.full(len(levels), path.times[-1])
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = path.at(middle)[0][:, 0] < np.asarray(levels)
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    times: Array = 0.5 * (low + high)
    return times
