"""Sensor Watch: a wrist at 12.5 and 25 Hz, walking and doing other things; steps counted by hand.

K. Rieck, stepcounter-devel, with recordings by wearers of the Sensor Watch.
"""

from __future__ import annotations

import csv
import gzip
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.accuracy.report import Report
from benchmarks.accuracy.step_counters import PEDOMETER, Count, Stamps, Walk, count
from benchmarks.accuracy.step_times import draw_steps
from benchmarks.accuracy.walks import (
    add_variations,
    add_walks,
    draw,
    error_percent,
    percent,
    spread,
    spread_text,
)
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS

NAME = 'Sensor Watch'
PATTERN = 'sensorwatch_steps'

RATES = {'12hz': 12.5, '25hz': 25.0}
"""Rate [Hz] by what the name says; the stamps in the files are too coarse."""

PACES = ('normal', 'fast', 'slow')
"""Walks by what the name says."""

MOST_STEADY, MOST_ALL = 7.0, 13.0
"""Goals of the mean error [%]: at normal and fast pace, and of all."""

MOST_FALSE_MEAN, MOST_FALSE = 1.0, 10
"""Goals of the false steps of what is no walk."""


def measure(path: Path, output: Path) -> Report:
    """Measure all recordings of the folder."""
    counts = [count(load(recording)) for recording in sorted(path.glob('*.csv.gz'))]
    if not counts:
        raise RecordingError(f'{path}: no *.csv.gz in it; docs/accuracy.md says how to get them')
    report = Report('wrist', f'Sensor Watch, {len(counts)} recordings, all settings default')
    walks = [c for c in counts if _walks(c.walk)]
    others = [c for c in counts if not _walks(c.walk)]
    if walks:
        add_walks(report, 'steps', walks)
        _add_paces(report, walks)
        report.pictures.append(draw(output / 'wrist.png', 'Sensor Watch, on the wrist', walks))
        _draw_worst(report, output / 'wrist-worst.png', walks)
    if others:
        _add_others(report, others)
        _draw_worst(report, output / 'wrist-no-walk.png', others)
    add_variations(
        report,
        [c.walk for c in counts],
        lambda walk, found_ns: (
            error_percent(walk, found_ns) if _walks(walk) else false(walk, found_ns)
        ),
        {
            'normal and fast [%]': lambda walk: _walks(walk) and 'slow' not in walk.name,
            'slow [%]': lambda walk: _walks(walk) and 'slow' in walk.name,
            'no walk [false steps]': lambda walk: not _walks(walk),
        },
    )
    return report


def _walks(walk: Walk) -> bool:
    return 'walking' in walk.name


def false(walk: Walk, found_ns: Stamps) -> int:
    """Return how many steps were found beyond the true ones."""
    return max(0, len(found_ns) - walk.true)


def load(path: Path) -> Walk:
    """Read a recording of magnitudes in counts, whose median is taken for 1 g.

    Raises `RecordingError` where something is wrong.
    """
    name = path.name.removesuffix('.csv.gz')
    rate = next((rate for word, rate in RATES.items() if f'-{word}-' in name), None)
    if rate is None:
        raise RecordingError(f'{path}: its name says none of the rates {", ".join(RATES)}')
    try:
        with gzip.open(path, 'rt', encoding='utf-8', newline='') as lines:
            rows = list(csv.DictReader(lines))
        true = int(rows[0]['Steps'])
        counts = np.array([float(row['Magnitude']) for row in rows])
    except (OSError, KeyError, IndexError, ValueError, TypeError) as error:
        raise RecordingError(f'{path}: {type(error).__name__}, {error}') from error
    force_s = np.zeros((len(counts), 3))
    force_s[:, 2] = counts * (GRAVITY / np.median(counts))
    seconds = 1.0 + np.arange(len(counts)) / rate
    return Walk(name, true, np.round(seconds * NANOSECONDS).astype(np.int64), force_s)


def _add_paces(report: Report, counts: Sequence[Count]) -> None:
    """Add the errors by pace, and the goals."""
    rows = []
    figures = {}
    groups = {'normal and fast': PACES[:2], **{pace: (pace,) for pace in PACES}, 'all': PACES}
    for name, paces in groups.items():
        some = [c for c in counts if any(pace in c.walk.name for pace in paces)]
        if not some:
            continue
        errors = {
            counter: [percent(len(c.found[counter]), c.walk.true) for c in some]
            for counter in some[0].found
        }
        rows.append((f'{name}, {len(some)}', *(f'{spread_text(e)} %' for e in errors.values())))
        figures[name] = {counter: spread(of_all) for counter, of_all in errors.items()}
    report.add_table('error by pace: mean, worst', ('', *counts[0].found), rows)
    report.figures['paces'] = figures
    for name, most in (('normal and fast', MOST_STEADY), ('all', MOST_ALL)):
        if name in figures:
            mean = figures[name][PEDOMETER]['mean']
            report.aim(f'wrist, steps, {name}, mean [%]', mean, most, '{:.1f}')


def _add_others(report: Report, counts: Sequence[Count]) -> None:
    """Add the table of what is no walk: every step beyond the true ones is false."""
    beyond = {name: [false(c.walk, c.found[name]) for c in counts] for name in counts[0].found}
    rows = [
        (
            c.walk.name,
            f'{c.walk.seconds:.0f} s',
            str(c.walk.true),
            *(str(of_all[k]) for of_all in beyond.values()),
        )
        for k, c in enumerate(counts)
    ]
    rows.append(('mean, worst', '', '', *(spread_text(of_all) for of_all in beyond.values())))
    report.add_table('false steps of what is no walk', ('', 'time', 'true', *beyond), rows)
    report.figures['false steps'] = {name: spread(of_all) for name, of_all in beyond.items()}
    ours = spread(beyond[PEDOMETER])
    report.aim('wrist, no walk, false steps, mean', ours['mean'], MOST_FALSE_MEAN, '{:.1f}')
    report.aim('wrist, no walk, false steps, worst', ours['worst'], MOST_FALSE, '{:.0f}')


def _draw_worst(report: Report, path: Path, counts: Sequence[Count]) -> None:
    """Show the recording whose count is the farthest off."""
    worst = max(
        counts, key=lambda c: abs(len(c.found[PEDOMETER]) - c.walk.true) / max(c.walk.true, 1)
    )
    walk, found_ns = worst.walk, worst.found[PEDOMETER]
    title = f'Sensor Watch, worst: {walk.name}, {len(found_ns)} steps, true are {walk.true}'
    report.pictures.append(draw_steps(path, title, walk, found_ns))
