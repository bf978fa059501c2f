"""Time of the documents' programs on a million conversions: ``python -m benchmarks.reference``.

A program is timed as it is used: ``dead-reckoning reference``, a process of its own, from a CSV
file to the last line of its output, and the start of Python with it.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.accuracy.report import table

CONVERSIONS = 1_000_000

SUMMED = 4
"""Conversions of a row for AN-900."""

MBED = (
    *('--calibration-count', '1024', '--window-min=-8', '--window-max', '8'),
    *('--gain', '0.0383', '--update-time', '0.01', '--no-movement', '25'),
)


def main() -> int:
    """Time each program; return 0."""
    generator = np.random.default_rng(1)
    beats = np.sin(np.arange(CONVERSIONS // SUMMED) * (2.0 * np.pi / 15.0))
    sums = 8192 + 1500 * beats[:, None] + generator.normal(0.0, 20.0, (len(beats), 2))
    cases = (
        ('an3397', (), generator.integers(90, 166, (CONVERSIONS, 2)), 'x,y'),
        ('an900', (), np.rint(sums).astype(int), 'x,y'),
        ('mbed', (*MBED, '--sample-count', '32'), _mbed(generator), 'x'),
        ('mbed', (*MBED, '--sample-count', '4'), _mbed(generator), 'x'),
        ('mbed', (*MBED, '--sample-count', '1'), _mbed(generator), 'x'),
    )
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'counts.csv'
        for name, options, counts, header in cases:
            np.savetxt(path, counts, fmt='%d', delimiter=',', header=header, comments='')
            seconds, lines = _timed((name, *options, str(path)))
            rows.append((' '.join((name, *options[-2:])), f'{lines}', f'{seconds:.2f} s'))
    print(table(('program', 'rows', '1,000,000 conversions'), rows))
    return 0


def _mbed(generator: np.random.Generator) -> np.ndarray:
    return generator.integers(-300, 301, (CONVERSIONS, 1))


def _timed(arguments: tuple[str, ...]) -> tuple[float, int]:
    command = [sys.executable, '-m', 'dead_reckoning.tools.main', 'reference', *arguments]
    begin = time.perf_counter()
    output = subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout
    return time.perf_counter() - begin, output.count(b'\n') - 1


if __name__ == '__main__':
    sys.exit(main())
