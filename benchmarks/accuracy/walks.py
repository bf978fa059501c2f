"""Steps counted by the pedometer beside the true ones, over all walks of a set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, find_peaks, sosfiltfilt

from benchmarks.accuracy import pictures
from benchmarks.accuracy.report import Report
from dead_reckoning.core.errors import SampleError
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.core.samples import NANOSECONDS, ImuSample
from dead_reckoning.core.step_detectors.an900 import An900Settings

Array = NDArray[np.float64]

BAND = (0.7, 3.0)
"""Band of the reference [Hz]."""

PROMINENCE = 1.0
"""Smallest prominence of a peak of the reference [m/s²], the best of those tried."""

REFERENCE_RATE = 50.0
"""Rate of the reference [Hz]; a recording that is slower keeps its own."""


@dataclass(frozen=True)
class Walk:
    """One recording: ``stamps_ns``, shape (n,), as they came; ``force_s``, shape (n, 3) [m/s²]."""

    name: str
    true: int
    stamps_ns: NDArray[np.int64]
    force_s: Array

    @property
    def seconds(self) -> float:
        """Time from the first stamp to the last [s]."""
        return float(np.ptp(self.stamps_ns)) / NANOSECONDS


@dataclass(frozen=True)
class Count:
    """What was counted on a walk; ``refused`` samples came too late or twice."""

    walk: Walk
    counted: int
    reference: int
    refused: int


def count(walk: Walk) -> Count:
    """Count the steps with all settings at their defaults, and with the reference."""
    pedometer = Pedometer(PedometerSettings(), An900Settings())
    refused = 0
    rows = zip(walk.stamps_ns.tolist(), walk.force_s.tolist(), strict=True)
    for stamp_ns, (x, y, z) in rows:
        try:
            pedometer.update(ImuSample(stamp_ns, 'imu_link', (x, y, z)))
        except SampleError:
            refused += 1
    return Count(walk, pedometer.steps, count_peaks(walk), refused)


def count_peaks(walk: Walk) -> int:
    """Count the peaks of the norm in the band of steps, which needs the whole recording."""
    order = np.argsort(walk.stamps_ns, kind='stable')
    time = (walk.stamps_ns[order] - walk.stamps_ns[order[0]]) / NANOSECONDS
    rate = min(REFERENCE_RATE, (len(time) - 1) / time[-1])
    norm = np.linalg.norm(walk.force_s[order], axis=1)
    even = np.interp(np.arange(0.0, time[-1], 1.0 / rate), time, norm)
    band = butter(2, BAND, 'bandpass', fs=rate, output='sos')
    peaks, _ = find_peaks(sosfiltfilt(band, even - even.mean()), prominence=PROMINENCE)
    return len(peaks)


def percent(counted: int, true: int) -> float:
    """Return the error of a count in per cent of the true steps."""
    return 100.0 * (counted - true) / true


def add_walks(report: Report, caption: str, counts: Sequence[Count]) -> None:
    """Add the table of some walks that have true steps, and what it comes to."""
    rows = []
    for c in counts:
        true = c.walk.true
        rows.append(
            (
                c.walk.name,
                f'{c.walk.seconds:.0f} s',
                str(true),
                str(c.counted),
                f'{percent(c.counted, true):+.1f} %',
                str(c.reference),
                f'{percent(c.reference, true):+.1f} %',
            )
        )
    report.add_table(
        caption, ('', 'time', 'true', 'counted', 'error', 'find_peaks', 'error'), rows
    )
    figures = {}
    lines = []
    for name, key in (('counted', 'counted'), ('find_peaks', 'reference')):
        errors = [abs(percent(getattr(c, key), c.walk.true)) for c in counts]
        figures[name] = {'mean_percent': float(np.mean(errors)), 'worst_percent': max(errors)}
        lines.append(f'{name} {np.mean(errors):.1f} %, worst {max(errors):.1f} %')
    report.text.append(f'  mean error: {"; ".join(lines)}')
    report.figures[caption] = {
        **figures,
        'walks': {
            c.walk.name: {'true': c.walk.true, 'counted': c.counted, 'find_peaks': c.reference}
            for c in counts
        },
    }


def draw(path: Path, title: str, counts: Sequence[Count]) -> Path:
    """Show the error of each count as bars."""
    figure, axes = pictures.one(title)
    place = np.arange(len(counts))
    names = [c.walk.name.replace('_', ' ') for c in counts]
    ours = [percent(c.counted, c.walk.true) for c in counts]
    theirs = [percent(c.reference, c.walk.true) for c in counts]
    axes.barh(place - 0.2, ours, 0.4, color=pictures.RUNS[0], label='pedometer')
    axes.barh(place + 0.2, theirs, 0.4, color=pictures.TRUTH['color'], label='find_peaks')
    axes.axvline(0.0, color='black', linewidth=0.8)
    axes.set_yticks(place, names)
    axes.invert_yaxis()
    axes.set_xlabel('counted beyond the true steps [%]')
    pictures.legend_above(axes)
    return pictures.save(figure, path)
