"""A ROS node of the test itself, and nodes as processes beside it, in one domain.

Nothing here sleeps: `Ros.until` spins until a condition holds, or fails after `DEADLINE`, showing
what the nodes wrote.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
import rclpy
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import GetParameters, SetParameters, SetParametersAtomically
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from std_srvs.srv import Trigger

import dead_reckoning

PATIENCE = 5.0
"""Time [s] after which a node is asked again for its parameters."""

DEADLINE = 30.0
"""How long [s] anything may take; only a failure takes that long."""

ROOT = str(Path(dead_reckoning.__file__).parents[1])
"""Where the package under test is imported from; its nodes shall come from there too."""

NODES = (
    'accelerometer_driver',
    'compass_driver',
    'gravity_removal',
    'inertial_navigator',
    'integrator',
    'pedometer',
    'pipeline',
)
EXECUTORS = ('events', 'single')

LOST_ANSWER = 'client will not receive response'
"""What rclpy says where an answer found no way."""

DEEP = 5000
RELIABLE = QoSProfile(depth=DEEP)
BEST_EFFORT = QoSProfile(depth=DEEP, reliability=QoSReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


def stamp_ns(message: Any) -> int:
    """Return the stamp of a message [ns]."""
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


def lossless(*topics: str) -> dict[str, Any]:
    """Return parameters under which no sample of these topics is lost, however busy the machine.

    Topics are named in full, as qos_overrides wants them.
    """
    return {
        f'qos_overrides.{topic}.{side}.{policy}': value
        for topic in topics
        for side in ('publisher', 'subscription')
        for policy, value in (('reliability', 'reliable'), ('depth', DEEP))
    }


class NodeProcess:
    """A node of the package as a process, and what it wrote."""

    def __init__(
        self,
        name: str,
        domain: int,
        folder: Path,
        parameters: Mapping[str, Any] | None = None,
        arguments: tuple[str, ...] = (),
        *,
        file: Path | None = None,
    ) -> None:
        """Start ``name``; ``parameters`` go through a file, unless there is a ``file`` already."""
        self.name = name
        self.ended = False
        self._folder = folder
        folder.mkdir()
        if parameters:
            file = folder / 'parameters.yaml'
            file.write_text(yaml.safe_dump({'/**': {'ros__parameters': dict(parameters)}}))
        command = [sys.executable, '-m', 'dead_reckoning.nodes', name, '--ros-args']
        if file is not None:
            command += ['--params-file', str(file)]
        environment = {
            **os.environ,
            'ROS_DOMAIN_ID': str(domain),
            'ROS_LOG_DIR': str(folder),
            'PYTHONFAULTHANDLER': '1',
            'PYTHONPATH': os.pathsep.join([ROOT, os.environ.get('PYTHONPATH', '')]),
        }
        with (folder / 'stdout').open('wb') as out, (folder / 'stderr').open('wb') as err:
            self.process = subprocess.Popen(
                [*command, *arguments],
                env=environment,
                cwd=folder,  # the preset mbed.yaml logs where it is started
                stdin=subprocess.DEVNULL,
                stdout=out,
                stderr=err,
            )

    @property
    def stdout(self) -> str:
        """What it wrote to its standard output so far."""
        return (self._folder / 'stdout').read_text()

    @property
    def stderr(self) -> str:
        """What it wrote to its standard error so far: its log too."""
        return (self._folder / 'stderr').read_text()

    @property
    def running(self) -> bool:
        """Whether it has not ended."""
        return self.process.poll() is None

    def end(self, *signals: int) -> int:
        """Send signals, one right after the other, and return the exit status."""
        for number in signals:
            self.process.send_signal(number)
        return self.wait()

    def wait(self) -> int:
        """Wait for its end and return the exit status."""
        self.ended = True
        try:
            return self.process.wait(DEADLINE)
        except subprocess.TimeoutExpired:
            self.process.send_signal(signal.SIGABRT)  # whereupon it writes where it is
            self.process.wait()
            pytest.fail(f'{self.name} did not end within {DEADLINE} s:\n{self.stderr}')


class Ros:
    """A node of the test in a context of its own; processes it started end with it, cleanly."""

    def __init__(self, domain: int, folder: Path) -> None:
        self.domain = domain
        self.folder = folder
        self._started: list[NodeProcess] = []
        self._known: dict[int, NodeProcess] = {}
        self._context = rclpy.Context()
        rclpy.init(args=[], context=self._context, domain_id=domain)
        self.node = rclpy.create_node('test', context=self._context, use_global_arguments=False)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def __enter__(self) -> 'Ros':
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.end_all()
        finally:
            self._executor.shutdown()
            self.node.destroy_node()
            rclpy.shutdown(context=self._context)

    def start(
        self, name: str, parameters: Mapping[str, Any] | None = None, *arguments: str
    ) -> NodeProcess:
        """Start a node of the package; it is not there yet when this returns."""
        folder = self.folder / f'{len(self._started)}_{name}'
        process = NodeProcess(name, self.domain, folder, parameters, arguments)
        self._started.append(process)
        return process

    def end_all(self) -> None:
        """End all processes that still run: each with status 0 and without a traceback."""
        running = [process for process in self._started if process.running]
        for process in running:
            process.process.send_signal(signal.SIGINT)
        for process in running:
            process.wait()
        for process in self._started:
            assert process in running or process.ended, f'{process.name} ended: {process.stderr}'
        for process in running:
            assert process.process.returncode == 0, process.stderr
            assert 'Traceback' not in process.stderr

    def spin(self, timeout: float) -> None:
        """Let the test's node do one thing, or wait that long [s] for it."""
        self._executor.spin_once(timeout_sec=timeout)

    def until(self, condition: Callable[[], Any], what: str, patience: float = 0.02) -> Any:
        """Spin until ``condition`` gives something true, and return that.

        It is asked after each callback, or after ``patience`` [s] without one.
        """
        deadline = time.monotonic() + DEADLINE
        while not (found := condition()):
            dead = [node.name for node in self._started if not (node.running or node.ended)]
            if dead or time.monotonic() > deadline:
                why = f'{dead} ended' if dead else f'{DEADLINE} s passed'
                said = '\n'.join(f'{node.name}: {node.stderr}' for node in self._started)
                pytest.fail(f'{why} while waiting for {what}; the nodes said:\n{said}')
            self.spin(patience)
        return found

    def for_seconds(self, duration: float) -> None:
        """Spin for a time [s]: only to see that nothing happens, or that something goes on."""
        end = time.monotonic() + duration
        while time.monotonic() < end:
            self.spin(min(0.05, max(0.0, end - time.monotonic())))

    def record(
        self, topic: str, message: Any, qos: QoSProfile = RELIABLE, *, raw: bool = False
    ) -> 'Recording':
        """Record a topic from now on."""
        return Recording(self, topic, message, qos, raw)

    def publisher(self, topic: str, message: Any, subscribers: int = 1) -> Any:
        """Return a publisher that has found its subscribers."""
        publisher = self.node.create_publisher(message, topic, RELIABLE)
        self.until(
            lambda: publisher.get_subscription_count() >= subscribers, f'subscribers of {topic}'
        )
        return publisher

    def diagnostics(self) -> 'DiagnosticsRecording':
        """Record /diagnostics from now on."""
        return DiagnosticsRecording(self)

    def client(self, service_type: Any, name: str) -> Any:
        """Return a client that has found its service."""
        client = self.node.create_client(service_type, name)
        self.until(client.service_is_ready, f'service {name}')
        return client

    def ask(self, service_type: Any, name: str, request: Any) -> Any:
        """Send a request and return the future of its response."""
        return self.client(service_type, name).call_async(request)

    def call(self, service_type: Any, name: str, request: Any) -> Any:
        """Send a request and return the response.

        It is asked again where a node says that its answer is lost: DDS may bring it a request
        before it has found the client.
        """
        client = self.client(service_type, name)
        before, asked = self._lost_answers(), [client.call_async(request)]

        def answer() -> Any:
            if self._lost_answers() - before >= len(asked):
                asked.append(client.call_async(request))
            return next((future for future in asked if future.done()), None)

        return self.until(answer, f'the answer of {name}').result()

    def _lost_answers(self) -> int:
        return sum(node.stderr.count(LOST_ANSWER) for node in self._started)

    def trigger(self, name: str) -> Trigger.Response:
        """Call a Trigger service and return the response."""
        return self.call(Trigger, name, Trigger.Request())

    def get(self, node: str, *names: str) -> list[Any]:
        """Return values of parameters of a node.

        It is asked again where no answer comes: the middleware drops one to a client that the
        node has not found yet.
        """
        client = self.client(GetParameters, f'{node}/get_parameters')
        request = GetParameters.Request(names=list(names))
        begin, asked = time.monotonic(), []

        def answer() -> Any:
            if len(asked) * PATIENCE <= time.monotonic() - begin:
                asked.append(client.call_async(request))
            return next((future.result() for future in asked if future.done()), None)

        values = self.until(answer, f'the parameters of {node}').values
        messages = [ParameterMessage(name=n, value=v) for n, v in zip(names, values, strict=True)]
        return [Parameter.from_parameter_msg(message).value for message in messages]

    def set(self, node: str, **changes: Any) -> list[Any]:
        """Set parameters one by one, as ``ros2 param set`` does; ``__`` in a name is a dot."""
        request = SetParameters.Request(parameters=_messages(changes))
        return self.call(SetParameters, f'{node}/set_parameters', request).results

    def set_at_once(self, node: str, **changes: Any) -> Any:
        """Set parameters all or none; ``__`` in a name is a dot."""
        request = SetParametersAtomically.Request(parameters=_messages(changes))
        return self.call(
            SetParametersAtomically, f'{node}/set_parameters_atomically', request
        ).result


