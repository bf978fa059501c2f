"""BROAD: the inclination of a held sensor beside the optical one, and beside VQF.

D. Laidig, M. Caruso, A. Cereatti, T. Seel, Data 6(7), 2021, doi 10.3390/data6070072.
VQF: D. Laidig, T. Seel, Information Fusion 91, 2023, doi 10.1016/j.inffus.2022.10.014.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import pictures
from benchmarks.accuracy.inertial import HELD, Recording, ways
from benchmarks.accuracy.report import Goal, Report
from benchmarks.accuracy.signals import root_mean_square, rotations
from benchmarks.accuracy.trial import Trial, load

Array = NDArray[np.float64]

NAME = 'BROAD, inclination'
PATTERN = 'broad/*.npz'

MOST = 0.30
"""Goal [°]."""

WINDOW = 2.0
"""Time [s] of which the picture shows the root mean square."""

AHEAD = 0.5
"""Both take a rate for the mean over the step before its stamp, so their attitude is half a step
later than what a sample shows [samples]."""

VQF = {
    'VQF': {},
    'VQF, tauAcc 10 s': {'tauAcc': 10.0},
}
"""Settings of VQF (`pip install vqf`): its defaults, and the time constant that is best here."""


def measure(path: Path, output: Path) -> Report:
    """Measure one recording."""
    trial = load(path)
    truth_s, late = vertical(trial.attitude), lateness(trial)
    time = np.arange(len(truth_s)) / trial.rate
    recording = Recording(path.stem, time, trial.force_s, trial.turn_s)
    errors: dict[str, Array] = {}
    stamped: dict[str, Array] = {}
    sigma = np.full(len(truth_s), np.nan)
    for name, way in ways(recording, HELD).items():
        states = way.states
        at = np.searchsorted(recording.stamps_ns, states.stamp_ns)
        found_s = np.full(truth_s.shape, np.nan)
        found_s[at] = vertical(states.attitude)
        errors[name] = angles(later(found_s, late - AHEAD), truth_s)
        stamped[name] = angles(found_s, truth_s)
        if name == 'causal':
            sigma[at] = np.degrees(np.sqrt(states.attitude_covariance[:, [0, 4]].sum(axis=1)))
    theirs = vqf(trial)
    for name, attitude in theirs.items():
        errors[name] = angles(later(vertical(attitude), late - AHEAD), truth_s)
        stamped[name] = angles(vertical(attitude), truth_s)

    report = Report(f'inclination-{path.stem}', f'BROAD, {path.stem}: inclination')
    rows = []
    for name, error in errors.items():
        figures = {
            'motion_rmse_deg': root_mean_square(error[trial.moving]),
            'motion_most_deg': float(np.nanmax(error[trial.moving])),
            'rest_rmse_deg': root_mean_square(error[~trial.moving]),
            'stamped_motion_rmse_deg': root_mean_square(stamped[name][trial.moving]),
        }
        report.figures[name] = figures
        rows.append((name, *(f'{value:.3f}°' for value in figures.values())))
    late_ms = report.figures['late_ms'] = 1000.0 * late / trial.rate
    published = report.figures['causal']
    published['sigma_deg'] = root_mean_square(sigma[trial.moving])
    published['error_per_sigma'] = root_mean_square((errors['causal'] / sigma)[trial.moving])
    if not theirs:
        rows.append(('VQF', 'not installed', '', '', ''))
    report.add_table(
        f'against the optical one of the same instant, the sensor being {late_ms:.1f} ms late; '
        'and in motion as stamped',
        ('', 'in motion', 'most', 'at rest', 'as stamped'),
        rows,
    )
    report.text.append(
        f'causal, in motion: σ {published["sigma_deg"]:.2f}°, error/σ '
        f'{published["error_per_sigma"]:.2f}, RMS'
    )
    number = path.stem.split('_')[0]
    for name in ('causal', 'smoothed'):
        found = report.figures[name]['motion_rmse_deg']
        what = f'BROAD {number}, inclination in motion [°], {name}'
        report.aim(what, found, MOST, '{:.3f}')
        if theirs:
            report.aim(
                f'{what}, beside VQF', found, report.figures['VQF']['motion_rmse_deg'], '{:.3f}'
            )
        else:
            report.goals.append(
                Goal(f'{what}, beside VQF', 'VQF not installed', f'{found:.3f}', None)
            )
    report.pictures.append(
        _draw(output / f'{report.name}.png', report.title, trial, errors, sigma)
    )
    return report


def vertical(attitude: Array) -> Array:
    """Return the vertical in the frame of the sensor, shape (n, 3), of attitudes (x, y, z, w)."""
    up_s: Array = rotations(attitude)[:, 2, :]
    return up_s


def lateness(trial: Trial) -> float:
    """Return how late the gyro is, beside the optical rate [samples]; no filter takes part.

    Both are means over ``steps``; what one exceeds the other by is fitted with its change.
    """
    rot_ws = rotations(trial.attitude)
    steps = 4
    turned = np.einsum('nji,njk->nik', rot_ws[:-steps], rot_ws[steps:])
    optical = np.stack([turned[:, 2, 1], turned[:, 0, 2], turned[:, 1, 0]], axis=1)
    optical -= np.stack([turned[:, 1, 2], turned[:, 2, 0], turned[:, 0, 1]], axis=1)
    optical *= 0.5 * trial.rate / steps
    weights = np.array([0.5, 1.0, 1.0, 1.0, 0.5]) / steps
    gyro = np.stack([np.convolve(axis, weights, 'valid') for axis in trial.turn_s.T], axis=1)
    change = np.gradient(gyro, axis=0)
    known = trial.moving[steps // 2 : -steps // 2] & ~np.isnan(optical).any(axis=1)
    excess, change = (optical - gyro)[known], change[known]
    return float(np.sum((excess - excess.mean(axis=0)) * change) / np.sum(change**2))


def later(found_s: Array, samples: float) -> Array:
    """Return vectors, shape (n, 3), so many samples later; their length does not count."""
    row = np.arange(len(found_s))
    return np.stack([np.interp(row + samples, row, axis) for axis in found_s.T], axis=1)


def angles(one: Array, other: Array) -> Array:
    """Return the angles between unit vectors, shape (n, 3) both [°]."""
    across = np.linalg.norm(np.cross(one, other), axis=1)
    result: Array = np.degrees(np.arctan2(across, np.sum(one * other, axis=1)))
    return result


def vqf(trial: Trial) -> dict[str, Array]:
    """Return the attitudes (x, y, z, w) that VQF finds; none where it is not installed."""
    try:
        module: Any = import_module('vqf')
    except ImportError:
        return {}
    turn, force = np.ascontiguousarray(trial.turn_s), np.ascontiguousarray(trial.force_s)
    found = {}
    for name, settings in VQF.items():
        quaternions = module.VQF(1.0 / trial.rate, **settings).updateBatch(turn, force)['quat6D']
        found[name] = quaternions[:, [1, 2, 3, 0]]
    return found


def windowed(signal: Array, size: int) -> Array:
    """Return the root mean square of each so many samples in a row; NaN does not count."""
    rows = signal[: len(signal) // size * size].reshape(-1, size)
    return np.array([root_mean_square(row) for row in rows])


def _draw(path: Path, title: str, trial: Trial, errors: Mapping[str, Array], sigma: Array) -> Path:
    figure, axes = pictures.one(title)
    size = round(WINDOW * trial.rate)
    for name, colour in zip(('causal', 'smoothed', 'VQF'), pictures.RUNS, strict=True):
        if name in errors:
            values = windowed(errors[name], size)
            axes.plot(WINDOW * (0.5 + np.arange(len(values))), values, color=colour, label=name)
    time = np.arange(len(sigma)) / trial.rate
    axes.plot(time, sigma, color='#555555', linestyle='--', label='σ as published')
    first, last = np.flatnonzero(trial.moving)[[0, -1]]
    axes.axvspan(time[first], time[last], color='#f2f2f2', zorder=0, label='in motion')
    axes.set_ylim(0.0, None)
    axes.set_xlabel('time [s]')
    axes.set_ylabel(f'inclination, error of each {WINDOW:g} s, RMS [°]')
    pictures.legend_above(axes)
    return pictures.save(figure, path)
