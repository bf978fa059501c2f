"""Tables and pictures of steps counted beside the true ones, over all walks of a set."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.accuracy import pictures
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.step_counters import (
    OTHERS,
    PEDOMETER,
    Count,
    Stamps,
    Walk,
    published,
)

VARIATIONS = {
    'as recorded': (1.0, 1.0),
    'amplitude × 0.4': (0.4, 1.0),
    'amplitude × 2': (2.0, 1.0),
    'time × 0.75': (1.0, 0.75),
    'time × 1.3': (1.0, 1.3),
}
"""How much more the norm swings about its median, and how much longer it takes."""


def percent(counted: int, true: int) -> float:
    """Return the error of a count in per cent of the true steps."""
    return 100.0 * (counted - true) / true


def error_percent(walk: Walk, found_ns: Stamps) -> float:
    """Return the error of the steps found in per cent of the true ones."""
    return percent(len(found_ns), walk.true)


def spread(errors: Sequence[float]) -> dict[str, float]:
    """Return the mean of the magnitudes of errors, and the worst."""
    sizes = np.abs(errors)
    return {'mean': float(sizes.mean()), 'worst': float(sizes.max())}


def spread_text(errors: Sequence[float], form: str = '{:.1f}') -> str:
    """Write the mean of the magnitudes, and the worst."""
    return ', '.join(form.format(value) for value in spread(errors).values())


def add_walks(report: Report, caption: str, counts: Sequence[Count]) -> dict[str, list[float]]:
    """Add the table of some walks that have true steps; return the errors [%] of each counter."""
    errors = {
        name: [error_percent(c.walk, c.found[name]) for c in counts]
        for name in (PEDOMETER, *OTHERS)
    }
    rows = [
        (
            c.walk.name,
            f'{c.walk.seconds:.0f} s',
            str(c.walk.true),
            str(len(c.found[PEDOMETER])),
            *(f'{of_all[k]:+.1f} %' for of_all in errors.values()),
        )
        for k, c in enumerate(counts)
    ]
    rows.append(('mean, worst', '', '', '', *(f'{spread_text(e)} %' for e in errors.values())))
    report.add_table(caption, ('', 'time', 'true', 'counted', *errors), rows)
    report.figures[caption] = {
        'percent': {name: spread(of_all) for name, of_all in errors.items()},
        'walks': {
            c.walk.name: {'true': c.walk.true, **{name: len(f) for name, f in c.found.items()}}
            for c in counts
        },
    }
    return errors


def add_variations(
    report: Report,
    walks: Sequence[Walk],
    error: Callable[[Walk, Stamps], float],
    groups: Mapping[str, Callable[[Walk], bool]],
) -> None:
    """Add what the pedometer makes of the walks, were they softer, harder, faster and slower.

    ``error`` is given the steps as they would be in the walk as it was recorded.
    """
    rows = []
    figures: dict[str, dict[str, dict[str, float]]] = {}
    present = {name: chosen for name, chosen in groups.items() if any(map(chosen, walks))}
    for variation, (amplitude, duration) in VARIATIONS.items():
        errors = []
        for walk in walks:
            found_ns = published(walk.varied(amplitude, duration)).stamps_ns
            errors.append(error(walk, walk.stretched(found_ns, 1.0 / duration)))
        of = {
            name: [e for e, walk in zip(errors, walks, strict=True) if chosen(walk)]
            for name, chosen in present.items()
        }
        rows.append((variation, *map(spread_text, of.values())))
        figures[variation] = {name: spread(some) for name, some in of.items()}
    report.add_table('pedometer on what was changed: mean error, worst', ('', *present), rows)
    report.figures['variations'] = figures


def draw(path: Path, title: str, counts: Sequence[Count]) -> Path:
    """Show the error of each count as bars."""
    figure, axes = pictures.one(title, max(5.6, 0.24 * len(counts)))
    place = np.arange(len(counts))
    names = [c.walk.name.replace('_', ' ') for c in counts]
    shown = ((PEDOMETER, pictures.RUNS[0]), ('find_peaks', pictures.TRUTH['color']))
    for side, (name, colour) in zip((-0.2, 0.2), shown, strict=True):
        errors = [error_percent(c.walk, c.found[name]) for c in counts]
        axes.barh(place + side, errors, 0.4, color=colour, label=name)
    axes.axvline(0.0, color='black', linewidth=0.8)
    axes.set_yticks(place, names)
    axes.invert_yaxis()
    axes.set_xlabel('counted beyond the true steps [%]')
    pictures.legend_above(axes)
    return pictures.save(figure, path)
