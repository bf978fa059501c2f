"""All figures that an estimate and its truth give together, under their names."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dead_reckoning.core.errors import InputError
from dead_reckoning.tools.evaluate.command import TRACKS
from dead_reckoning.tools.evaluate.files import has_rows, read_steps, read_trajectory, read_truth
from dead_reckoning.tools.evaluate.metrics import (
    absolute_errors,
    consistency,
    relative_errors,
    statistics,
)
from dead_reckoning.tools.evaluate.steps import Steps, timing
from dead_reckoning.tools.evaluate.trajectory import Trajectory, align, associate

Figures = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Options:
    """What is compared with what: the options of the command."""

    folder: Path
    truth: Path | None = None
    topic: str | None = None
    steps: int | None = None
    distance: float | None = None
    track: str | None = None
    align: str = 'yaw'
    max_difference: float = 0.01
    delta: float = 1.0
    delta_unit: str = 's'


def compare(options: Options) -> Figures:
    """Return the figures; raises `InputError` where something is missing or can't be read."""
    if not options.folder.is_dir():
        raise InputError(f'{options.folder}: no folder; name one that dead-reckoning replay wrote')
    truth = read_truth(options.truth, options.topic) if options.truth else None
    evaluation: Figures = {'folder': str(options.folder), 'truth': _named(options)}
    asked = isinstance(truth, Trajectory) or options.track is not None
    track = _track(options, wanted=asked)
    if track is not None:
        estimate = read_trajectory(track)
        evaluation['trajectory'] = {'file': track.name, **_way(estimate)}
        if isinstance(truth, Trajectory):
            evaluation['trajectory'] |= _poses(truth, estimate, options)
    count, distance, times = options.steps, options.distance, None
    if isinstance(truth, Steps):
        count = truth.count if count is None else count
        distance = truth.distance if distance is None else distance
        times = truth.stamp_ns
    if count is not None:
        steps = _steps(options.folder)
        evaluation['steps'] = _beside(count, steps.count)
        if times is not None and steps.stamp_ns is not None:
            evaluation['steps']['timing'] = timing(times, steps.stamp_ns)
    if distance is not None:
        evaluation['distance_m'] = _distances(options.folder, distance, evaluation)
    return evaluation


def _named(options: Options) -> Figures:
    named = {
        'file': options.truth and str(options.truth),
        'topic': options.topic,
        'steps': options.steps,
        'distance_m': options.distance,
    }
    return {name: value for name, value in named.items() if value is not None}


def _track(options: Options, wanted: bool) -> Path | None:
    """Return the table of poses to look at: that asked for, else the first there is.

    One without poses, as of steps without a heading, is none unless poses are ``wanted``.
    """
    names = TRACKS if options.track is None else (options.track,)
    paths = [options.folder / f'{name}.csv' for name in names]
    for path in paths:
        if path.exists() and (wanted or has_rows(path)):
            return path
    if wanted:
        raise InputError(
            f'{options.folder}: no {" or ".join(path.name for path in paths)}; '
            'dead-reckoning replay writes it into the folder of each recording'
        )
    return None


def _steps(folder: Path) -> Steps:
    path = folder / 'steps.csv'
    if not path.exists():
        raise InputError(
            f'{folder}: no {path.name}; dead-reckoning replay writes it where pedometer is among '
            'pipeline.estimators'
        )
    return read_steps(path)


def _way(trajectory: Trajectory) -> Figures:
    return {
        'samples': len(trajectory),
        'duration_s': float(trajectory.stamp_ns[-1] - trajectory.stamp_ns[0]) / 1e9,
        'path_length_m': trajectory.length,
        'loop_closure_m': trajectory.closure,
    }


def _poses(whole_truth: Trajectory, whole_estimate: Trajectory, options: Options) -> Figures:
    truth, estimate = associate(whole_truth, whole_estimate, options.max_difference)
    alignment = align(truth, estimate, options.align)
    aligned = alignment.apply(estimate)
    apart, turned = absolute_errors(truth, aligned)
    ways, turns = relative_errors(truth, aligned, options.delta, options.delta_unit)
    figures: Figures = {
        'truth': _way(whole_truth),
        'pairs': len(truth),
        'max_difference_s': options.max_difference,
        'alignment': {
            'kind': options.align,
            'rotation_xyzw': alignment.rotation.as_quat().tolist(),
            'translation_m': alignment.translation.tolist(),
        },
        'ape': {
            'translation_m': statistics(apart),
            'rotation_deg': statistics(turned),
        },
        'rpe': {
            'delta': options.delta,
            'unit': options.delta_unit,
            'pairs': len(ways),
            'translation_m': statistics(ways),
            'rotation_deg': statistics(turns),
        },
        'end_error_m': float(apart[-1]),
    }
    if estimate.deviation is not None:
        figures['error_over_sigma'] = consistency(truth, estimate, alignment.rotation)
    return figures


def _distances(folder: Path, truth: float, evaluation: Figures) -> Figures:
    """Set what steps and poses say about the distance beside the true one."""
    found: Figures = {}
    if (folder / 'steps.csv').exists():
        steps = _steps(folder)
        if steps.distance is not None:
            found['steps'] = _beside(truth, steps.distance)
    if 'trajectory' in evaluation:
        found['path'] = _beside(truth, evaluation['trajectory']['path_length_m'])
    if not found:
        raise InputError(
            f'{folder}: neither a steps.csv with a column distance nor an odometry.csv, which a '
            'distance could be compared with'
        )
    return found


def _beside(truth: float, estimate: float) -> Figures:
    error = estimate - truth
    return {
        'truth': truth,
        'estimate': estimate,
        'error': error,
        'error_percent': 100.0 * error / truth if truth else None,
    }
