"""Many recordings on an executor: this process, a pool of processes, or a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import Any

from dead_reckoning.core.errors import DeadReckoningError, DependencyError, InputError
from dead_reckoning.tools.replay.progress import Progress
from dead_reckoning.tools.replay.run import Job, Result, run
from dead_reckoning.tools.signals import unwinding


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


class Pool(ProcessPoolExecutor):
    """Do what is submitted in processes of their own, which end tidily with this one."""

    def __init__(self, processes: int) -> None:
        # Spawned, not forked: nobody knows which threads numpy and others have here.
        with _deaf():
            super().__init__(processes, multiprocessing.get_context('spawn'), _begin)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Submit; the process that may start for it leaves Ctrl-C to this one."""
        with _deaf():
            return super().submit(_unwound, fn, *args, **kwargs)

    def __exit__(self, *exception: Any) -> None:
        """Wait for the processes, once an exception has ended what they do."""
        if exception[0] is not None:
            for worker in multiprocessing.active_children():
                worker.terminate()
        self.shutdown(cancel_futures=True)


@contextmanager
def _deaf() -> Iterator[None]:
    """Let processes that start here never hear what a terminal tells all of them."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGHUP))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def executor(jobs: int, scheduler: str | None) -> Iterator[Executor]:
    """Give what the options ask for; Ctrl-C and other ends leave nothing running.

    Raises `DependencyError` without Dask, `InputError` where no scheduler answers.
    """
    if scheduler is not None:
        with _cluster(scheduler) as cluster:
            yield cluster
        return
    with Pool(jobs) if jobs > 1 else Serial() as pool:
        yield pool


def _unwound(fn: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    with unwinding(signal.SIGTERM):
        return fn(*args, **kwargs)


def _begin() -> None:
    Thread(target=_follow, daemon=True).start()


def _follow() -> None:
    """End when the parent was killed: a worker would wait for more work for ever."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


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
