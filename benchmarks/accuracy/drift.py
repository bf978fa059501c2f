"""Drift of free integration: how far off the integrator is some seconds after a known start.

From each start the integrator begins anew, at rest at the origin.  Integration is linear, so the
velocity v₀ that the body really had is added afterwards: the error after a time T is
``p(T) + v₀·T − (truth(T) − truth(0))``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.report import Report
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.samples import NANOSECONDS, ImuSample, LinearAcceleration

Array = NDArray[np.float64]
Pair = tuple[LinearAcceleration, ImuSample]

HORIZONS = (1.0, 2.0, 5.0, 10.0)
"""Times [s] after a start that the tables show."""

STEP = 0.5
"""Distance [s] of the times that are measured, for the pictures."""

FREE = {
    'integrator.window_minimum': 0.0,
    'integrator.window_maximum': 0.0,
    'integrator.movement_end': 'off',
}
"""Free integration: nothing is held for zero, nothing ends a movement; all else is default."""


@dataclass(frozen=True)
class Truth:
    """Where the body was and how fast it moved at each sample, shapes (n, 3); NaN if unknown."""

    position: Array
    velocity: Array


@dataclass(frozen=True)
class Drift:
    """Errors, and the deviations that were published with them, at one time after the starts.

    Shapes (m, 3) [m], world frame; ``horizon`` [s].
    """

    horizon: float
    error: Array
    deviation: Array

    @property
    def distance(self) -> Array:
        """Length of each error, shape (m,) [m]."""
        length: Array = np.linalg.norm(self.error, axis=1)
        return length

    def figures(self) -> dict[str, Any]:
        """Return what the tables say of it."""
        ratio = self.error / self.deviation
        return {
            'starts': len(self.error),
            'median_m': float(np.median(self.distance)),
            'percentile_95_m': float(np.percentile(self.distance, 95)),
            'horizontal_median_m': float(np.median(np.hypot(*self.error[:, :2].T))),
            'vertical_median_m': float(np.median(np.abs(self.error[:, 2]))),
            'error_over_sigma_horizontal': _root_mean_square(ratio[:, :2]),
            'error_over_sigma_vertical': _root_mean_square(ratio[:, 2]),
        }


def _root_mean_square(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def drifts(
    pairs: Sequence[Pair], truth: Truth, starts: Sequence[int], integrator: Integrator
) -> list[Drift]:
    """Integrate freely from each start, an index of ``pairs``, and compare with the truth.

    The integrator keeps its settings and its calibrated offset.  Times are measured where there is
    a sample within half a period and the truth is known; one without any is left out.
    """
    stamps = np.array([imu.stamp_ns for _, imu in pairs])
    tolerance_ns = 0.5 * float(np.median(np.diff(stamps)))
    count = round(HORIZONS[-1] / STEP)
    errors: list[list[Array]] = [[] for _ in range(count)]
    deviations: list[list[Array]] = [[] for _ in range(count)]
    for start in starts:
        wanted = stamps[start] + np.arange(1, count + 1) * round(STEP * NANOSECONDS)
        nearest = np.minimum(np.searchsorted(stamps, wanted - tolerance_ns), len(stamps) - 1)
        met = np.abs(stamps[nearest] - wanted) <= tolerance_ns
        met &= ~np.isnan(truth.position[nearest] + truth.position[start]).any(axis=1)
        met &= not np.isnan(truth.velocity[start]).any()
        at = {int(index): k for k, index in enumerate(nearest) if met[k]}
        if not at:
            continue
        integrator.reset()
        for index in range(start, max(at) + 1):
            state = integrator.update(*pairs[index])
            if index not in at:
                continue
            elapsed = (stamps[index] - stamps[start]) / NANOSECONDS
            moved = truth.position[index] - truth.position[start]
            error = np.array(state.position) + truth.velocity[start] * elapsed - moved
            errors[at[index]].append(error)
            deviations[at[index]].append(np.sqrt(state.position_covariance[::4]))
    return [
        Drift(STEP * (k + 1), np.array(errors[k]), np.array(deviations[k]))
        for k in range(count)
        if errors[k]
    ]


def at_horizons(measured: Sequence[Drift]) -> list[Drift]:
    """Pick the times that the tables show."""
    return [drift for drift in measured if drift.horizon in HORIZONS]


def every(seconds: float, pairs: Sequence[Pair], first: int, last: int) -> list[int]:
    """Return starts at equal distances [s], indices of ``pairs`` from ``first`` up to ``last``.

    The last start leaves room for the longest time that is measured.
    """
    stamps = np.array([imu.stamp_ns for _, imu in pairs[first : last + 1]])
    end_ns = stamps[-1] - HORIZONS[-1] * NANOSECONDS
    wanted = np.arange(stamps[0], end_ns + 1, round(seconds * NANOSECONDS))
    return [first + int(index) for index in np.searchsorted(stamps, wanted)]


def add_drift_table(
    report: Report,
    caption: str,
    measured: dict[str, list[Drift]],
    known: dict[str, dict[float, float]],
) -> None:
    """Add the figures of several runs, and what others reached, by run and time."""
    head = ('', 'after', 'starts', 'median', '95 %', 'error/σ horizontal', 'vertical')
    rows = []
    for name, runs in measured.items():
        for first, drift in enumerate(at_horizons(runs)):
            f = drift.figures()
            rows.append(
                (
                    '' if first else name,
                    f'{drift.horizon:g} s',
                    str(f['starts']),
                    f'{f["median_m"]:.3f} m',
                    f'{f["percentile_95_m"]:.3f} m',
                    f'{f["error_over_sigma_horizontal"]:.3g}',
                    f'{f["error_over_sigma_vertical"]:.3g}',
                )
            )
    for name, values in known.items():
        for first, (horizon, value) in enumerate(values.items()):
            rows.append(('' if first else name, f'{horizon:g} s', '', f'{value:.3f} m', *[''] * 3))
    report.add_table(caption, head, rows)
    report.figures['drift'] = {
        name: {f'{drift.horizon:g} s': drift.figures() for drift in at_horizons(runs)}
        for name, runs in measured.items()
    }
