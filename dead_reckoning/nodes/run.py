"""Run a node from start to a clean end; Ctrl-C and SIGTERM bring that from the first moment on.

This module and those of the executables import nothing slow, so that signals are heard while ROS
and the rest are imported: half a second in which Python would end with a traceback, or lose the
signal.
"""

from __future__ import annotations

import re
import signal
import sys
from importlib import import_module
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rclpy.executors import Executor

    from dead_reckoning.nodes.chain_node import ChainNode

STOP_PERIOD = 0.1
"""How often [s] a node looks whether a signal came, and so the longest that one waits."""

TURN = 86_400.0
"""How long [s] the executor runs at a time; the events executor hears nothing without any."""


class StoppedError(Exception):
    """A signal came while a node was made."""


def stop_asked() -> bool:
    """Say whether a signal came; who takes long to make a node looks now and then."""
    return _StopRequest.asked


def run(name: str) -> int:
    """Run the node of a module of this folder, its ``NODE``, until told to stop.

    Return the exit status.

    Ctrl-C and SIGTERM end it with status 0, however often they come (ros2 launch sends two), wrong
    parameters with one line and status 2.
    """
    stop = _StopRequest()
    import rclpy
    from rclpy.logging import LoggingSeverity, get_logger, set_logger_level
    from rclpy.signals import SignalHandlerOptions

    from dead_reckoning.core.errors import DeadReckoningError

    make_node = import_module(f'dead_reckoning.nodes.{name}').NODE
    # rcl would say in a line of its own that parsing failed.
    set_logger_level('rcl', LoggingSeverity.FATAL)
    try:
        # rclpy's own handlers shut the context down under a running callback, whose next publish
        # then fails; these only take note.
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:  # rcl's complaint about arguments and parameter files
        print(f'dead_reckoning: {_one_line(error)}', file=sys.stderr)
        return 2
    set_logger_level('rcl', LoggingSeverity.UNSET)
    try:
        if not stop.asked:
            _spin(make_node(), stop)
    except StoppedError:
        pass
    except DeadReckoningError as error:
        get_logger('dead_reckoning').fatal(str(error))
        return 2
    finally:
        rclpy.try_shutdown()
        stop.ignore()
    return 0


def _spin(node: ChainNode, stop: _StopRequest) -> None:
    from dead_reckoning.nodes.chain_node import STEADY

    executor = _executor(node.common.executor)
    executor.add_node(node)
    node.create_timer(STOP_PERIOD, lambda: node.finish() if stop.asked else None, clock=STEADY)
    try:
        # In one go: a loop over spin_once takes a sixth of what handing on a message takes.
        while not node.finished.done():
            executor.spin_until_future_complete(node.finished, timeout_sec=TURN)
    finally:
        # Before the context ends: an executor that is collected after it complains.
        executor.shutdown()
        node.destroy_node()


class _StopRequest:
    """Takes note of Ctrl-C and SIGTERM."""

    SIGNALS = (signal.SIGINT, signal.SIGTERM)
    asked = False

    def __init__(self) -> None:
        _StopRequest.asked = False
        for number in self.SIGNALS:
            signal.signal(number, self._note)

    def _note(self, number: int, frame: FrameType | None) -> None:
        _StopRequest.asked = True

    def ignore(self) -> None:
        """Let no signal disturb the end, where Python would put back the system's default."""
        for number in self.SIGNALS:
            signal.signal(number, signal.SIG_IGN)


def _executor(kind: str) -> Executor:
    if kind == 'single':
        from rclpy.executors import SingleThreadedExecutor

        return SingleThreadedExecutor()
    from rclpy.experimental import EventsExecutor

    return EventsExecutor()


def _one_line(error: Exception) -> str:
    text = re.sub(r',? at \S+\.[ch]:\d+', '', ' '.join(str(error).split()))
    if text.startswith('['):
        return f'unknown ROS arguments: {text[1:-1]}'
    if 'bool' in text:
        text += " (an unquoted y, n, yes, no, on or off is a boolean in YAML: quote it, as 'y')"
    return text
