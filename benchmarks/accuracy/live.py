"""Play a recording over DDS through nodes in processes of their own, and collect what they say."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rclpy
from rclpy.signals import SignalHandlerOptions

from benchmarks.accuracy.accounting import GRAVITY, INTEGRATOR, Live
from benchmarks.accuracy.recorder import Recorder
from dead_reckoning.core import errors
from dead_reckoning.core.errors import RecordingError, SampleError, UnpairedError, WireError
from dead_reckoning.core.samples import NavigationState
from dead_reckoning.core.stages import ACCELERATION, AIDING_ODOMETRY, IMU, ODOMETRY
from dead_reckoning.tools.processes import Interruption, Nodes, environment, interruptible

SPEED = 10.0
"""How many times faster than it was made a recording is played."""

AIDED_SPEED = 5.0
"""The same for several topics: less, as aiding may come no second ahead of the Imu."""

NAVIGATOR = 'inertial_navigator'
"""Name of the node."""

DEADLINE = 30.0
"""How long [s] nodes may take to find each other, or to report."""

SILENCE = 3.0
"""Once the player is done and nothing has come for this long [s], nothing more will."""

ROOT = Path(__file__).parents[2]


def play(path: Path, topic: str, count: int, parameters: Mapping[str, Any]) -> Live:
    """Play the ``count`` messages of a topic into the two nodes; return what came of them.

    Raises `NodeEndedError` or `RecordingError` if the nodes or the player fail.
    """
    names = (GRAVITY, INTEGRATOR)
    with _nodes(names, count, parameters, (ACCELERATION, ODOMETRY)) as (recorder, watch):
        # Once all is seen from here, the two nodes have met by the time a player is up.
        watch.wait_for(
            lambda: (
                recorder.matched()
                and recorder.subscribers(ACCELERATION) == 2
                and recorder.subscribers(IMU) == 2
            )
        )
        published = _run_player(path, {IMU: topic}, SPEED, 2, watch)
        watch.wait_for_messages(published)
        watch.wait_for_reports(names)
        figures = {name: recorder.figures[name] for name in names}
        return Live(
            published,
            recorder.accelerations(),
            recorder.states(),
            {name: int(figures[name]['samples']) for name in figures},
            {name: _drops(figures[name]) for name in figures},
        )


def play_aided(
    path: Path, topics: Mapping[str, str], count: int, parameters: Mapping[str, Any]
) -> list[NavigationState]:
    """Play topics, by the names of the inputs, into an inertial navigator; return its states.

    Of two topics one may be late: raise `navigator.aiding_delay` where that counts.  Raises as
    `play` does.
    """
    with _nodes((NAVIGATOR,), count, parameters, (ODOMETRY,)) as (recorder, watch):
        watch.wait_for(
            lambda: recorder.matched() and all(recorder.subscribers(name) == 1 for name in topics)
        )
        watch.wait_for_messages(_run_player(path, topics, AIDED_SPEED, 1, watch))
        watch.wait_for_reports((NAVIGATOR,))
        return recorder.states()


@contextmanager
def _nodes(
    names: Sequence[str], count: int, parameters: Mapping[str, Any], recorded: Sequence[str]
) -> Iterator[tuple[Recorder, Watch]]:
    """Run nodes whose queues hold ``count`` messages, and record topics that they publish."""
    os.environ.update(environment())  # for this process and its children
    context = rclpy.Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    recorder = Recorder(context, max(1, count), recorded)
    try:
        with interruptible() as interruption, Nodes({}) as nodes:
            for name in names:
                nodes.start(name, {**_reliable(max(1, count)), **parameters})
            yield recorder, Watch(recorder, nodes, interruption)
    finally:
        recorder.close()
        rclpy.try_shutdown(context=context)


class Watch:
    """Take messages in while waiting for something; Ctrl-C or the end of a node ends it."""

    def __init__(self, recorder: Recorder, nodes: Nodes, interruption: Interruption) -> None:
        self._recorder = recorder
        self._nodes = nodes
        self._interruption = interruption

    def turn(self) -> None:
        """Take in what has come, and look at nodes and signals."""
        self._recorder.spin()
        self._nodes.check()
        self._interruption.check()

    def wait_for(self, condition: Callable[[], bool]) -> None:
        """Take turns until the condition holds; raises `RecordingError` after `DEADLINE`."""
        deadline = time.monotonic() + DEADLINE
        while not condition():
            if time.monotonic() > deadline:
                raise RecordingError('the nodes did not find each other')
            self.turn()

    def wait_for_messages(self, count: int) -> None:
        """Take turns until ``count`` of each have come, or nothing for `SILENCE`."""
        last, received = time.monotonic(), self._recorder.received
        while min(received) < count and time.monotonic() < last + SILENCE:
            self.turn()
            if self._recorder.received != received:
                last, received = time.monotonic(), self._recorder.received

    def wait_for_reports(self, names: Sequence[str]) -> None:
        """Take turns until each node has reported twice more: one may be under way."""
        before = dict(self._recorder.reports)
        self.wait_for(
            lambda: all(
                self._recorder.reports.get(name, 0) >= before.get(name, 0) + 2 for name in names
            )
        )


def _run_player(
    path: Path, topics: Mapping[str, str], speed: float, subscribers: int, watch: Watch
) -> int:
    """Let a process play topics of the recording; return how many of the first it published."""
    command = [sys.executable, '-m', 'benchmarks.accuracy.player', str(path.resolve())]
    command += [f'{name}={topic}' for name, topic in topics.items()]
    command += ['--speed', str(speed), '--subscribers', str(subscribers)]
    with subprocess.Popen(
        command,
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C is for this process, which ends the player
    ) as player:
        try:
            while player.poll() is None:
                watch.turn()
        finally:
            player.kill()
        said = player.stdout.read() if player.stdout else ''
    if player.returncode:
        raise RecordingError(f'the player ended with status {player.returncode}')
    return int(said)


def _reliable(depth: int) -> dict[str, Any]:
    """Return parameters by which no message gets lost between these nodes.

    Nodes subscribe best-effort by default; here each queue holds the whole recording.
    """
    parameters: dict[str, Any] = {}
    for topic in (IMU, ACCELERATION, AIDING_ODOMETRY):
        parameters[f'qos_overrides./{topic}.subscription.reliability'] = 'reliable'
        parameters[f'qos_overrides./{topic}.subscription.depth'] = depth
    for topic in (ACCELERATION, ODOMETRY):
        parameters[f'qos_overrides./{topic}.publisher.depth'] = depth
    return parameters


def _drops(figures: Mapping[str, str]) -> dict[str, int]:
    """Return why a node dropped samples, and how often, from what it said on /diagnostics.

    A sample without a partner was dropped where its partner was, and counts there.
    """
    return {
        kind: int(count)
        for kind, count in figures.items()
        if kind != UnpairedError.__name__
        and issubclass(getattr(errors, kind, object), (SampleError, WireError))
    }
