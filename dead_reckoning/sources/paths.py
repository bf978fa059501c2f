"""Smooth paths through knots, with exact derivatives: what simulated motions are made of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Coefficients of τ³, τ⁴, τ⁵, in this order, of the quintic on 0 … 1 with given ends; columns are
# slope and half the curvature at 0, the way between the ends, slope and half the curvature at 1.
_HERMITE = np.array(
    [
        [-6.0, -3.0, 10.0, -4.0, 1.0],
        [8.0, 3.0, -15.0, 7.0, -2.0],
        [-3.0, -1.0, 6.0, -3.0, 1.0],
    ]
)


# Third and fourth derivative at 0 and at 1, in units of τ, as they follow from the same columns.
_THIRD_AT_0 = 6.0 * _HERMITE[0]
_THIRD_AT_1 = np.array([6.0, 24.0, 60.0]) @ _HERMITE
_FOURTH_AT_0 = 24.0 * _HERMITE[1]
_FOURTH_AT_1 = np.array([24.0, 120.0]) @ _HERMITE[1:]


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
                rate[:-1] * h,
                0.5 * push[:-1] * h**2,
                np.diff(value, axis=0),
                rate[1:] * h,
                0.5 * push[1:] * h**2,
            ],
            axis=1,
        )
        self._coefficients: Array = np.concatenate(
            [
                np.stack([value[:-1], ends[:, 0], ends[:, 1]], axis=1),
                np.einsum('pe,kec->kpc', _HERMITE, ends),
            ],
            axis=1,
        )
        self._h: Array = h
        self._end: Array = value[-1]

    @classmethod
    def of_least_jerk(cls, times: Sequence[float], values: ArrayLike) -> Path:
        """Go through the knots, from rest to rest, with the least integral of squared jerk.

        That is how hands go through points (Flash and Hogan 1985,
        doi:10.1523/JNEUROSCI.05-07-01688.1985).  At the inner knots the third and the fourth
        derivative are continuous too, which gives two equations for the rate and the acceleration
        of each.
        """
        time, value = np.asarray(times, dtype=float), np.asarray(values, dtype=float)
        h, way = np.diff(time), np.diff(value, axis=0)
        inner = len(time) - 2
        # Unknowns of knot k: rate and half the acceleration.
        system = np.zeros((inner, 2, inner + 2, 2))
        known = np.zeros((inner, 2, value.shape[1]))
        for k in range(inner):
            before, after = h[k], h[k + 1]
            for row, (left, right) in enumerate(
                ((_THIRD_AT_1, _THIRD_AT_0), (_FOURTH_AT_1, _FOURTH_AT_0))
            ):
                end, begin = left / before ** (3 + row), right / after ** (3 + row)
                system[k, row, k] += end[0] * before, end[1] * before**2
                system[k, row, k + 1] += end[3] * before, end[4] * before**2
                system[k, row, k + 1] -= begin[0] * after, begin[1] * after**2
                system[k, row, k + 2] -= begin[3] * after, begin[4] * after**2
                known[k, row] = begin[2] * way[k + 1] - end[2] * way[k]
        solved = np.linalg.solve(
            system[:, :, 1:-1].reshape(2 * inner, 2 * inner),
            known.reshape(2 * inner, value.shape[1]),
        ).reshape(inner, 2, value.shape[1])
        rates, accelerations = np.zeros_like(value), np.zeros_like(value)
        rates[1:-1], accelerations[1:-1] = solved[:, 0], 2.0 * solved[:, 1]
        return cls(times, value, rates, accelerations)

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
        over = (time >= self.times[-1])[:, None]
        outside = over | (time < self.times[0])[:, None]
        return (
            np.where(over, self._end, value),
            np.where(outside, 0.0, slope / h),
            np.where(outside, 0.0, curvature / h**2),
        )


def ramp(start: float, end: float, speed: float, ramp_time: float, begin: float = 0.0) -> Path:
    """Go from ``start`` to ``end`` at ``speed``, with smooth ramps of ``ramp_time`` [s].

    The path has one channel and begins to move at ``begin`` [s].  On a way too short to reach the
    speed the ramps meet at a lower one.
    """
    way = end - start
    # A quintic that goes from rest to a speed in a time covers half of speed · time.
    reached = min(speed, abs(way) / ramp_time)
    rate = float(np.copysign(reached, way))
    cruise = abs(way) / reached - ramp_time if reached == speed else 0.0
    part = rate * ramp_time / 2.0
    times = [begin, begin + ramp_time, begin + ramp_time + cruise, begin + 2 * ramp_time + cruise]
    values = [start, start + part, end - part, end]
    rates = [0.0, rate, rate, 0.0]
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
