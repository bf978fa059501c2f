"""``odometry.csv`` and ``odometry.tum``: a row for each state of the integrator."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.stages import ODOMETRY
from dead_reckoning.tables import ODOMETRY_COLUMNS, lines, odometry_columns
from dead_reckoning.tools.replay.outputs import Takers
from dead_reckoning.tools.replay.task import Task

FILES = ('odometry.csv', 'odometry.tum')
NEEDS = ODOMETRY


@contextmanager
def write(folder: Path, task: Task) -> Iterator[Takers]:
    """Write both as states come."""
    with (folder / FILES[0]).open('w') as table, (folder / FILES[1]).open('w') as tum:
        table.write(','.join(ODOMETRY_COLUMNS) + '\n')

        def take(block: StateBlock) -> None:
            columns = odometry_columns(block)
            table.write(lines(columns))
            stamps, poses = columns[:2]
            tum.write(lines([seconds(stamps), [pose.replace(',', ' ') for pose in poses]], ' '))

        yield {ODOMETRY: take}


def seconds(nanoseconds: Sequence[str]) -> list[str]:
    """Turn whole nanoseconds into seconds, as text and so exactly."""
    if min(map(len, nanoseconds)) < 11:  # around the first second of 1970
        nanoseconds = [f'{int(text):0{10 + (text[0] == "-")}}' for text in nanoseconds]
    return [f'{text[:-9]}.{text[-9:]}' for text in nanoseconds]
