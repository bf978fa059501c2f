"""OpenShoe: loops with a sensor in the sole of a shoe, ended within 1 cm of where they began.

I. Skog, P. Händel, J.-O. Nilsson, J. Rantakokko, "Zero-Velocity Detection—An Algorithm
Evaluation", IEEE Trans. Biomed. Eng. 57(11), 2010, doi 10.1109/TBME.2010.2060723.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.accuracy.inertial import (
    CAUSAL,
    SMOOTHED,
    Recording,
    block_means,
    numbers,
)
from benchmarks.accuracy.loops import Loop, add_loops, draw, walk_loop
from benchmarks.accuracy.report import Report
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.rest import GRAVITY

NAME = 'OpenShoe'
PATTERN = 'openshoe'

RATES = (100.0, 50.0)
"""Rates [Hz] that the recordings are brought down to."""

MEDIAN, WORST = 0.20, 0.50
"""Goals [% of the way]."""


def measure(path: Path, output: Path) -> Report:
    """Measure all loops of the folder."""
    recordings = [load(found) for found in sorted(path.glob('*.npz'))]
    if not recordings:
        raise RecordingError(f'{path}: no *.npz in it; docs/accuracy.md says how to get them')
    report = Report('openshoe', f'OpenShoe, {len(recordings)} loops on a foot')
    loops = [walk_loop(recording) for recording in recordings]
    add_loops(report, 'horizontal error at the end, height, strides', loops)
    rows = [(f'{1.0 / np.median(np.diff(recordings[0].time)):.0f} Hz', loops)]
    for rate in RATES:
        slower = [block_means(recording, rate) for recording in recordings]
        rows.append((f'{rate:.0f} Hz', [walk_loop(each) for each in slower]))
    _add_rates(report, rows)
    for way in (CAUSAL, SMOOTHED):
        median, worst = percents(loops, way)
        report.aim(f'OpenShoe, end error, median [%], {way}', median, MEDIAN)
        report.aim(f'OpenShoe, end error, worst [%], {way}', worst, WORST)
    full, _ = percents(loops, CAUSAL)
    for rate, (_, slow) in zip(RATES, rows[1:], strict=True):
        ratio = percents(slow, CAUSAL)[0] / full
        report.aim(f'OpenShoe, {rate:.0f} Hz, times the median, causal', ratio, 2.0)
    report.pictures.append(draw(output / 'openshoe.png', report.title, loops))
    return report


def load(path: Path) -> Recording:
    """Read one loop; raises `RecordingError` where something is missing."""
    with np.load(path) as data:
        force_g, turn_s, rate = numbers(path, data, ('acc_g', 'gyr', 'fs'))
    return Recording(path.stem, np.arange(len(turn_s)) / float(rate), force_g * GRAVITY, turn_s)


def percents(loops: Sequence[Loop], way: str) -> tuple[float, float]:
    """Return median and worst of the errors at the end [% of the way]."""
    errors = [loop.percent(way) for loop in loops]
    return float(np.median(errors)), max(errors)


def _add_rates(report: Report, measured: Sequence[tuple[str, Sequence[Loop]]]) -> None:
    names = list(measured[0][1][0].ways)
    rows = []
    for rate, loops in measured:
        found = {way: percents(loops, way) for way in names}
        rows.append((rate, *(f'{median:.3f}, {worst:.3f}' for median, worst in found.values())))
        report.figures[rate] = {
            way: {'median_percent': median, 'worst_percent': worst}
            for way, (median, worst) in found.items()
        }
    report.add_table(
        'error at the end [% of the way], median and worst; lower rates by means',
        ('', *names),
        rows,
    )
