"""``bag``: a rosbag2 recording in mcap with the topics of the live nodes, log times as stamps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from heapq import merge
from operator import itemgetter
from pathlib import Path
from typing import Any

from dead_reckoning.core.blocks import Block, Stamped
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import InputError
from dead_reckoning.core.stages import BESIDE
from dead_reckoning.sources.bags import BagWriter
from dead_reckoning.tools.replay.outputs import BLOCK_END, Takers
from dead_reckoning.tools.replay.task import Task
from dead_reckoning.topics import Topic, topics

FILES = ('bag',)
NEEDS = ''

OWN = {'bag.mcap', 'metadata.yaml'}
"""Files in the folder."""

Message = tuple[int, str, bytes]
"""Stamp [ns], topic and bytes."""


@contextmanager
def write(folder: Path, task: Task) -> Iterator[Takers]:
    """Write the messages that a `pipeline` in the recording's place would publish.

    Its own source is among them where that is no topic but a table.
    """
    place = folder.parent / FILES[0]
    if place.is_dir() and not {path.name for path in place.iterdir()} <= OWN:
        raise InputError(f'{place}: no replay wrote what is in it, and it would be replaced')
    pipeline, namespace = task.pipeline, task.recording.namespace
    names = [*pipeline.between, *pipeline.outputs]
    if namespace is None:
        names = [*(name for name in pipeline.inputs if name not in BESIDE), *names]
    known = topics(task.configuration[FrameSettings])
    spoken = {name: known[name] for name in dict.fromkeys(names)}
    full = {name: f'{namespace or "/"}{name}' for name in spoken}
    writer = BagWriter(
        folder / FILES[0], {full[name]: (t.type, t.latched) for name, t in spoken.items()}
    )
    pending: dict[str, list[Message]] = {name: [] for name in spoken}

    def flush(_: object) -> None:
        for stamp_ns, name, message in merge(*pending.values(), key=itemgetter(0)):
            writer.write(full[name], stamp_ns, message)
        for messages in pending.values():
            messages.clear()

    try:
        takers: dict[str, Callable[[Any], object]] = {
            name: partial(_encode, pending[name], name, topic) for name, topic in spoken.items()
        }
        yield {**takers, BLOCK_END: flush}
    except BaseException:
        writer.abort()
        raise
    writer.close()


def _encode(messages: list[Message], name: str, topic: Topic, value: Block[Any] | Stamped) -> None:
    if isinstance(value, Stamped):
        messages.append((value.stamp_ns, name, topic.encode(value.value)))
        return
    assert topic.encode_block is not None
    stamps = value.stamp_ns.tolist()
    messages.extend(zip(stamps, [name] * len(stamps), topic.encode_block(value), strict=True))
