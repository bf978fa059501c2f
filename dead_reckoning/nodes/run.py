"""Run a node from start to a clean end."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from types import FrameType

import rclpy
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from dead_reckoning.core.errors import DeadReckoningError
from dead_reckoning.nodes.chain_node import ChainNode

SPIN_TIMEOUT = 0.1
"""How long [s] one turn may wait, and so the longest that a signal waits to be heard."""


def run(make_node: Callable[[], ChainNode]) -> int:
    """Run a node until it is told to stop; return the exit status.

    Ctrl-C and SIGTERM end it with status 0, however often they come (ros2 launch sends two), wrong
    parameters with one line and status 2.
    """
    stop = _StopRequest()
    try:
        # rclpy's own handlers shut the context down under a running callback, whose next publish
        # then fails; these only take note.
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:  # rcl's complaint about arguments and parameter files
        print(f'dead_reckoning: {_one_line(error)}', file=sys.stderr)
        return 2
    node: ChainNode | None = None
    try:
        node = make_node()
        executor = _executor(node.common.executor)
        executor.add_node(node)
        while rclpy.ok() and not stop.asked:
            # The events executor's own spin() hears neither signals nor a shutdown.
            executor.spin_once(timeout_sec=SPIN_TIMEOUT)
    except DeadReckoningError as error:
        rclpy.logging.get_logger('dead_reckoning').fatal(str(error))
        return 2
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
    return 0


class _StopRequest:
    """Takes note of Ctrl-C and SIGTERM."""

    def __init__(self) -> None:
        self.asked = False
        signal.signal(signal.SIGINT, self._note)
        signal.signal(signal.SIGTERM, self._note)

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.asked = True


def _executor(kind: str) -> Executor:
    if kind == 'single':
        return SingleThreadedExecutor()
    from rclpy.experimental import EventsExecutor

    return EventsExecutor()


def _one_line(error: Exception) -> str:
    text = ' '.join(str(error).split())
    if 'bool' in text:
        text += " (an unquoted y, n, yes, no, on or off is a boolean in YAML: quote it, as 'y')"
    return text
