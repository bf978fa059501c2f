"""Replay one recording: its blocks through the chain, and what comes out into the outputs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.blocks import Stamped
from dead_reckoning.core.chain import FAULT, Chain, Output
from dead_reckoning.core.errors import InputError
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.sources.recordings import Recording, open_recording
from dead_reckoning.tools.files import complete_or_absent
from dead_reckoning.tools.replay.outputs import BLOCK_END, SMOOTHED_STATES, outputs
from dead_reckoning.tools.replay.progress import Progress
from dead_reckoning.tools.replay.summary import Fault, Summary
from dead_reckoning.tools.replay.task import Task


@dataclass(frozen=True)
class Job:
    """What to replay, and what is wanted of it; it may go to another process.

    ``wanted``
        names of outputs; None for all that there is something to write for.
    ``imu``, ``rate``, ``remaps``
        topic of the Imu, samples per second of a table without stamps [Hz], and topics of a bag by
        the inputs that they go to.
    ``watched``
        whether someone looks at the progress.
    """

    path: Path
    folder: Path
    configuration: Configuration
    wanted: tuple[str, ...] | None = None
    imu: str | None = None
    rate: float | None = None
    remaps: Mapping[str, str] = field(default_factory=dict)
    watched: bool = False


@dataclass(frozen=True)
class Result:
    """What came of a job: the figures of summary.json, the faults, and how long it took [s]."""

    figures: dict[str, Any]
    faults: dict[str, Fault] = field(default_factory=dict)
    seconds: float = 0.0


def run(job: Job) -> Result:
    """Replay a recording; all outputs are complete in the end, or as they were before.

    Raises `DeadReckoningError` where the input, the settings or the folder can't be used.
    """
    began = time.perf_counter()
    pipeline = Pipeline(job.configuration, blocks=True)
    wanted = chosen(job.wanted, pipeline)
    files = [name for output in wanted for name in output.FILES]
    source, folder = job.path.resolve(), job.folder.resolve()
    if any(folder / name in (source, *source.parents) for name in files):
        raise InputError(f'{job.path}: this would be replaced by what comes of it')
    recording = open_recording(
        job.path, pipeline.inputs, job.configuration, job.imu, job.rate, job.remaps
    )
    task = Task(job.path.name, job.configuration, pipeline, recording, Summary(pipeline))
    try:
        with complete_or_absent(job.folder, files) as folder, ExitStack() as stack:
            takers = [task.summary.takers()]
            takers += [stack.enter_context(output.write(folder, task)) for output in wanted]
            progress = stack.enter_context(Progress(task.name, recording.length, job.watched))
            for name, value in flow(pipeline.chain, recording, progress.add):
                for taker in takers:
                    if name in taker:
                        taker[name](value)
    except OSError as error:
        raise InputError(f'{error.filename or job.folder}: {error.strerror or error}') from error
    return Result(task.summary.values(), task.summary.faults, time.perf_counter() - began)


def flow(chain: Chain, recording: Recording, add: Callable[[int], object]) -> Iterator[Output]:
    """Yield what goes into the chain and what comes out of it, by name.

    ``add`` is told how much of the recording was taken.
    """
    for names, block in recording.blocks:
        if isinstance(block, Stamped):
            yield FAULT, block
            add(1)
            continue
        for name in names:
            yield name, block
            yield from chain.push(name, block)
        yield BLOCK_END, None
        add(len(block))
    yield from chain.end()
    yield BLOCK_END, None


def chosen(wanted: Iterable[str] | None, pipeline: Pipeline) -> list[Any]:
    """Return the outputs asked for, or all there is something to write for.

    Raises `InputError` for a name that is none, or for which there is nothing to write.
    """
    known = outputs()
    given = ['', *pipeline.outputs]
    if pipeline.navigator is not None:
        given.append(SMOOTHED_STATES)
    if wanted is None:
        return [output for output in known.values() if output.NEEDS in given]
    for name in wanted:
        if name not in known:
            raise InputError(f'--outputs {name}: no such output; there are {", ".join(known)}')
        if known[name].NEEDS not in given:
            raise InputError(
                f'--outputs {name}: nothing gives {known[name].NEEDS}; pipeline.estimators says '
                'what runs'
            )
    return [known[name] for name in dict.fromkeys(wanted)]
