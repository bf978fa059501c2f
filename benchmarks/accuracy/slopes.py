"""Simulated stairs and ramps, between level ground: what is won in height, against the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import pictures
from benchmarks.accuracy.inertial import CAUSAL, FOOT, Recording, Way, ways
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.simulated_walks import Walk, joined, measured, walk

Array = NDArray[np.float64]

NAME = 'stairs and ramps, simulated'

SLOPES = {
    '12 risers up': {'strides': 12, 'stride_length': 0.29, 'rise': 0.17},
    '12 risers down, two a stride': {'strides': 6, 'stride_length': 0.58, 'rise': -0.34},
    'ramp of 5 %': {'strides': 20, 'stride_length': 1.4, 'rise': 0.07},
    'ramp of 5 %, short strides': {'strides': 20, 'stride_length': 1.0, 'rise': 0.05},
}
"""Strides of each, one foot's; a riser is 17 cm."""

LEVEL = {'strides': 6, 'stride_length': 1.3}
"""What is walked before and after."""

SEEDS = 8
MOST = 3.0
"""Goal [% of the height]."""


def measure(output: Path) -> Report:
    """Measure each so many times, with other noise, biases and errors of scale."""
    report = Report('slopes', f'Stairs and ramps, simulated, {SEEDS} times each')
    rows = []
    drawn = {}
    worst: dict[str, dict[str, float]] = {}
    for name, slope in SLOPES.items():
        true = joined(
            walk(end=0.2, **LEVEL), walk(start=0.2, end=0.2, **slope), walk(start=0.2, **LEVEL)
        )
        height = float(true.position[-1, 2])
        found = [ways(recorded(true, seed), FOOT) for seed in range(SEEDS)]
        drawn[name] = true, found[0][CAUSAL]
        worst[name] = {
            way: max(abs(100.0 * (each[way].end[2] / height - 1.0)) for each in found)
            for way in found[0]
        }
        rows.append(
            (name, f'{height:+.2f} m', *(f'{most:.2f} %' for most in worst[name].values()))
        )
    report.add_table('height won, worst error', ('', 'true', *next(iter(worst.values()))), rows)
    report.figures['worst_percent'] = worst
    for name, found in worst.items():
        for way in ('causal', 'smoothed'):
            report.aim(f'{name} (simulated), height [%], {way}', found[way], MOST)
    report.pictures.append(_draw(output / 'slopes.png', report.title, drawn))
    return report


def recorded(true: Walk, seed: int) -> Recording:
    """Return a walk as a sensor with noise, biases and an error of scale records it."""
    found = measured(true, seed)
    return Recording(f'seed {seed}', found.time, found.force, found.rate)


def _draw(path: Path, title: str, drawn: dict[str, tuple[Walk, Way]]) -> Path:
    """Show one run of each, and its error beside sigma."""
    figure, left, (above, below) = pictures.beside(title, 1)
    for (name, (true, way)), colour in zip(drawn.items(), pictures.COLOURS, strict=False):
        states = way.states
        first = len(true.time) - len(states)
        time = true.time[first:]
        left[0].plot(time, true.position[first:, 2], **pictures.TRUTH)
        left[0].plot(time, states.position[:, 2], color=colour, linewidth=0.9, label=name)
        error = states.position[:, 2] - true.position[first:, 2]
        above.plot(time, 1000.0 * error, color=colour, linewidth=0.9)
        sigma = np.sqrt(states.position_covariance[:, 8])
        below.plot(time, 1000.0 * sigma, color=colour, linewidth=0.9)
    left[0].set_ylabel('height [m], truth in grey')
    left[0].legend(loc='upper left', fontsize=8)
    above.set_ylabel('error [mm]')
    below.set_ylabel('σ as published [mm]')
    for axes in (left[0], below):
        axes.set_xlabel('time [s]')
    return pictures.save(figure, path)