def _messages(changes: Mapping[str, Any]) -> list[ParameterMessage]:
    return [
        Parameter(name.replace('__', '.'), value=value).to_parameter_msg()
        for name, value in changes.items()
    ]


class Recording:
    """What came on a topic."""

    def __init__(self, ros: Ros, topic: str, message: Any, qos: QoSProfile, raw: bool) -> None:
        self.topic = topic
        self.messages: list[Any] = []
        self._ros = ros
        self._subscription = ros.node.create_subscription(
            message, topic, self.messages.append, qos, raw=raw
        )

    def __len__(self) -> int:
        return len(self.messages)

    @property
    def stamps(self) -> list[int]:
        """The stamps [ns], in the order of arrival."""
        return [stamp_ns(message) for message in self.messages]

    @property
    def latest_stamp(self) -> int:
        """The stamp of the last message [ns], or 0 before the first."""
        return stamp_ns(self.messages[-1]) if self.messages else 0

    def connected(self, publishers: int = 1) -> 'Recording':
        """Wait until the publishers are found."""
        self._ros.until(
            lambda: self._subscription.get_publisher_count() >= publishers,
            f'publishers of {self.topic}',
        )
        return self

    def wait(self, count: int) -> list[Any]:
        """Wait until there are so many messages, and return them."""
        self._ros.until(lambda: len(self) >= count, f'{count} messages on {self.topic}')
        return self.messages

    def wait_next(self) -> Any:
        """Wait for another message and return it."""
        return self.wait(len(self) + 1)[-1]

    def stop(self) -> None:
        """Unsubscribe."""
        self._ros.node.destroy_subscription(self._subscription)


