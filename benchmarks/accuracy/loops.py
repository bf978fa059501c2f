"""Walks that end where they began: tables of what is left at the end, and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from benchmarks.accuracy import pictures
from benchmarks.accuracy.inertial import CAUSAL, FOOT, Recording, Way, ways
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.smoothing import add_swings_beside_smoothed

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Loop:
    """A walk that ends where it began, and what was made of it in each way.

    ``known_w`` are points on the way that are known, shape (k, 2) [m], in the axes of the
    navigator, and ``passed`` the indices of the causal states there; the last is the end.
    """

    name: str
    ways: dict[str, Way]
    known_w: Array = field(default_factory=lambda: np.zeros((1, 2)))
    passed: Sequence[int] = (-1,)

    def end(self, way: str) -> float:
        """Return the horizontal error at the end [m]."""
        return float(np.hypot(*self.ways[way].end[:2]))

    def end_3d(self, way: str) -> float:
        """Return the error at the end in three dimensions [m]."""
        return float(np.linalg.norm(self.ways[way].end))

    def percent(self, way: str) -> float:
        """Return the horizontal error at the end in per cent of the way."""
        return 100.0 * self.end(way) / self.ways[way].length

    def errors(self) -> tuple[Array, Array]:
        """Return error and sigma at the known points [m]."""
        causal = self.ways[CAUSAL]
        at = list(self.passed)
        error = causal.states.position[at, :2] - causal.states.position[0, :2] - self.known_w
        return np.hypot(*error.T), causal.deviation[at]


def walk_loop(recording: Recording) -> Loop:
    """Navigate a loop of which the end alone is known."""
    return Loop(recording.name, ways(recording, FOOT))


def add_loops(report: Report, caption: str, loops: Sequence[Loop]) -> None:
    """Add the tables of some loops: what is left at the end beside its sigma, and the swings."""
    rows = []
    for loop in loops:
        causal = loop.ways[CAUSAL]
        ends = [
            cell
            for way, found in loop.ways.items()
            for cell in (f'{loop.end(way):.3f} m', f'{found.end[2]:+.3f} m')
        ]
        counts = ', '.join(str(found.strides) for found in loop.ways.values())
        percent, sigma = f'{loop.percent(CAUSAL):.3f} %', f'{causal.deviation[-1]:.2f} m'
        rows.append((loop.name, f'{causal.length:.1f} m', percent, *ends, sigma, counts))
    names = [head for way in loops[0].ways for head in (way, 'up')]
    head = ('', 'way', CAUSAL, *names, 'σ', 'strides')
    report.add_table(caption, head, rows)
    report.figures['loops'] = {
        loop.name: {
            way: {
                'way_m': found.length,
                'end_m': loop.end(way),
                'end_percent': loop.percent(way),
                'end_3d_m': loop.end_3d(way),
                'sigma_m': float(found.deviation[-1]),
                'strides': found.strides,
            }
            for way, found in loop.ways.items()
        }
        for loop in loops
    }
    add_swings_beside_smoothed(report, [loop.ways for loop in loops])


def draw(path: Path, title: str, loops: Sequence[Loop]) -> Path:
    """Show the best and the worst way, how high their stances are, and errors beside sigma."""
    order = sorted(loops, key=lambda loop: loop.percent(CAUSAL))
    shown = order if len(order) < 2 else [order[0], order[-1]]
    figure, left, (height, errors) = pictures.beside(title, len(shown))
    for axes, loop, colour in zip(left, shown, pictures.RUNS, strict=False):
        _draw_way(axes, loop)
        states = loop.ways[CAUSAL].states
        time = (states.stamp_ns - states.stamp_ns[0]) * 1e-9
        up = np.where(states.stationary, states.position[:, 2], np.nan)
        height.plot(time, 1000.0 * up, color=colour, label=loop.name)
    height.set_xlabel('time [s]')
    height.set_ylabel('height in stances [mm]')
    pictures.legend_above(height)
    for place, loop in enumerate(loops):
        off, sigma = loop.errors()
        spread = place + np.linspace(-0.2, 0.2, len(off) + 2)[1:-1]
        first = place == 0
        errors.plot(spread, off, 'o', color=pictures.RUNS[0], label='error' if first else None)
        errors.plot(spread, sigma, 'k_', label='σ as published' if first else None)
    errors.set_xlim(-0.5, len(loops) - 0.5)
    errors.set_xticks(range(len(loops)), [loop.name for loop in loops])
    errors.set_ylim(0.0, None)
    errors.set_ylabel('known points, horizontal [m]')
    pictures.legend_above(errors)
    return pictures.save(figure, path)


def _draw_way(axes: Axes, loop: Loop) -> None:
    way = loop.ways[CAUSAL]
    x, y, _ = (way.states.position - way.states.position[0]).T
    if len(loop.known_w) > 1:
        axes.plot(*np.vstack((np.zeros(2), loop.known_w)).T, label='corners', **pictures.TRUTH)
    axes.plot(x, y, label=CAUSAL, **pictures.ESTIMATE)
    axes.plot(0.0, 0.0, 'ko', fillstyle='none', markersize=10.0, label='start, and true end')
    axes.plot(x[-1], y[-1], 'kx', label='end')
    axes.set_aspect('equal', adjustable='datalim')
    axes.set_xlabel('x [m]')
    axes.set_ylabel('y [m]')
    axes.set_title(f'{loop.name}: {loop.end(CAUSAL):.2f} m of {way.length:.0f} m', fontsize=10)
    axes.legend(loc='upper center', bbox_to_anchor=(0.5, -0.12), ncols=2)
