"""Moving variance of the acceleration."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.stationarity import Sums, judge, window_sums
from dead_reckoning.core.navigation.window_detector import WindowDetector
from dead_reckoning.core.parameters import Settings, parameter


@dataclass(frozen=True, kw_only=True)
class AccelerationVarianceSettings(Settings, prefix='navigator.acceleration_variance'):
    """What the threshold follows."""

    least: float = parameter(
        0.2, 'What a foot that stands quietly shows', unit='m/s²', minimum=1e-6, maximum=1000.0
    )
    share: float = parameter(
        0.04, 'Part of a swing that a stance may show, as it rolls', minimum=0.0, maximum=1.0
    )


def statistic(sums: Sums) -> float:
    """Return √(mean|f − f̄|²) [m/s²]."""
    mean = (sums.x * sums.x + sums.y * sums.y + sums.z * sums.z) / sums.n
    return sqrt(max(sums.force - mean, 0.0) / sums.n)


@compiled
def judge_samples(samples: Array, rules: Array, state: Array, verdicts: Array) -> None:
    """Judge samples, as `StationarityDetector` has it."""
    for k in range(len(samples)):
        sums = window_sums(samples[k], rules, state)
        judge(statistic(sums), rules, state, verdicts[k])


class AccelerationVariance(WindowDetector):
    """Judge by the acceleration moving variance, MV, whose square root is the statistic.

    Skog et al. 2010, doi:10.1109/TBME.2010.2060723.  A steady turn or speed looks like rest to it.
    """

    Settings = AccelerationVarianceSettings
    JUDGE = staticmethod(judge_samples)


DETECTOR = AccelerationVariance
