"""``summary.json``: what the replay comes to in a few figures."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dead_reckoning.tools.replay.outputs import Takers
from dead_reckoning.tools.replay.task import Task

FILES = ('summary.json',)
NEEDS = ''


@contextmanager
def write(folder: Path, task: Task) -> Iterator[Takers]:
    """Write the figures in the end; they are counted anyway."""
    yield {}
    text = json.dumps(task.summary.values(), indent=2)
    (folder / FILES[0]).write_text(f'{text}\n', encoding='utf-8')
