"""Pictures of a run: acceleration, velocity and position against the truth."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from dead_reckoning.tools.demo.cases import Case
from dead_reckoning.tools.demo.recording import Recording

TRUTH = {'color': '#9a9a9a', 'linewidth': 4.0, 'label': 'truth'}
ESTIMATE = {'color': '#c0392b', 'linewidth': 1.4, 'label': 'estimate'}


def draw(case: Case, recording: Recording, folder: Path) -> list[Path]:
    """Write the pictures of a run into ``folder``; return their paths."""
    return [
        _figure(folder / f'{case.name}-acceleration.png', _acceleration, case, recording),
        _figure(folder / f'{case.name}-velocity.png', _velocity, case, recording),
        _figure(folder / f'{case.name}-position.png', _position, case, recording),
    ]


def _figure(path: Path, plot, case: Case, recording: Recording) -> Path:
    figure, axes = plt.subplots(figsize=(9.0, 3.4), dpi=110)
    plot(axes, case, recording)
    axes.set_xlabel('time [s]')
    axes.grid(alpha=0.3)
    axes.spines[['top', 'right']].set_visible(False)
    axes.legend(frameon=False, loc='best')
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)
    return path


def _letter(case: Case) -> str:
    return 'xyz'[case.axis]


def _acceleration(axes: Axes, case: Case, recording: Recording) -> None:
    truth = recording.truth
    exact = np.gradient(truth.velocity[:, case.axis], truth.time)
    axes.plot(truth.time, exact, **TRUTH)
    axes.plot(
        recording.acceleration_time,
        recording.acceleration[:, case.axis],
        **{**ESTIMATE, 'label': 'gravity removed'},
    )
    axes.set_ylabel(f'acceleration {_letter(case)} [m/s²]')


def _velocity(axes: Axes, case: Case, recording: Recording) -> None:
    axes.plot(recording.truth.time, recording.truth.velocity[:, case.axis], **TRUTH)
    axes.plot(recording.estimate.time, recording.estimate.velocity[:, case.axis], **ESTIMATE)
    axes.set_ylabel(f'velocity {_letter(case)} [m/s]')


def _position(axes: Axes, case: Case, recording: Recording) -> None:
    estimate = recording.estimate
    middle, sigma = estimate.position[:, case.axis], estimate.deviation[:, case.axis]
    axes.fill_between(
        estimate.time,
        middle - sigma,
        middle + sigma,
        color='#c0392b',
        alpha=0.12,
        linewidth=0.0,
        label='one sigma, as published',
    )
    axes.plot(recording.truth.time, recording.truth.position[:, case.axis], **TRUTH)
    axes.plot(estimate.time, middle, **ESTIMATE)
    axes.set_ylabel(f'position {_letter(case)} [m]')
