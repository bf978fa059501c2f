"""gaitmap's example: two feet, 2 × 20 m, and cameras that saw every stride.

A. Küderle et al., "Gaitmap—An Open Ecosystem for IMU-Based Human Gait Analysis", IEEE Open J. Eng.
Med. Biol. 5, 2024, doi 10.1109/OJEMB.2024.3356791.
"""

from __future__ import annotations

import csv
import gzip
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import pictures
from benchmarks.accuracy.inertial import FOOT, START_NS, Recording, Way, ways
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.signals import root_mean_square
from benchmarks.accuracy.smoothing import add_swings_beside_smoothed
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.samples import NANOSECONDS

Array = NDArray[np.float64]

NAME = 'gaitmap'
PATTERN = 'gaitmap_2x20m'

RATE, CAMERA_RATE = 204.8, 100.0
"""Samples of the sensors and of the cameras a second."""

FEET = ('left', 'right')

HEEL = {'left': 'L_FCC', 'right': 'R_FCC'}
"""The marker of each heel."""

RMSE, MEAN = 0.05, 1.0
"""Goals of a stride's length: [m] and [%]."""


def measure(path: Path, output: Path) -> Report:
    """Measure the strides of both feet."""
    feet = {foot: stride_lengths(path, foot) for foot in FEET}
    lengths = {foot: found for foot, (found, _) in feet.items()}
    report = Report('gaitmap', 'gaitmap, length of the strides of two feet')
    names = list(lengths['left'])[1:]
    both = {
        name: np.concatenate([lengths[foot][name] for foot in FEET]) for name in lengths['left']
    }
    rows = []
    for who, found in (*lengths.items(), ('both', both)):
        true = found['true']
        cells = []
        for name in names:
            error = found[name] - true
            rmse, mean = root_mean_square(error), 100.0 * error.mean() / true.mean()
            cells.append(f'{rmse:.3f} m, {mean:+.2f} %')
            report.figures[f'{who}, {name}'] = {'rmse_m': rmse, 'mean_percent': mean}
        rows.append((who, str(len(true)), f'{true.mean():.3f} m', *cells))
    report.add_table(
        'against the marker on the heel: RMSE, mean', ('', 'strides', 'length', *names), rows
    )
    add_swings_beside_smoothed(report, [walked for _, walked in feet.values()])
    for name in ('causal', 'smoothed'):
        figures = report.figures[f'both, {name}']
        report.aim(f'gaitmap, stride length, RMSE [m], {name}', figures['rmse_m'], RMSE, '{:.3f}')
        mean = abs(figures['mean_percent'])
        report.aim(f'gaitmap, stride length, mean error [%], {name}', mean, MEAN)
    report.pictures.append(_draw(output / 'gaitmap.png', report.title, lengths))
    return report


def stride_lengths(path: Path, foot: str) -> tuple[dict[str, Array], dict[str, Way]]:
    """Return the lengths of a foot's strides [m], the true ones and those of each way; the ways.

    Raises `RecordingError` where something is wrong.
    """
    recording, borders, true = load(path, foot)
    found = {'true': true}
    walked = ways(recording, FOOT)
    for name, way in walked.items():
        found[name] = lengths_between(way.states.position, in_states(way, borders))
    return found, walked


def load(path: Path, foot: str) -> tuple[Recording, NDArray[np.int64], Array]:
    """Read the sensor of a foot; return it, its strides, shape (n, 2) [samples], their lengths.

    A stride goes from where the foot moves least to where it does so again, as the set says; what
    the cameras did not see is left out.  Raises `RecordingError` where something is wrong.
    """
    try:
        recording = load_foot(path / 'imu_sample.csv.gz', foot)
        heel_w = load_heel(path / 'mocap_sample.csv.gz', foot)
        borders = load_strides(path / 'stride_events_sample.csv.gz', foot)
    except (OSError, ValueError, IndexError, KeyError) as error:
        raise RecordingError(f'{path}: {type(error).__name__}, {error}') from error
    frames = np.round(borders / RATE * CAMERA_RATE).astype(int)
    seen = frames.max(axis=1) < len(heel_w)
    borders, frames = borders[seen], frames[seen]
    true = lengths_between(heel_w, frames)
    known = np.isfinite(true)
    return recording, borders[known], true[known]


def in_states(way: Way, samples: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the indices of states that stand for samples, as these are numbered in the file."""
    stamps = START_NS + np.round(samples / RATE * NANOSECONDS).astype(np.int64)
    indices: NDArray[np.int64] = np.searchsorted(way.states.stamp_ns, stamps)
    return indices


def lengths_between(position_w: Array, borders: NDArray[np.int64]) -> Array:
    """Return the horizontal distances [m] between pairs of rows, shape (n, 2)."""
    steps = position_w[borders[:, 1], :2] - position_w[borders[:, 0], :2]
    lengths: Array = np.hypot(*steps.T)
    return lengths


def load_foot(path: Path, foot: str) -> Recording:
    """Read the sensor of a foot, in m/s² and °/s."""
    values = _columns(path, f'{foot}_sensor')
    time = np.arange(len(values)) / RATE
    return Recording(foot, time, values[:, :3], np.radians(values[:, 3:6]))


def load_heel(path: Path, foot: str) -> Array:
    """Read where the cameras saw a heel, shape (n, 3) [m]; NaN where they did not."""
    return _columns(path, HEEL[foot]) / 1000.0


def load_strides(path: Path, foot: str) -> NDArray[np.int64]:
    """Read begin and end of each stride of a foot, shape (n, 2) [samples]."""
    with gzip.open(path, 'rt', encoding='utf-8', newline='') as lines:
        rows = [row for row in csv.DictReader(lines) if row['foot'] == foot]
    borders: NDArray[np.int64] = np.array(
        [[float(row['start']), float(row['end'])] for row in rows]
    ).astype(np.int64)
    return borders


def _columns(path: Path, name: str) -> Array:
    """Read the columns of a name in the first of two lines of heading."""
    with gzip.open(path, 'rt', encoding='utf-8') as lines:
        names = next(lines).strip().split(',')
    chosen = [column for column, each in enumerate(names) if each == name]
    if not chosen:
        raise KeyError(f'{path.name}: no {name}')
    values: Array = np.genfromtxt(path, delimiter=',', skip_header=2, usecols=chosen)
    return values


def _draw(path: Path, title: str, lengths: Mapping[str, Mapping[str, Array]]) -> Path:
    """Show the error of each stride."""
    figure, axes = pictures.one(title)
    first = 0
    for foot, found in lengths.items():
        numbers = first + np.arange(len(found['true']))
        first = int(numbers[-1]) + 3
        for name, colour in zip(('causal', 'smoothed'), pictures.RUNS, strict=False):
            label = name if foot == 'left' else None
            error = 1000.0 * (found[name] - found['true'])
            axes.plot(numbers, error, 'o-', color=colour, linewidth=0.8, label=label)
        axes.text(float(numbers[0]), 1000.0 * RMSE, foot)
    for limit in (-RMSE, RMSE):
        axes.axhline(1000.0 * limit, color='#9a9a9a', linestyle='--')
    axes.set_xlabel('stride')
    axes.set_ylabel('length less the true one [mm]')
    pictures.legend_above(axes)
    return pictures.save(figure, path)
