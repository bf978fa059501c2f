"""Pictures of a run against the truth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib

matplotlib.use('Agg')

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from dead_reckoning.core.stages import ACCELERATION, ODOMETRY
from dead_reckoning.tools.demo.recording import Array, Recording, Series, Track
from dead_reckoning.tools.drawing import RED, tidy

TRUTH = {'color': '#9a9a9a', 'linewidth': 4.0, 'label': 'truth'}
ESTIMATE = {'color': RED, 'linewidth': 1.4, 'label': 'estimate'}


def save(path: Path, draw: Callable[[Axes], None], height: float = 3.4) -> Path:
    """Write one picture; ``draw`` fills its axes."""
    figure, axes = plt.subplots(figsize=(9.0, height), dpi=110)
    draw(axes)
    tidy(axes)
    axes.legend(frameon=False, loc='best')
    figure.tight_layout()
    figure.savefig(path)
    plt.close(figure)
    return path


def acceleration(axes: Axes, recording: Recording, axis: int) -> None:
    """Draw the linear acceleration along an axis over time."""
    truth, removed = recording.truth, recording.series[ACCELERATION]
    axes.plot(truth.time, np.gradient(truth.velocity[:, axis], truth.time), **TRUTH)
    axes.plot(removed.time, removed.values[:, axis], **{**ESTIMATE, 'label': 'gravity removed'})
    _over_time(axes, f'acceleration {"xyz"[axis]} [m/s²]')


def velocity(axes: Axes, recording: Recording, axis: int) -> None:
    """Draw the velocity along an axis over time."""
    truth, estimate = recording.truth, recording.track(ODOMETRY)
    axes.plot(truth.time, truth.velocity[:, axis], **TRUTH)
    axes.plot(estimate.time, estimate.velocity[:, axis], **ESTIMATE)
    _over_time(axes, f'velocity {"xyz"[axis]} [m/s]')


def position(axes: Axes, recording: Recording, axis: int) -> None:
    """Draw the position along an axis over time, with its published deviation."""
    truth, estimate = recording.truth, recording.track(ODOMETRY)
    middle, sigma = estimate.position[:, axis], estimate.deviation[:, axis]
    _band(axes, estimate.time, middle - sigma, middle + sigma)
    axes.plot(truth.time, truth.position[:, axis], **TRUTH)
    axes.plot(estimate.time, middle, **ESTIMATE)
    _over_time(axes, f'position {"xyz"[axis]} [m]')


def way(axes: Axes, truth: Track, estimate: Track) -> None:
    """Draw the way in the plane, to scale."""
    axes.plot(*truth.position[:, :2].T, **TRUTH)
    axes.plot(*estimate.position[:, :2].T, **ESTIMATE)
    axes.plot(*estimate.position[-1, :2], 'o', color=RED, label='end')
    axes.set_aspect('equal', adjustable='datalim')
    axes.set_xlabel('x [m]')
    axes.set_ylabel('y [m]')


def error(axes: Axes, truth: Track, estimate: Track) -> None:
    """Draw the distance from the truth in the plane over time, with its published deviation."""
    off = np.linalg.norm((estimate.position - truth.at(estimate.time).position)[:, :2], axis=1)
    _band(axes, estimate.time, 0.0 * off, np.linalg.norm(estimate.deviation[:, :2], axis=1))
    axes.plot(estimate.time, off, **{**ESTIMATE, 'label': 'distance from the truth'})
    _over_time(axes, 'error [m]')


def steps(axes: Axes, landed: Array, counted: Series) -> None:
    """Draw the steps as they were walked, at times of shape (n,) [s], and as they were counted."""
    axes.step(np.append(0.0, landed), np.arange(len(landed) + 1), where='post', **TRUTH)
    totals = np.append(0.0, counted.values[:, 0])
    axes.step(np.append(0.0, counted.time), totals, where='post', **ESTIMATE)
    _over_time(axes, 'steps')


def _band(axes: Axes, time: Array, low: Array, high: Array) -> None:
    axes.fill_between(
        time, low, high, color=RED, alpha=0.12, linewidth=0.0, label='one sigma, as published'
    )


def _over_time(axes: Axes, label: str) -> None:
    axes.set_xlabel('time [s]')
    axes.set_ylabel(label)
