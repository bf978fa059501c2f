"""``report.html``, one page about the recording, for people."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dead_reckoning.tools.replay.outputs import Takers
from dead_reckoning.tools.replay.task import Task
from dead_reckoning.tools.report.contents import Collector, settings_of

FILES = ('report.html',)
NEEDS = ''


@contextmanager
def write(folder: Path, task: Task) -> Iterator[Takers]:
    """Gather what comes, and write the page in the end."""
    navigator = task.pipeline.navigator
    collector = Collector(None if navigator is None else navigator.settings.input)
    yield collector.takers()
    # Pictures take a second to import, and only this output needs them.
    from dead_reckoning.tools.report.page import write_report

    more = {'settings': settings_of(task.configuration), **task.summary.way()}
    contents = collector.contents(task.name, task.summary.samples, **more)
    write_report(folder / FILES[0], contents)
