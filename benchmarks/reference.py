"""Time of the documents' programs on a million conversions: ``python -m benchmarks.reference``.

A program is timed as it is used: ``dead-reckoning reference``, a process of its own, from a CSV
file to the last line of its output in another, and the start of Python with it; beside that, the
algorithm alone, from counts to results in memory.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence, Sized
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.reference import an900, an3397, mbed
from dead_reckoning.core.reference.mbed import Constants
from dead_reckoning.tools.table import table

CONVERSIONS = 1_000_000

SUMMED = 4
"""Conversions of a row for AN-900."""

MBED = Constants(
    calibration_count=1024,
    sample_count=32,
    window_min=-8.0,
    window_max=8.0,
    gain=0.0383,
    update_time=0.01,
    no_movement=25,
)

Counts = NDArray[np.int64]


def main() -> int:
    """Time each program; return 0."""
    generator = np.random.default_rng(1)
    beats = np.sin(np.arange(CONVERSIONS // SUMMED) * (2.0 * np.pi / 15.0))
    sums = 8192 + 1500 * beats[:, None] + generator.normal(0.0, 20.0, (len(beats), 2))
    pairs = generator.integers(90, 166, (CONVERSIONS, 2))
    single = generator.integers(-300, 301, (CONVERSIONS, 1))
    rows = [
        _row('an3397', ('an3397',), pairs, an3397.run),
        _row('an900', ('an900',), np.rint(sums).astype(np.int64), an900.run),
    ]
    for count in (32, 4, 1):
        constants = replace(MBED, sample_count=count)
        options = [
            f'--{name.replace("_", "-")}={value}' for name, value in asdict(constants).items()
        ]
        algorithm = partial(_mbed, constants=constants)
        rows.append(_row(f'mbed, {count} an update', ('mbed', *options), single, algorithm))
    print(table(('program', 'rows', '1,000,000 conversions', 'the algorithm alone'), rows))
    return 0


def _mbed(counts: Counts, constants: Constants) -> Sized:
    return mbed.run(counts[:, 0], constants)


def _row(
    name: str, arguments: Sequence[str], counts: Counts, algorithm: Callable[[Counts], Sized]
) -> tuple[str, str, str, str]:
    begin = time.perf_counter()
    updates = algorithm(counts)
    alone = time.perf_counter() - begin
    header = 'x,y' if counts.shape[1] == 2 else 'x'
    with tempfile.TemporaryDirectory() as folder:
        source, result = Path(folder) / 'counts.csv', Path(folder) / 'result.csv'
        np.savetxt(source, counts, fmt='%d', delimiter=',', header=header, comments='')
        command = [sys.executable, '-m', 'dead_reckoning.tools.main', 'reference', *arguments]
        begin = time.perf_counter()
        with result.open('wb') as output:
            subprocess.run([*command, str(source)], check=True, stdout=output)
        seconds = time.perf_counter() - begin
        printed = result.read_bytes().count(b'\n') - 1
    if printed != len(updates):
        raise AssertionError(f'{name}: {len(updates)} updates, but {printed} rows')
    return name, f'{printed}', f'{seconds:.2f} s', f'{alone:.2f} s'


if __name__ == '__main__':
    sys.exit(main())
