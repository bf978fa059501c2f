"""x-io Gait-Tracking: an NGIMU on a foot, walks that end where they began.

github.com/xioTechnologies/Gait-Tracking
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.accuracy.inertial import CAUSAL, SMOOTHED, Recording
from benchmarks.accuracy.loops import add_loops, draw, walk_loop
from benchmarks.accuracy.report import Report
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.rest import GRAVITY

NAME = 'x-io'
PATTERN = 'xio_gait_tracking/*.csv.gz'

THEIRS = {'short_walk': 0.082, 'long_walk': 0.421}
"""What the authors' own program leaves at the end, offline [m]."""

GOALS = {'short_walk': 0.080}
"""Goals of the same [m]."""


def measure(path: Path, output: Path) -> Report:
    """Measure one recording."""
    loop = walk_loop(load(path))
    report = Report(f'xio-{loop.name}', f'x-io, {loop.name} on a foot')
    add_loops(report, 'horizontal error at the end, height, strides', [loop])
    errors = {way: f'{1000.0 * loop.end_3d(way):.0f} mm' for way in loop.ways}
    if loop.name in THEIRS:
        errors['its authors'] = f'{1000.0 * THEIRS[loop.name]:.0f} mm'
    report.add_table('error at the end in 3-D', tuple(errors), [tuple(errors.values())])
    if loop.name in GOALS:
        for way in (CAUSAL, SMOOTHED):
            what = f'x-io {loop.name}, end error in 3-D [m], {way}'
            report.aim(what, loop.end_3d(way), GOALS[loop.name], '{:.3f}')
    report.pictures.append(draw(output / f'{report.name}.png', report.title, [loop]))
    return report


def load(path: Path) -> Recording:
    """Read a recording in s, °/s and g; raises `RecordingError` where something is wrong."""
    try:
        rows = np.loadtxt(path, delimiter=',', skiprows=1, ndmin=2)
        time, turn, force = rows[:, 0], rows[:, 1:4], rows[:, 4:7]
        if force.shape[1] != 3:
            raise ValueError(f'{rows.shape[1]} columns instead of 7')
    except (OSError, ValueError, IndexError) as error:
        raise RecordingError(f'{path}: {error}') from error
    name = path.name.removesuffix('.csv.gz')
    return Recording(name, time, force * GRAVITY, np.radians(turn))
