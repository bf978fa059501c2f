"""``smoothed.csv``: a row for each state of the navigator, as all samples together show it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile

from dead_reckoning.core.smoother import Smoother
from dead_reckoning.tables import ODOMETRY_COLUMNS, lines, odometry_columns
from dead_reckoning.tools.replay.outputs import SMOOTHED_STATES, Takers
from dead_reckoning.tools.replay.task import Task

FILES = ('smoothed.csv',)
NEEDS = SMOOTHED_STATES


@contextmanager
def write(folder: Path, task: Task) -> Iterator[Takers]:
    """Record what the navigator takes, and go back through it in the end."""
    navigator, body = task.pipeline.navigator, task.pipeline.body
    assert navigator is not None
    assert body is not None
    smoother = Smoother(navigator)
    yield {}
    with TemporaryFile(dir=folder) as backwards, (folder / FILES[0]).open('wb') as table:
        # From the last to the first they come; a recording may be larger than memory.
        sizes = [
            backwards.write(lines(odometry_columns(block)).encode())
            for block in body.smoothed(smoother.blocks())
        ]
        table.write(f'{",".join(ODOMETRY_COLUMNS)}\n'.encode())
        for size in reversed(sizes):
            backwards.seek(-size, 1)
            table.write(backwards.read(size))
            backwards.seek(-size, 1)
