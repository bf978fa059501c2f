"""Errors beside the covariance published with them, over many simulated runs: the ANEES.

With e the error and P its covariance, of n dimensions, eᵀP⁻¹e/n is 1 in the mean of many runs.
Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation",
Wiley, 2001, section 5.4.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.accuracy import pictures
from benchmarks.accuracy.inertial import FOOT, Recording, Values, live
from benchmarks.accuracy.report import Goal, Report
from benchmarks.accuracy.simulated_drives import driven, from_its_start
from benchmarks.accuracy.simulated_walks import Walk, measured, walk
from dead_reckoning.core.blocks import StateBlock

Array = NDArray[np.float64]

NAME = 'consistency, simulated'

RUNS = 100
BOUND = 1.96 * float(np.sqrt(2.0 / (3 * RUNS)))
"""Half of the interval of 95 % about 1, for three dimensions and so many runs."""

PARTS = ('position', 'velocity', 'attitude')


@dataclass(frozen=True)
class Case:
    """A motion, what its sensor is like, what the filter believes, and times [s] to look at.

    ``assumed`` names the parts of which the filter believes what is so, and then 1 is wanted.
    """

    name: str
    true: Walk
    sensor: Mapping[str, Any]
    values: Values
    times: tuple[float, ...]
    assumed: tuple[str, ...] = PARTS


def gait() -> Walk:
    """Return ten strides in a bend, with a sensor that is level at rest."""
    return walk(strides=10, turn=0.3, mounted=np.eye(3))


SWINGS = tuple(4.46 + 2.2 * k for k in range(5))
"""Middle of the swing of each second stride of `gait` [s]."""

ON_THE_WAY = (9.0, 19.0, 29.0, 39.0, 50.0)
"""Times on a drive of 45 s [s]."""


def gait_as_assumed(bias_up: float = 0.0) -> Case:
    """Return a foot that stands still in its stances, and a sensor of the noise assumed.

    Where the foot stands, its rate is but noise and bias; so no more is the threshold of the
    detector.  A bias along the vertical, ``bias_up`` [m/s²], the filter takes for gravity.
    """
    sensor = {
        'force_noise': 0.03, 'rate_noise': 3e-4, 'force_bias': (0.05, 0.05, bias_up),
        'rate_bias': 0.0035, 'scale': 0.0,
    }  # fmt: skip
    believed = {
        'acceleration_noise': sensor['force_noise'], 'rate_noise': sensor['rate_noise'],
        'acceleration_bias': 0.05, 'rate_bias': sensor['rate_bias'],
        'averaging': 0.0, 'sampling_noise': 0.0, 'acceleration_walk': 0.0, 'rate_walk': 0.0,
        'rest_deviation': 1.0, 'rest_rate_deviation': 0.05, 'stance_velocity': 1e-5,
        'pivot': 0.0, 'height': 0.0, 'zero_rate': False, 'floor': False,
        'detector': ['angular_rate'], 'angular_rate.least': 1e-3, 'angular_rate.share': 0.0,
    }  # fmt: skip
    values = {**FOOT, **{f'navigator.{name}': value for name, value in believed.items()}}
    if bias_up:
        return Case('gait, a bias in gravity too', gait(), sensor, values, SWINGS, assumed=())
    return Case('gait, filter told the truth', gait(), sensor, values, SWINGS)


def gait_with_bias_in_gravity() -> Case:
    """Return the same, but for a bias along the vertical."""
    return gait_as_assumed(bias_up=0.05)


def drive_as_assumed() -> Case:
    """Return a vehicle and a sensor of the noise assumed.

    Its wheels never slip, so its velocity across is more exact than the filter believes.
    """
    sensor = {
        'force_noise': 0.03, 'rate_noise': 3e-4, 'force_bias': (0.05, 0.05, 0.0),
        'rate_bias': 5e-4, 'scale': 0.0,
    }  # fmt: skip
    believed = {
        'acceleration_noise': sensor['force_noise'], 'rate_noise': sensor['rate_noise'],
        'acceleration_bias': 0.05, 'rate_bias': sensor['rate_bias'], 'averaging': 0.0,
        'sampling_noise': 0.0, 'acceleration_walk': 0.0, 'rate_walk': 0.0,
        'rest_deviation': 1.0, 'rest_rate_deviation': 0.05, 'zero_velocity': False,
        'zero_rate': False, 'floor': False, 'nonholonomic': True, 'slip': 1e-3, 'slip_angle': 0.0,
    }  # fmt: skip
    values = {**FOOT, **{f'navigator.{name}': value for name, value in believed.items()}}
    true = from_its_start(driven(loops=1, loop_time=45.0))
    parts = ('position', 'attitude')
    return Case('drive, filter told the truth', true, sensor, values, ON_THE_WAY, parts)


def gait_by_default() -> Case:
    """Return the same foot with an ordinary sensor, and the settings of all feet.

    But its samples are of an instant.
    """
    values = {**FOOT, 'navigator.averaging': 0.0}
    return Case('gait, settings of all feet', gait(), {}, values, SWINGS, assumed=())


CASES: tuple[Callable[[], Case], ...] = (
    gait_as_assumed,
    gait_with_bias_in_gravity,
    drive_as_assumed,
    gait_by_default,
)


def measure(output: Path) -> Report:
    """Measure all cases."""
    report = Report('consistency', f'ANEES of what is published, {RUNS} simulated runs')
    figure, axes = pictures.one(report.title)
    rows = []
    for case, style in zip((make() for make in CASES), ('-', '--', '-.', ':'), strict=True):
        nees = normalized_errors(case)
        means = nees.mean(axis=(0, 1))
        rows.append((case.name, *(f'{value:.2f}' for value in means)))
        report.figures[case.name] = dict(zip(PARTS, means.tolist(), strict=True))
        for part, name in enumerate(PARTS):
            axes.plot(
                case.times,
                nees[:, :, part].mean(axis=0),
                style,
                marker='o',
                color=pictures.AXES[part],
                label=f'{name}: {case.name}',
            )
            if name in case.assumed:
                wanted = f'{1.0 - BOUND:.2f} to {1.0 + BOUND:.2f}'
                met = bool(abs(means[part] - 1.0) <= BOUND)
                found = f'{means[part]:.2f}'
                report.goals.append(Goal(f'ANEES, {name}: {case.name}', wanted, found, met))
    report.add_table(f'mean over the times; 95 %: 1 ± {BOUND:.2f}', ('', *PARTS), rows)
    axes.axhspan(1.0 - BOUND, 1.0 + BOUND, color='#eeeeee', zorder=0, label='95 %')
    axes.set_xlabel('time [s]')
    axes.set_ylabel('ANEES')
    axes.set_ylim(0.0, None)
    axes.legend(loc='center left', bbox_to_anchor=(1.0, 0.5))
    report.pictures.append(pictures.save(figure, output / 'consistency.png'))
    return report


def normalized_errors(case: Case) -> Array:
    """Return eᵀP⁻¹e/3 of position, velocity and attitude, shape (RUNS, times, 3)."""
    return np.array([_normalized(case, seed) for seed in range(RUNS)])


def _normalized(case: Case, seed: int) -> Array:
    drawn = measured(case.true, seed, **case.sensor)
    recording = Recording('', drawn.time, drawn.force, drawn.rate)
    states = live(recording, case.values).states
    first = len(drawn.time) - len(states)
    samples = np.searchsorted(drawn.time, case.times)
    return np.array([_errors(case.true, k, states, k - first) for k in samples.tolist()])


def _errors(true: Walk, k: int, states: StateBlock, at: int) -> list[float]:
    found = Rotation.from_quat(states.attitude[at])
    turn = (Rotation.from_matrix(true.rotation[k]) * found.inv()).as_rotvec()
    twist_b = true.rotation[k].T @ true.velocity[k]
    pairs = (
        (true.position[k] - states.position[at], states.position_covariance[at]),
        (found.apply(twist_b) - states.velocity[at], states.velocity_covariance[at]),
        (turn, states.attitude_covariance[at]),
    )
    return [
        float(error @ np.linalg.solve(covariance.reshape(3, 3), error)) / 3.0
        for error, covariance in pairs
    ]
