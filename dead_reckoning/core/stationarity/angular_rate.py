"""Energy of the angular rate."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.stationarity import Sums, judge, window_sums
from dead_reckoning.core.navigation.window_detector import WindowDetector
from dead_reckoning.core.parameters import Settings, parameter


@dataclass(frozen=True, kw_only=True)
class AngularRateSettings(Settings, prefix='navigator.angular_rate'):
    """What the threshold follows."""

    least: float = parameter(
        0.05, 'What a foot that stands quietly shows: 3 °/s', unit='rad/s', minimum=1e-6,
        maximum=100.0,
    )  # fmt: skip
    share: float = parameter(
        0.1, 'Part of a swing that a stance may show, as it rolls', minimum=0.0, maximum=1.0
    )


def statistic(sums: Sums) -> float:
    """Return √(mean|ω|²) [rad/s]."""
    return sqrt(sums.rate / sums.n)


@compiled
def judge_samples(samples: Array, rules: Array, state: Array, verdicts: Array) -> None:
    """Judge samples, as `StationarityDetector` has it."""
    for k in range(len(samples)):
        sums = window_sums(samples[k], rules, state)
        judge(statistic(sums), rules, state, verdicts[k])


class AngularRate(WindowDetector):
    """Judge by the angular rate energy, ARE.

    Skog et al. 2010, doi:10.1109/TBME.2010.2060723.
    """

    Settings = AngularRateSettings
    JUDGE = staticmethod(judge_samples)


DETECTOR = AngularRate
