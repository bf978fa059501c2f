"""What smoothing wins within a stride, and where it jumps: beside the smoother, or the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import pictures
from benchmarks.accuracy.inertial import CAUSAL, FOOT, SMOOTHED, STRIDES, Recording, Way, ways
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.signals import root_mean_square
from benchmarks.accuracy.simulated_walks import Walk, measured, walk
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.samples import NANOSECONDS

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]

NAME = 'smoothing, simulated'

COUNT, TURN = 20, 0.1
"""Strides of the simulated walk, and what each turns by [rad]."""

SEEDS = 8

JUMP = 0.005
"""What the position moves beside its velocity within a sample [m], to count as a jump."""

LONGEST_STEP = 0.03
"""Time between two states [s] beyond which what the position moves is a gap's."""

HALF = 0.5
"""Goal: height in a swing, beside that of `odom`."""

SHOWN = (10.0, 15.0)
"""Time of the swings in the picture [s]."""


@dataclass(frozen=True)
class Reference:
    """What states are compared with: columns, (n, …), world [m, m/s]; which are of a swing."""

    stamp_ns: Stamps
    position: Array
    velocity: Array
    swings: NDArray[np.bool_]


@dataclass(frozen=True)
class Swings:
    """Errors of the height [m] and velocity [m/s] in swings, the height's variance [m²], and what
    the position moves from each state to the next beside its velocity [m].
    """  # fmt: skip

    height: Array
    velocity: Array
    variance: Array
    jumps: Array

    def figures(self) -> dict[str, float]:
        """Return what a report keeps."""
        return {
            'height_m': root_mean_square(self.height),
            'velocity_m_s': root_mean_square(self.velocity),
            'sigma_height_m': float(np.sqrt(np.mean(self.variance))),
            'jumps': int(np.sum(self.jumps >= JUMP)),
            'largest_jump_m': float(np.max(self.jumps)),
        }


def measure(output: Path) -> Report:
    """Measure a simulated walk so many times, with other noise, biases and errors of scale."""
    report = Report('smoothing', f'Smoothing of {COUNT} strides, simulated {SEEDS} times')
    true = walk(strides=COUNT, turn=TURN, mounted=np.eye(3))  # so that yaw begins at 0 for both
    found, references = [], []
    for seed in range(SEEDS):
        drawn = measured(true, seed)
        recording = Recording(f'seed {seed}', drawn.time, drawn.force, drawn.rate)
        found.append(ways(recording, FOOT))
        references.append(_truth(true, recording.stamps_ns, found[-1][SMOOTHED].states))
    figures = add_swings(report, 'beside the truth', found, references)
    ratio = figures[STRIDES]['height_m'] / figures[CAUSAL]['height_m']
    report.aim("height in a swing (simulated), stride by stride, beside odom's", ratio, HALF)
    report.pictures.append(_draw(output / 'smoothing.png', report.title, true, found[0]))
    return report


def add_swings(
    report: Report,
    beside: str,
    found: Sequence[Mapping[str, Way]],
    references: Sequence[Reference],
) -> dict[str, dict[str, float]]:
    """Add the table of the swings of all recordings, each found in the same ways."""
    figures = {
        name: _joined(
            [swings(each[name].states, true) for each, true in zip(found, references, strict=True)]
        ).figures()
        for name in found[0]
    }
    report.add_table(
        f'swings {beside}, RMS; what moves beside the velocity by {1e3 * JUMP:.0f} mm or more',
        ('', 'height', 'its σ', 'velocity', 'jumps', 'largest'),
        [
            (
                name,
                f'{1e3 * each["height_m"]:.1f} mm',
                f'{1e3 * each["sigma_height_m"]:.1f} mm',
                f'{1e3 * each["velocity_m_s"]:.0f} mm/s',
                str(each['jumps']),
                f'{1e3 * each["largest_jump_m"]:.0f} mm',
            )
            for name, each in figures.items()
        ],
    )
    report.figures['swings'] = figures
    return figures


def add_swings_beside_smoothed(report: Report, found: Sequence[Mapping[str, Way]]) -> None:
    """Add the same table beside the smoother over the whole recording."""
    add_swings(report, 'beside smoothed', found, [_smoothed(each) for each in found])


def swings(states: StateBlock, true: Reference) -> Swings:
    """Compare the states of the stamps that the reference has."""
    _, mine, other = np.intersect1d(states.stamp_ns, true.stamp_ns, return_indices=True)
    at, where = mine[true.swings[other]], other[true.swings[other]]
    steps = np.diff(states.stamp_ns[mine])[:, None] / NANOSECONDS
    position, velocity = states.position[mine], states.velocity[mine]
    moved = np.diff(position, axis=0) - 0.5 * steps * (velocity[1:] + velocity[:-1])
    return Swings(
        states.position[at, 2] - true.position[where, 2],
        np.linalg.norm(states.velocity[at] - true.velocity[where], axis=1),
        states.position_covariance[at, 8],
        np.linalg.norm(moved[steps[:, 0] < LONGEST_STEP], axis=1),
    )


def _joined(parts: Sequence[Swings]) -> Swings:
    names = ('height', 'velocity', 'variance', 'jumps')
    return Swings(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _smoothed(found: Mapping[str, Way]) -> Reference:
    states = found[SMOOTHED].states
    return Reference(states.stamp_ns, states.position, states.velocity, ~states.stationary)


def _truth(true: Walk, stamps: Stamps, smoothed: StateBlock) -> Reference:
    """Return the truth; a swing is what the smoother takes for one, as on a recording."""
    at = np.searchsorted(stamps, smoothed.stamp_ns)
    return Reference(smoothed.stamp_ns, true.position[at], true.velocity[at], ~smoothed.stationary)


def _draw(path: Path, title: str, true: Walk, found: Mapping[str, Way]) -> Path:
    """Show one run: the height in some swings, its sigma, and the horizontal error to the end."""
    figure, (above, below, side) = pictures.two_and_one(title)
    for name, colour in zip((CAUSAL, STRIDES, SMOOTHED), pictures.AXES, strict=True):
        states = found[name].states
        first = len(true.time) - len(states)
        time, error = true.time[first:], states.position - true.position[first:]
        style = {'color': colour, 'linewidth': 1.2, 'label': name}
        shown = (SHOWN[0] <= time) & (time < SHOWN[1])
        sigma = np.sqrt(states.position_covariance[:, 8])
        above.plot(time[shown], 1e3 * error[shown, 2], **style)
        below.plot(time[shown], 1e3 * sigma[shown], **style)
        side.plot(time, 1e3 * np.hypot(*error[:, :2].T), **style)
    above.set_ylabel('error of the height [mm]')
    below.set_ylabel('σ as published [mm]')
    side.set_ylabel('horizontal error [mm]')
    side.legend(loc='upper left')
    for axes in (below, side):
        axes.set_xlabel('time [s]')
    return pictures.save(figure, path)
