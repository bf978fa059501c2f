"""Pictures that look alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from benchmarks.accuracy.drift import Drift

TRUTH = {'color': '#9a9a9a', 'linewidth': 4.0}
ESTIMATE = {'color': '#c0392b', 'linewidth': 1.4}
AXES = ('#c0392b', '#2e86c1', '#27ae60')
RUNS = ('#c0392b', '#2e86c1', '#8e44ad')
COLOURS = (*RUNS, '#27ae60')


def two_and_one(title: str) -> tuple[Figure, tuple[Axes, Axes, Axes]]:
    """Return a figure with two axes above each other, sharing their x, and one beside them."""
    figure = Figure(figsize=(12.0, 5.6), dpi=110, layout='constrained')
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.5, 1.0))
    above = figure.add_subplot(grid[0, 0])
    below = figure.add_subplot(grid[1, 0], sharex=above)
    above.tick_params(labelbottom=False)
    return figure, (above, below, figure.add_subplot(grid[:, 1]))


def beside(title: str, count: int) -> tuple[Figure, list[Axes], tuple[Axes, Axes]]:
    """Return a figure with some axes beside each other, then two above each other."""
    figure = Figure(figsize=(4.3 * (count + 1), 5.6), dpi=110, layout='constrained')
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    grid = figure.add_gridspec(2, count + 1)
    left = [figure.add_subplot(grid[:, column]) for column in range(count)]
    right = figure.add_subplot(grid[0, count]), figure.add_subplot(grid[1, count])
    return figure, left, right


def one(title: str, height: float = 5.6) -> tuple[Figure, Axes]:
    """Return a figure, so many inches high, with one pair of axes."""
    figure = Figure(figsize=(12.0, height), dpi=110, layout='constrained')
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, figure.add_subplot()


def below(title: str, count: int) -> tuple[Figure, list[Axes]]:
    """Return a figure with some axes below each other."""
    figure = Figure(figsize=(14.0, 1.0 + 1.5 * count), dpi=110, layout='constrained')
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, [figure.add_subplot(count, 1, number + 1) for number in range(count)]


def legend_above(axes: Axes) -> None:
    """Put the legend of some axes above them, where it hides nothing."""
    axes.legend(loc='lower right', bbox_to_anchor=(1.0, 0.98), ncols=4)


def draw_drift(
    axes: Axes,
    measured: Mapping[str, Sequence[Drift]],
    known: Mapping[str, Mapping[float, float]],
) -> None:
    """Show median and 95 % of the drift over time, what others reached, and what was published."""
    for (name, runs), colour in zip(measured.items(), RUNS, strict=False):
        time = [drift.horizon for drift in runs]
        median = [float(np.median(drift.distance)) for drift in runs]
        most = [float(np.percentile(drift.distance, 95)) for drift in runs]
        axes.fill_between(time, median, most, color=colour, alpha=0.15, linewidth=0.0)
        axes.plot(time, median, color=colour, label=name)
    last = list(measured.values())[-1]
    sigma = [float(np.median(np.linalg.norm(drift.deviation, axis=1))) for drift in last]
    time = [drift.horizon for drift in last]
    axes.plot(time, sigma, color='#555555', linestyle='--', label='σ as published')
    for name, values in known.items():
        axes.plot(list(values), list(values.values()), 'k^', label=name)
    axes.set_xscale('log')
    axes.set_yscale('log')
    axes.set_xticks([0.5, 1, 2, 5, 10], ['0.5', '1', '2', '5', '10'])
    axes.minorticks_off()
    axes.yaxis.set_major_formatter('{x:g}')
    axes.set_xlabel('time after the start [s]')
    axes.set_ylabel('drift of the position [m], median to 95 %')
    axes.legend(loc='lower right')


def save(figure: Figure, path: Path) -> Path:
    """Write a figure with the look they share."""
    for axes in figure.axes:
        axes.grid(alpha=0.3)
        axes.spines[['top', 'right']].set_visible(False)
        legend = axes.get_legend()
        if legend is not None:
            legend.set_frame_on(False)
    figure.savefig(path)
    return path