class DiagnosticsRecording:
    """What nodes say on /diagnostics."""

    def __init__(self, ros: Ros) -> None:
        self._ros = ros
        self._arrays = ros.record('/diagnostics', DiagnosticArray)

    def of(self, node: str) -> list[Any]:
        """Return what a node said so far: statuses with ``level``, ``message``, ``values``."""
        return [s for array in self._arrays.messages for s in array.status if s.name == node]

    def until(self, node: str, condition: Callable[[Any], bool], what: str) -> Any:
        """Wait for a status of a node that meets a condition, and return it."""
        return self._ros.until(
            lambda: next((status for status in self.of(node) if condition(status)), None),
            f'/diagnostics of {node}: {what}',
        )


def figures(status: Any) -> dict[str, str]:
    """Return the key and value pairs of a status."""
    return {pair.key: pair.value for pair in status.values}


def taken(said: Any) -> int:
    """Return how many messages went through compiled code, as /diagnostics last said."""
    return int(figures(said.of('pipeline')[-1])['compiled']) if said.of('pipeline') else 0


def latest_taken(ros: Ros, said: Any) -> int:
    """Return the same as the next figures say it."""
    count = len(said.of('pipeline'))
    ros.until(lambda: len(said.of('pipeline')) > count, 'figures')
    return taken(said)
