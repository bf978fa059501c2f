"""``steps.csv``, a row for each step, and ``pedestrian.csv``, the way they lead."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dead_reckoning.core.blocks import Stamped, StateBlock
from dead_reckoning.core.stages import STEP, STEP_ODOMETRY, STEPS
from dead_reckoning.tables import ODOMETRY_COLUMNS, lines, odometry_columns
from dead_reckoning.tools.replay.outputs import Takers
from dead_reckoning.tools.replay.task import Task

FILES = ('steps.csv', 'pedestrian.csv')
NEEDS = STEPS
COLUMNS = ('stamp_ns', 'step', 'step_length', 'distance')
"""When it ended [ns], its number, its length and the sum of all lengths [m]."""


@contextmanager
def write(folder: Path, task: Task) -> Iterator[Takers]:
    """Write both as steps come; of the way, those whose heading is known."""
    with (folder / FILES[0]).open('w') as steps, (folder / FILES[1]).open('w') as way:
        steps.write(','.join(COLUMNS) + '\n')
        way.write(','.join(ODOMETRY_COLUMNS) + '\n')

        def count(step: Stamped) -> None:
            state = step.value
            row = (state.stamp_ns, state.steps, state.step_length, state.distance)
            steps.write(','.join(map(repr, row)) + '\n')

        def walk(block: StateBlock) -> None:
            way.write(lines(odometry_columns(block)))

        yield {STEP: count, STEP_ODOMETRY: walk}
