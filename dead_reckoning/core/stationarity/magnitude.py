"""Magnitude of the specific force against gravity."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.stationarity import GRAVITY, Sums, judge, window_sums
from dead_reckoning.core.navigation.window_detector import WindowDetector
from dead_reckoning.core.parameters import Settings, parameter


@dataclass(frozen=True, kw_only=True)
class MagnitudeSettings(Settings, prefix='navigator.magnitude'):
    """What the threshold follows."""

    least: float = parameter(
        0.2, 'What a foot that stands quietly shows', unit='m/s²', minimum=1e-6, maximum=1000.0
    )
    share: float = parameter(
        0.02, 'Part of a swing that a stance may show, as it rolls', minimum=0.0, maximum=1.0
    )


def statistic(sums: Sums, gravity: float) -> float:
    """Return √(mean(|f| − g)²) [m/s²]."""
    square = sums.force - 2.0 * gravity * sums.magnitude + gravity * gravity * sums.n
    return sqrt(max(square, 0.0) / sums.n)


@compiled
def judge_samples(samples: Array, rules: Array, state: Array, verdicts: Array) -> None:
    """Judge samples, as `StationarityDetector` has it."""
    for k in range(len(samples)):
        sums = window_sums(samples[k], rules, state)
        judge(statistic(sums, rules[GRAVITY]), rules, state, verdicts[k])


class Magnitude(WindowDetector):
    """Judge by the acceleration magnitude, MAG.

    Skog et al. 2010, doi:10.1109/TBME.2010.2060723.  The magnitude passes through gravity
    within each swing, so it finds rests that are none.
    """

    Settings = MagnitudeSettings
    JUDGE = staticmethod(judge_samples)


DETECTOR = Magnitude
