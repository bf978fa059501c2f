"""Compare the stamps of steps with those of the true ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import pictures
from benchmarks.accuracy.step_counters import Count, Stamps, Walk
from dead_reckoning.core.samples import NANOSECONDS

Array = NDArray[np.float64]

TOLERANCE = 0.1
"""A step found and a true one this close [s] are the same."""

LAGS = np.arange(-50, 51) * 0.01
"""How much later than a step its stamp may be, all along [s]."""

ROW = 30.0
"""Time in each row of a picture [s]."""


def matched(found: Array, true: Array) -> list[tuple[int, int]]:
    """Return which steps are which true ones: in order, each at most once, as many as can be.

    Both are times [s], rising.
    """
    pairs = []
    times, truth = found.tolist(), true.tolist()
    k = j = 0
    while k < len(times) and j < len(truth):
        apart = times[k] - truth[j]
        if abs(apart) <= TOLERANCE:
            pairs.append((k, j))
        if apart <= TOLERANCE:
            k += 1
        if apart >= -TOLERANCE:
            j += 1
    return pairs


def f1(found: Array, true: Array) -> float:
    """Return twice the number of matched steps over that of those found and those true."""
    return 2.0 * len(matched(found, true)) / max(len(found) + len(true), 1)


def common_lag(pairs: Sequence[tuple[Array, Array]]) -> float:
    """Return the one lag [s] with which the steps found fit the true ones best.

    ``pairs`` are those of each recording [s].
    """
    fits = np.array([np.mean([f1(found - lag, true) for found, true in pairs]) for lag in LAGS])
    best = LAGS[fits > fits.max() - 1e-9]
    return float(best[len(best) // 2])


def seconds(walk: Walk, stamps_ns: Stamps) -> Array:
    """Return stamps as times since the first sample [s], in order."""
    times: Array = np.sort(stamps_ns - walk.stamps_ns[0]) / NANOSECONDS
    return times


def against_truth(counts: Sequence[Count], name: str) -> list[tuple[Array, Array]]:
    """Return times of the steps of a counter and of the true ones [s], for each walk with such."""
    return [
        (seconds(c.walk, c.found[name]), seconds(c.walk, c.walk.landings_ns))
        for c in counts
        if c.walk.landings_ns is not None
    ]


def draw_steps(path: Path, title: str, walk: Walk, found_ns: Stamps, lag: float = 0.0) -> Path:
    """Show the norm, the steps found, without their lag, the true ones, and where they differ."""
    count = max(1, int(np.ceil(walk.seconds / ROW)))
    figure, rows = pictures.below(title, count)
    time = seconds(walk, walk.stamps_ns)
    order = np.argsort(walk.stamps_ns, kind='stable')
    norm = np.linalg.norm(walk.force_s[order], axis=1)
    found = seconds(walk, found_ns) - lag
    marks = [(found, pictures.RUNS[0], (0.85, 1.0), 'found', 'found, but not true')]
    if walk.landings_ns is not None:
        true = seconds(walk, walk.landings_ns)
        marks.append((true, pictures.RUNS[1], (0.0, 0.15), 'true', 'true, but not found'))
        pairs = np.array(matched(found, true), int).reshape(-1, 2)
    for number, axes in enumerate(rows):
        axes.plot(time, norm, color='#555555', linewidth=0.6)
        axes.set_xlim(number * ROW, (number + 1) * ROW)
        for side, (times, colour, (low, high), label, alone) in enumerate(marks):
            across = axes.get_xaxis_transform()
            axes.vlines(times, low, high, color=colour, transform=across, label=label)
            if len(marks) == 2:
                others = np.delete(times, pairs[:, side])
                for k, other in enumerate(others):
                    axes.axvspan(
                        other - TOLERANCE,
                        other + TOLERANCE,
                        color=colour,
                        alpha=0.25,
                        linewidth=0.0,
                        label='' if k else alone,
                    )
    rows[-1].set_xlabel('time [s]')
    rows[len(rows) // 2].set_ylabel('norm of the specific force [m/s²]')
    pictures.legend_above(rows[0])
    return pictures.save(figure, path)
