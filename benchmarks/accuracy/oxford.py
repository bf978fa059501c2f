"""Oxford step counter: phones in hands, pockets and bags, with switches under both feet.

D. Salvi, C. Velardo, J. Brynes, L. Tarassenko, "An Optimised Algorithm for Accurate Steps Counting
From Smart-Phone Accelerometry", EMBC 2018, doi 10.1109/EMBC.2018.8513319.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.accuracy.report import Report
from benchmarks.accuracy.step_counters import PEDOMETER, Count, Stamps, Walk, count
from benchmarks.accuracy.step_times import against_truth, common_lag, draw_steps, f1
from benchmarks.accuracy.walks import add_variations, add_walks, draw, error_percent, spread
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.samples import NANOSECONDS

NAME = 'Oxford'
PATTERN = 'oxford_step_counter'

ENDING = '_accelerometer.csv.gz'

BOUNCE = 0.6
"""Edges of one foot's switch closer than this [s] are one step."""

MOST_MEAN, MOST_WORST = 0.9, 3.0
"""Goals of the count [%]."""

LEAST_MEAN, LEAST_WORST = 0.95, 0.85
"""Goals of F1 of the step times."""

MOST_LATE = 1
"""Goal [steps]: of those made later when one comes out."""


def measure(path: Path, output: Path) -> Report:
    """Measure all walks of the folder."""
    found = sorted(path.glob(f'*{ENDING}'))
    if not found:
        raise RecordingError(f'{path}: no *{ENDING} in it; docs/accuracy.md says how to get them')
    counts = [count(load(walk)) for walk in found]
    report = Report('oxford', f'Oxford step counter, {len(counts)} walks, all settings default')
    ours = spread(add_walks(report, 'steps', counts)[PEDOMETER])
    report.aim('Oxford, steps, mean [%]', ours['mean'], MOST_MEAN, '{:.1f}')
    report.aim('Oxford, steps, worst [%]', ours['worst'], MOST_WORST, '{:.1f}')
    refused, samples = (
        sum(c.published.refused for c in counts),
        sum(len(c.walk.stamps_ns) for c in counts),
    )
    report.text.append(f'  refused for their stamps: {refused} of {samples} samples')
    report.figures['samples'] = {'refused': refused, 'all': samples}
    add_variations(report, [c.walk for c in counts], error_percent, {'steps [%]': lambda _: True})
    report.pictures.append(draw(output / 'oxford.png', 'Oxford step counter', counts))
    _add_times(report, output, counts)
    return report


def _add_times(report: Report, output: Path, counts: Sequence[Count]) -> None:
    """Add how the stamps of the steps fit the switches, and how late they come out."""
    fits: dict[str, list[float]] = {}
    lags: dict[str, float] = {}
    for name in counts[0].found:
        pairs = against_truth(counts, name)
        lag = lags[name] = common_lag(pairs)
        fits[name] = [f1(stamps - lag, true) for stamps, true in pairs]
    late = [c.published.steps_late for c in counts]
    rows = [
        (
            c.walk.name,
            *(f'{of_all[k]:.3f}' for of_all in fits.values()),
            f'{_largest(c.published.latency[c.published.going]):.2f} s',
            f'{_largest(late[k]):.0f}',
        )
        for k, c in enumerate(counts)
    ]
    rows += [
        ('mean', *(f'{np.mean(of_all):.3f}' for of_all in fits.values()), '', ''),
        ('lag', *(f'{lag:+.2f} s' for lag in lags.values()), '', ''),
    ]
    report.add_table(
        'F1 of the step times against the switches; how late a step comes out at most',
        ('', *fits, 'late', 'steps late'),
        rows,
    )
    ours = fits[PEDOMETER]
    report.figures['step times'] = {
        name: {'lag_s': lags[name], 'mean': float(np.mean(of_all)), 'worst': min(of_all)}
        for name, of_all in fits.items()
    }
    report.reach('Oxford, step times, F1, mean', float(np.mean(ours)), LEAST_MEAN, '{:.3f}')
    report.reach('Oxford, step times, F1, worst', min(ours), LEAST_WORST, '{:.3f}')
    most = max(map(_largest, late))
    report.figures['steps late'] = most
    report.aim('Oxford, a step comes out late, worst [steps]', most, MOST_LATE, '{:.0f}')
    worst = int(np.argmin(ours))
    good = int(np.argmax(ours))
    for which, k in (('good', good), ('worst', worst)):
        c = counts[k]
        title = f'Oxford, {which}: {c.walk.name}, F1 {ours[k]:.3f}'
        place = output / f'oxford-{which}.png'
        report.pictures.append(
            draw_steps(place, title, c.walk, c.found[PEDOMETER], lags[PEDOMETER])
        )


def _largest(values: np.ndarray) -> float:
    return float(values.max()) if len(values) else 0.0


def load(path: Path) -> Walk:
    """Read a walk and the switches beside it; raises `RecordingError` where something is wrong."""
    name = path.name.removesuffix(ENDING)
    switches = path.with_name(f'{name}_stepcounter.csv.gz')
    try:
        moments = np.loadtxt(path, delimiter=',', usecols=0, dtype=np.int64, ndmin=1)
        force_s = np.loadtxt(path, delimiter=',', usecols=(2, 3, 4), ndmin=2)
        feet = np.loadtxt(switches, delimiter=',', dtype=np.int64, ndmin=2)
        first, last = feet[0, 0], feet[-1, 0]
        landed = np.sort(np.concatenate([landings(feet[:, 0], feet[:, foot]) for foot in (1, 2)]))
    except (OSError, ValueError, IndexError) as error:
        raise RecordingError(f'{name}: {error}') from error
    within = (moments >= first) & (moments <= last)
    if not within.any():
        raise RecordingError(f'{path}: no sample between the first and the last of {switches}')
    if not len(landed):
        raise RecordingError(f'{switches}: no foot comes down')
    return Walk(name.removeprefix('opt_'), len(landed), moments[within], force_s[within], landed)


def landings(stamps_ns: Stamps, switch: np.ndarray) -> Stamps:
    """Return when a foot comes down, without the bounces of its switch.

    ``stamps_ns`` and ``switch``, 0 or 1, have the shape (n,).
    """
    down = stamps_ns[1:][(switch[1:] == 1) & (switch[:-1] == 0)]
    landed: list[int] = []
    for stamp_ns in down.tolist():
        if not landed or stamp_ns - landed[-1] >= BOUNCE * NANOSECONDS:
            landed.append(stamp_ns)
    return np.array(landed, np.int64)
