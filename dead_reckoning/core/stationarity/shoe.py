"""Stance hypothesis optimal detection: force and rate against a sensor that stands."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.stationarity import GRAVITY, WEIGHT, Sums, judge, window_sums
from dead_reckoning.core.navigation.window_detector import WindowDetector
from dead_reckoning.core.parameters import Settings, parameter


@dataclass(frozen=True, kw_only=True)
class ShoeSettings(Settings, prefix='navigator.shoe'):
    """What the threshold follows, and the weight of the generalised likelihood ratio."""

    least: float = parameter(
        0.05, 'What a foot that stands quietly shows: 3 °/s', unit='rad/s', minimum=1e-6,
        maximum=100.0,
    )  # fmt: skip
    share: float = parameter(
        0.12, 'Part of a swing that a stance may show, as it rolls', minimum=0.0, maximum=1.0
    )
    weight: float = parameter(
        0.25,
        'Rate that counts as much as 1 m/s²: in a rolling stance the acceleration of 25 ms over '
        '0.1 m',
        unit='rad/s per m/s²',
        minimum=0.0,
        maximum=100.0,
    )


def statistic(sums: Sums, gravity: float, weight: float) -> float:
    """Return √(mean|ω|² + w² mean|f − g f̄/|f̄||²) [rad/s]."""
    along = sqrt(sums.x * sums.x + sums.y * sums.y + sums.z * sums.z)
    rest = sums.force - 2.0 * gravity * along + gravity * gravity * sums.n
    return sqrt((sums.rate + weight * weight * max(rest, 0.0)) / sums.n)


@compiled
def judge_samples(samples: Array, rules: Array, state: Array, verdicts: Array) -> None:
    """Judge samples, as `StationarityDetector` has it."""
    for k in range(len(samples)):
        sums = window_sums(samples[k], rules, state)
        judge(statistic(sums, rules[GRAVITY], rules[WEIGHT]), rules, state, verdicts[k])


class Shoe(WindowDetector):
    """Judge by the generalised likelihood ratio of a sensor that neither turns nor speeds up.

    I. Skog, P. Händel, J.-O. Nilsson, J. Rantakokko, *Zero-velocity detection: an algorithm
    evaluation*, IEEE Trans. Biomed. Eng. 57 (11), 2010, doi:10.1109/TBME.2010.2060723, their GLRT
    with σ_ω = w σ_a, written as a rate; the direction of gravity is that of the mean force f̄.
    """

    Settings = ShoeSettings
    JUDGE = staticmethod(judge_samples)


DETECTOR = Shoe
