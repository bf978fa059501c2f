"""Oxford step counter: phones in hands, pockets and bags, with switches under both feet.

D. Salvi, C. Velardo, J. Brynes, L. Tarassenko, "An Optimised Algorithm for Accurate Steps Counting
From Smart-Phone Accelerometry", EMBC 2018, doi 10.1109/EMBC.2018.8513319.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.accuracy.report import Report
from benchmarks.accuracy.walks import Walk, add_walks, count, draw
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.samples import NANOSECONDS

NAME = 'Oxford'
PATTERN = 'oxford_step_counter'

ENDING = '_accelerometer.csv.gz'

BOUNCE = 0.6
"""Edges of one foot's switch closer than this [s] are one step."""


def measure(path: Path, output: Path) -> Report:
    """Measure all walks of the folder."""
    found = sorted(path.glob(f'*{ENDING}'))
    if not found:
        raise RecordingError(f'{path}: no *{ENDING} in it; docs/accuracy.md says how to get them')
    counts = [count(load(walk)) for walk in found]
    report = Report('oxford', f'Oxford step counter, {len(counts)} walks, all settings default')
    add_walks(report, 'steps', counts)
    refused, samples = sum(c.refused for c in counts), sum(len(c.walk.stamps_ns) for c in counts)
    report.text.append(f'  refused for their stamps: {refused} of {samples} samples')
    report.figures['samples'] = {'refused': refused, 'all': samples}
    report.pictures.append(draw(output / 'oxford.png', 'Oxford step counter', counts))
    return report


def load(path: Path) -> Walk:
    """Read a walk and the switches beside it; raises `RecordingError` where something is wrong."""
    name = path.name.removesuffix(ENDING)
    switches = path.with_name(f'{name}_stepcounter.csv.gz')
    try:
        moments = np.loadtxt(path, delimiter=',', usecols=0, dtype=np.int64, ndmin=1)
        force_s = np.loadtxt(path, delimiter=',', usecols=(2, 3, 4), ndmin=2)
        feet = np.loadtxt(switches, delimiter=',', dtype=np.int64, ndmin=2)
        first, last = feet[0, 0], feet[-1, 0]
        true = sum(landings(feet[:, 0], feet[:, foot]) for foot in (1, 2))
    except (OSError, ValueError, IndexError) as error:
        raise RecordingError(f'{name}: {error}') from error
    within = (moments >= first) & (moments <= last)
    if not within.any():
        raise RecordingError(f'{path}: no sample between the first and the last of {switches}')
    return Walk(name.removeprefix('opt_'), true, moments[within], force_s[within])


def landings(stamps_ns: np.ndarray, switch: np.ndarray) -> int:
    """Count how often a foot comes down, without the bounces of its switch.

    ``stamps_ns`` and ``switch``, 0 or 1, have the shape (n,).
    """
    down = stamps_ns[1:][(switch[1:] == 1) & (switch[:-1] == 0)]
    landed = 0
    before = None
    for stamp_ns in down.tolist():
        if before is None or stamp_ns - before >= BOUNCE * NANOSECONDS:
            landed += 1
            before = stamp_ns
    return landed
