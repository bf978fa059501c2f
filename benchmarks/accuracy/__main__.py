"""Command line: measure what there is under DATA, print tables, write figures and pictures."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from benchmarks.accuracy import airbrakes, broad, jackal, oxford, wrist
from dead_reckoning.core.errors import DeadReckoningError

KINDS = (jackal, broad, airbrakes, oxford, wrist)
"""One module per kind of recording; each has NAME, PATTERN and `measure`."""


def main() -> int:
    """Return 0 if all went well, 1 if a benchmark found a fault, 2 if there was nothing."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.accuracy', description=__doc__)
    parser.add_argument('data', type=Path, help='folder of the recordings: docs/accuracy.md')
    parser.add_argument(
        '--output', type=Path, default=Path('out/accuracy'), help='folder for what is written'
    )
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    figures = {}
    faults = []
    for kind in KINDS:
        found = sorted(arguments.data.glob(kind.PATTERN))
        if not found:
            print(f'{kind.NAME}: no {arguments.data / kind.PATTERN}, skipped', flush=True)
        for path in found:
            print(f'{kind.NAME}: measuring {path}', flush=True)
            try:
                report = kind.measure(path, arguments.output)
            except DeadReckoningError as error:
                faults.append(f'{kind.NAME}: {error}')
                continue
            print('\n' + '\n\n'.join([report.title, *report.text]) + '\n', flush=True)
            figures[report.name] = report.figures
            faults += [f'{report.title}: {fault}' for fault in report.faults]
            for picture in report.pictures:
                print(f'picture  {picture}')
    if figures:
        written = arguments.output / 'accuracy.json'
        written.write_text(json.dumps(figures, indent=2) + '\n', encoding='utf-8')
        print(f'figures  {written}')
    for fault in faults:
        print(f'FAULT    {fault}', file=sys.stderr)
    if faults:
        return 1
    if not figures:
        print(
            f'{arguments.data}: none of the recordings is there; see docs/accuracy.md',
            file=sys.stderr,
        )
        return 2
    return 0


if __name__ == '__main__':
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
