"""Command line: measure what there is under DATA, print tables, write figures and pictures."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from types import ModuleType

from benchmarks.accuracy import (
    aided_drives,
    airbrakes,
    broad,
    consistency,
    gaitmap,
    gcp,
    inclination,
    jackal,
    mobgap,
    navigator_cost,
    openshoe,
    oxford,
    paces,
    pedometer_cost,
    sensors,
    simulated_steps,
    slopes,
    smoothing,
    step_lengths,
    wrist,
    xio,
)
from benchmarks.accuracy.report import Report
from dead_reckoning.core.errors import DeadReckoningError
from dead_reckoning.tools.table import table

KINDS = (
    jackal,
    broad,
    airbrakes,
    oxford,
    wrist,
    mobgap,
    step_lengths,
    openshoe,
    gcp,
    xio,
    gaitmap,
    inclination,
)
"""One module per kind of recording; each has NAME, PATTERN and `measure`."""

SIMULATED = (
    simulated_steps,
    paces,
    pedometer_cost,
    slopes,
    smoothing,
    sensors,
    consistency,
    aided_drives,
    navigator_cost,
)
"""What needs no recording; each has NAME and `measure`."""


def main() -> int:
    """Return 0 if all went well, 1 if a benchmark found a fault, 2 if there was nothing."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.accuracy', description=__doc__)
    parser.add_argument('data', type=Path, help='folder of the recordings: docs/accuracy.md')
    parser.add_argument(
        '--output', type=Path, default=Path('out/accuracy'), help='folder for what is written'
    )
    parser.add_argument(
        '--only', nargs='+', choices=[_name(part) for part in (*KINDS, *SIMULATED)], help='parts'
    )
    arguments = parser.parse_args()
    output = arguments.output
    output.mkdir(parents=True, exist_ok=True)
    chosen = arguments.only or [_name(part) for part in (*KINDS, *SIMULATED)]
    work: list[tuple[str, str, Callable[[], Report]]] = []
    for kind in KINDS:
        if _name(kind) in chosen:
            found = sorted(arguments.data.glob(kind.PATTERN))
            if not found:
                print(f'{kind.NAME}: no {arguments.data / kind.PATTERN}, skipped', flush=True)
            work += [(kind.NAME, str(path), partial(kind.measure, path, output)) for path in found]
    if not work and not arguments.only:
        print(
            f'{arguments.data}: none of the recordings is there; see docs/accuracy.md',
            file=sys.stderr,
        )
        return 2
    for part in SIMULATED:
        if _name(part) in chosen:
            work.append((part.NAME, 'nothing recorded', partial(part.measure, output)))
    reports: list[Report] = []
    faults = []
    for name, what, measure in work:
        print(f'{name}: measuring {what}', flush=True)
        try:
            report = measure()
        except DeadReckoningError as error:
            faults.append(f'{name}: {error}')
            continue
        print('\n' + '\n\n'.join([report.title, *report.text]) + '\n', flush=True)
        reports.append(report)
        faults += [f'{report.title}: {fault}' for fault in report.faults]
        for picture in report.pictures:
            print(f'picture  {picture}')
    _say_goals(reports)
    if reports:
        written = output / 'accuracy.json'
        figures = {report.name: report.figures for report in reports}
        figures['goals'] = [goal._asdict() for report in reports for goal in report.goals]
        written.write_text(json.dumps(figures, indent=2) + '\n', encoding='utf-8')
        print(f'figures  {written}')
    for fault in faults:
        print(f'FAULT    {fault}', file=sys.stderr)
    return 1 if faults else 0 if reports else 2


def _name(part: ModuleType) -> str:
    return part.__name__.rpartition('.')[2]


def _say_goals(reports: Sequence[Report]) -> None:
    """Print what is to be reached, and whether it is."""
    goals = [goal for report in reports for goal in report.goals]
    if goals:
        words = {True: 'met', False: 'missed', None: 'open'}
        rows = [(goal.what, goal.wanted, goal.found, words[goal.met]) for goal in goals]
        print('\ngoals\n' + table(('', 'wanted', 'found', ''), rows) + '\n')


if __name__ == '__main__':
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
