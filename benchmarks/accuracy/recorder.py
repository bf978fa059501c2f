"""Collect what a chain publishes, as bytes, and what its nodes say of themselves."""

from __future__ import annotations

from collections.abc import Sequence

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import AccelWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile

from dead_reckoning import wire
from dead_reckoning.core.samples import LinearAcceleration, NavigationState
from dead_reckoning.core.stages import ACCELERATION, ODOMETRY

TURN = 0.05
"""How long [s] one turn waits for something to come."""

MESSAGES = {ACCELERATION: AccelWithCovarianceStamped, ODOMETRY: Odometry}


class Recorder:
    """Subscribe linear acceleration, Odometry and diagnostics; `spin` takes what has come."""

    def __init__(
        self,
        context: rclpy.Context,
        depth: int,
        names: Sequence[str] = (ACCELERATION, ODOMETRY),
    ) -> None:
        """``depth`` is that of the queues, which are reliable."""
        self.figures: dict[str, dict[str, str]] = {}
        """What each node said last on /diagnostics."""
        self.reports: dict[str, int] = {}
        """How many diagnostics have come from each node."""
        self._messages: dict[str, list[bytes]] = {name: [] for name in names}
        self._node = rclpy.create_node('accuracy_recorder', context=context)
        self._executor = EventsExecutor(context=context)
        self._executor.add_node(self._node)
        qos = QoSProfile(depth=depth)
        self._subscriptions = [
            self._node.create_subscription(MESSAGES[name], name, taken.append, qos, raw=True)
            for name, taken in self._messages.items()
        ]
        self._node.create_subscription(DiagnosticArray, '/diagnostics', self._note, 10)

    def _note(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.figures[status.name] = {pair.key: pair.value for pair in status.values}
            self.reports[status.name] = self.reports.get(status.name, 0) + 1

    def spin(self) -> None:
        """Take what has come, or wait for `TURN`."""
        self._executor.spin_once(timeout_sec=TURN)

    @property
    def received(self) -> tuple[int, ...]:
        """How many messages of each name have come."""
        return tuple(len(taken) for taken in self._messages.values())

    def subscribers(self, name: str) -> int:
        """Return how many subscriptions of a topic there are."""
        return self._node.count_subscribers(self._node.resolve_topic_name(name))

    def matched(self) -> bool:
        """Say whether all topics have a publisher."""
        return all(own.get_publisher_count() for own in self._subscriptions)

    def accelerations(self) -> list[LinearAcceleration]:
        """Return the linear accelerations, in the order they came."""
        return [wire.decode_acceleration(data) for data in self._messages[ACCELERATION]]

    def states(self) -> list[NavigationState]:
        """Return the states, in the order they came."""
        return [wire.decode_odometry(data) for data in self._messages[ODOMETRY]]

    def close(self) -> None:
        """Leave the network."""
        self._executor.shutdown()
        self._node.destroy_node()
