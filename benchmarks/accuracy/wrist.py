"""Sensor Watch: a wrist at 12.5 and 25 Hz, walking and doing other things; steps counted by hand.

K. Rieck, stepcounter-devel, with recordings by wearers of the Sensor Watch.
"""

from __future__ import annotations

import csv
import gzip
from pathlib import Path

import numpy as np

from benchmarks.accuracy.report import Report
from benchmarks.accuracy.walks import Count, Walk, add_walks, count, draw
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS

NAME = 'Sensor Watch'
PATTERN = 'sensorwatch_steps'

RATES = {'12hz': 12.5, '25hz': 25.0}
"""Rate [Hz] by what the name says; the stamps in the files are too coarse."""


def measure(path: Path, output: Path) -> Report:
    """Measure all recordings of the folder."""
    counts = [count(load(recording)) for recording in sorted(path.glob('*.csv.gz'))]
    if not counts:
        raise RecordingError(f'{path}: no *.csv.gz in it; docs/accuracy.md says how to get them')
    report = Report('wrist', f'Sensor Watch, {len(counts)} recordings, all settings default')
    walks = [c for c in counts if 'walking' in c.walk.name]
    if walks:
        add_walks(report, 'steps', walks)
        report.pictures.append(draw(output / 'wrist.png', 'Sensor Watch, on the wrist', walks))
    _add_others(report, [c for c in counts if 'walking' not in c.walk.name])
    return report


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


def _add_others(report: Report, counts: list[Count]) -> None:
    """Add the table of what is no walk: every step beyond the true ones is false."""
    if not counts:
        return
    rows = []
    false: dict[str, list[int]] = {'counted': [], 'find_peaks': []}
    for c in counts:
        false['counted'].append(max(0, c.counted - c.walk.true))
        false['find_peaks'].append(max(0, c.reference - c.walk.true))
        rows.append(
            (
                c.walk.name,
                f'{c.walk.seconds:.0f} s',
                str(c.walk.true),
                *(str(values[-1]) for values in false.values()),
            )
        )
    report.add_table(
        'false steps of what is no walk', ('', 'time', 'true', 'counted', 'find_peaks'), rows
    )
    report.text.append(
        '  false steps of a recording: '
        + '; '.join(f'{n} {np.mean(v):.1f}, worst {max(v)}' for n, v in false.items())
    )
    report.figures['false steps'] = {
        name: {'mean': float(np.mean(values)), 'worst': max(values)}
        for name, values in false.items()
    }
