"""Start nodes as processes of their own, and leave none of them behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import FrameType
from typing import IO, Any

from dead_reckoning.core.errors import DeadReckoningError

PATIENCE = 5.0
"""How long [s] a process may take to end after SIGTERM, before it is killed."""


def environment() -> dict[str, str]:
    """Return what keeps nodes to this machine, and to a domain of its own if none is chosen."""
    domain = os.environ.get('ROS_DOMAIN_ID') or str(1 + os.getpid() % 100)
    return {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_DOMAIN_ID': domain}


class NodeEndedError(DeadReckoningError):
    """A node ended by itself while it was needed."""


@contextmanager
def interruptible() -> Iterator[Interruption]:
    """Take note of Ctrl-C, SIGTERM and SIGHUP instead of dying of them."""
    interruption = Interruption()
    signals = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.signal(number, interruption.note) for number in signals}
    try:
        yield interruption
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Interruption:
    """Whether a signal came that asks to end."""

    def __init__(self) -> None:
        self._noted = False

    def note(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal."""
        self._noted = True

    def check(self) -> None:
        """Raise `KeyboardInterrupt` if a signal came."""
        if self._noted:
            raise KeyboardInterrupt


class Nodes:
    """Nodes running as processes; leaving the context ends all of them, whatever happened."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._environment = {**os.environ, **environment}
        self._processes: dict[str, subprocess.Popen[str]] = {}

    def __enter__(self) -> Nodes:
        return self

    def start(self, name: str, parameters: Mapping[str, Any], *, read: bool = False) -> IO[str]:
        """Start a node of `dead_reckoning.nodes`; with ``read`` its output can be read.

        Values of parameters are written as ROS takes them on a command line.
        """
        command = [sys.executable, '-m', 'dead_reckoning.nodes', name, '--ros-args']
        command += ['--log-level', 'warn']  # the demo itself says what is well
        for key, value in parameters.items():
            command += ['-p', f'{key}:={_argument(value)}']
        process = subprocess.Popen(
            command,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE if read else sys.stderr,
            text=True,
            start_new_session=True,  # Ctrl-C comes here alone, which ends them in its own way
        )
        self._processes[name] = process
        return process.stdout if process.stdout is not None else sys.stderr

    @property
    def pids(self) -> dict[str, int]:
        """The process of each node, by the node's name."""
        return {name: process.pid for name, process in self._processes.items()}

    def check(self) -> None:
        """Raise `NodeEndedError` if one of them has ended."""
        for name, process in self._processes.items():
            if process.poll() is not None:
                raise NodeEndedError(
                    f'{name} ended by itself with status {process.returncode}: see what it said'
                )

    def __exit__(self, *exception: object) -> None:
        for process in self._processes.values():
            if process.poll() is None:
                process.terminate()
        deadline = time.monotonic() + PATIENCE
        for process in self._processes.values():
            try:
                process.wait(max(0.1, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            if process.stdout is not None:
                process.stdout.close()


def _argument(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return '[' + ', '.join(_argument(element) for element in value) + ']'
    if isinstance(value, str):
        return f"'{value}'"
    return repr(value)
