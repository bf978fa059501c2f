"""Walks past ground control points: corners of rectangles, strides counted by the walker.

M. T. Koroglu, PyShoe dataset correction for bipedal locomotion.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy.inertial import (
    CAUSAL,
    FOOT,
    SMOOTHED,
    Recording,
    landings,
    numbers,
    ways,
)
from benchmarks.accuracy.loops import Loop, add_loops, draw
from benchmarks.accuracy.report import Goal, Report
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.rest import GRAVITY

Array = NDArray[np.float64]

NAME = 'GCP'
PATTERN = 'koroglu_gcp'

KEYS = ('t', 'acc_g', 'gyr', 'gcp_m', 'gcp_stride', 'strides', 'gcp_ok')

MEDIAN, WORST = 0.35, 2.0
"""Goals of the error at the end [m]."""

MISCOUNTED = {CAUSAL: 1, SMOOTHED: 0}
"""How far a count of strides may be off."""


def measure(path: Path, output: Path) -> Report:
    """Measure all walks of the folder."""
    found = sorted(path.glob('*.npz'))
    if not found:
        raise RecordingError(f'{path}: no *.npz in it; docs/accuracy.md says how to get them')
    walks = [load(each) for each in found]
    loops = [loop for loop, _ in walks]
    report = Report('gcp', f'GCP, {len(loops)} walks on a foot')
    add_loops(report, 'horizontal error at the end, height, strides', loops)
    _add_corners(report, walks)
    for way in (CAUSAL, SMOOTHED):
        errors = [loop.end(way) for loop in loops]
        report.aim(f'GCP, end error, median [m], {way}', float(np.median(errors)), MEDIAN)
        report.aim(f'GCP, end error, worst [m], {way}', max(errors), WORST)
        off = [loop.ways[way].strides - true for loop, true in walks]
        most = MISCOUNTED[way]
        report.goals.append(
            Goal(
                f'GCP, strides of each walk off by, {way}',
                f'≤ {most}' if most else 'exact',
                ', '.join(f'{each:+d}' if each else '0' for each in off),
                max(map(abs, off)) <= most,
            )
        )
    report.pictures.append(draw(output / 'gcp.png', report.title, loops))
    return report


def load(path: Path) -> tuple[Loop, int]:
    """Navigate one walk; return it and its true strides.

    Raises `RecordingError` where something is missing, or where it does not end where it began.
    """
    recording, (corners, at, true, ok) = read(path)
    if not np.allclose(corners[0], corners[-1]):
        raise RecordingError(f'{path}: ends at {corners[-1]}, not where it began; leave it out')
    found = ways(recording, FOOT)
    known_w, passed = np.zeros((1, 2)), np.array([-1])
    causal = found[CAUSAL].states
    landed = landings(causal)
    if ok and len(landed) > at[-1]:
        passed = landed[at[1:].astype(int)]
        reached = causal.position[passed, :2] - causal.position[0, :2]
        known_w = turned(corners[1:] - corners[0], reached)
    return Loop(path.stem, found, known_w, passed.tolist()), int(true)


def read(path: Path) -> tuple[Recording, list[Array]]:
    """Read one walk; return it, and of the rest of `KEYS` what there is."""
    with np.load(path) as data:
        time, force_g, turn_s, *known = numbers(path, data, KEYS)
    return Recording(path.stem, time, force_g * GRAVITY, turn_s), known


def turned(corners: Array, reached: Array) -> Array:
    """Turn corners about the start as fits best; mirror them where that fits better.

    Both have the shape (k, 2).  Yaw starts at zero for the navigator, and along the first leg in
    the table of corners.
    """
    there = reached[:, 0] + 1j * reached[:, 1]
    best = []
    for mirror in (1.0, -1.0):
        here = corners[:, 0] + 1j * mirror * corners[:, 1]
        turn = np.sum(there * here.conj())
        here = here * turn / abs(turn)
        best.append((float(np.sum(np.abs(there - here) ** 2)), here))
    _, here = min(best, key=lambda each: each[0])
    return np.stack((here.real, here.imag), axis=1)


def _add_corners(report: Report, walks: Sequence[tuple[Loop, int]]) -> None:
    rows = []
    for loop, true in walks:
        if len(loop.known_w) > 1:
            off, sigma = loop.errors()
            cells = (f'{np.sqrt(np.mean(off**2)):.2f} m', f'{off.max():.2f} m')
            rows.append((loop.name, str(true), *cells, f'{sigma.max():.2f} m'))
            report.figures[f'corners of {loop.name}'] = {
                'error_m': off.tolist(),
                'sigma_m': sigma.tolist(),
            }
        else:
            rows.append((loop.name, str(true), '', '', ''))
    report.add_table(
        'strides counted by the walker; errors at the corners, turned as fits best',
        ('', 'strides', 'RMS', 'most', 'most σ'),
        rows,
    )
