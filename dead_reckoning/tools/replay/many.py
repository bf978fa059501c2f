"""Many recordings on an executor: this process, a pool of processes, or a Dask cluster."""

from __future__ import annotations

import multiprocessing
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from dead_reckoning.core.errors import DeadReckoningError, DependencyError, InputError
from dead_reckoning.tools.replay.progress import Progress
from dead_reckoning.tools.replay.run import Job, Result, run


class Serial(Executor):
    """Do what is submitted at once, here."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Return a future that is done already."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def executor(jobs: int, scheduler: str | None) -> Iterator[Executor]:
    """Give what the options ask for; Ctrl-C leaves nothing running.

    Raises `DependencyError` without Dask, `InputError` where no scheduler answers.
    """
    if scheduler is not None:
        with _cluster(scheduler) as cluster:
            yield cluster
        return
    pool: Executor = Serial()
    if jobs > 1:
        # Spawned, not forked: nobody knows which threads numpy and others have here.
        pool = ProcessPoolExecutor(jobs, multiprocessing.get_context('spawn'), _begin)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _begin() -> None:
    """Let Ctrl-C, which all processes of a terminal hear, end a worker without a traceback."""
    signal.signal(signal.SIGINT, lambda *_: sys.exit(130))


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError as error:
        raise DependencyError(
            '--scheduler needs Dask, which is not installed: pip install distributed'
        ) from error
    try:
        client = Client(address, timeout='10s')
    except (OSError, ValueError) as error:
        raise InputError(f'--scheduler {address}: {error}') from error
    with client:
        yield client.get_executor(pure=False)


def attempt(job: Job) -> Result | DeadReckoningError:
    """Replay a recording; return what came of it, or why nothing did."""
    try:
        return run(job)
    except DeadReckoningError as error:
        return error


def run_all(
    jobs: Sequence[Job], executor: Executor, progress: Progress
) -> list[Result | DeadReckoningError]:
    """Attempt all recordings; return the outcomes in order."""
    futures = {executor.submit(attempt, job): number for number, job in enumerate(jobs)}
    outcomes: dict[int, Result | DeadReckoningError] = {}
    for future in as_completed(futures):
        number = futures[future]
        try:
            outcomes[number] = future.result()
        except Exception as error:  # a worker that was killed, say: the others go on
            outcomes[number] = DeadReckoningError(
                f'{jobs[number].path}: {type(error).__name__}: {error}'
            )
        progress.add(1)
    return [outcomes[number] for number in range(len(jobs))]


def folders(paths: Sequence[Path], output: Path) -> list[Path]:
    """Return where the outputs of each input go: a folder each, named after it."""
    if len(paths) == 1:
        return [output]
    names: list[str] = []
    for path in paths:
        stem = path.resolve().name if path.is_dir() else path.stem
        name, number = stem, 2
        while name in names:
            name, number = f'{stem}-{number}', number + 1
        names.append(name)
    return [output / name for name in names]
