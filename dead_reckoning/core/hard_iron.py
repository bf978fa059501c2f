"""Find what iron nearby adds to the field that a compass sees, from one level turn."""

from __future__ import annotations

from math import atan2, degrees, pi, remainder

import numpy as np

from dead_reckoning.core.errors import CalibrationError
from dead_reckoning.core.samples import NANOSECONDS

ROUNDNESS = 0.1
"""Largest deviation from the circle, one sigma, as a part of its radius."""


class HardIronCalibration:
    """Fit a circle to the field in the compass's own axes while it turns once around.

    Level, the horizontal field draws a circle about what iron adds; that is the offset.  The
    circle is the one of least algebraic error (Kåsa 1976, doi:10.1109/TIM.1976.6312298):
    ``x² + y² = 2·a·x + 2·b·y + c``, linear in its centre (a, b).
    """

    def __init__(self, time_limit: float) -> None:
        """``time_limit`` [s]: how long the turn may take, by the stamps."""
        self._limit_ns = round(time_limit * NANOSECONDS)
        self._start_ns: int | None = None
        self._turned = 0.0
        self._field: list[tuple[float, float]] = []

    def add(self, stamp_ns: int, x: float, y: float) -> bool:
        """Take the field along x and y; return whether a full turn is complete.

        Raises `CalibrationError` once the turn takes too long.
        """
        if self._start_ns is None:
            self._start_ns = stamp_ns
        if self._field:
            last_x, last_y = self._field[-1]
            self._turned += remainder(atan2(y, x) - atan2(last_y, last_x), 2.0 * pi)
        self._field.append((x, y))
        if abs(self._turned) >= 2.0 * pi:
            return True
        if stamp_ns - self._start_ns > self._limit_ns:
            raise CalibrationError(
                f'the compass turned by {degrees(abs(self._turned)):.0f}° in '
                f'{self._limit_ns / NANOSECONDS:g} s: ask again and turn it level once around'
            )
        return False

    def finish(self) -> tuple[float, float]:
        """Return the offset along x and y, in the unit of the field.

        Raises `CalibrationError` where the field drew no circle.
        """
        field = np.array(self._field)
        unknown = np.column_stack([2.0 * field, np.ones(len(field))])
        (a, b, c), *_ = np.linalg.lstsq(unknown, (field**2).sum(axis=1), rcond=None)
        radius = float(np.sqrt(max(0.0, c + a * a + b * b)))
        off = float(np.std(np.hypot(field[:, 0] - a, field[:, 1] - b)))
        if off > ROUNDNESS * radius:
            raise CalibrationError(
                f'the field drew no circle: it is off by {off / max(radius, 1e-9):.0%} of its '
                'radius; keep the compass level while it turns, away from iron that stays behind'
            )
        return float(a), float(b)
