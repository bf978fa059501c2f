"""Count what happens, say it once in a while, and publish it on /diagnostics."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import TypeAlias

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from dead_reckoning.core.errors import (
    DeadReckoningError,
    MissingMountingError,
    NotLevelledError,
    SampleError,
)

Finding: TypeAlias = tuple[str, DeadReckoningError]
"""What lasts: its subject, as a topic or a port, and what is wrong with that, with the remedy."""

REPEAT = 30.0
"""A fault that keeps coming is logged anew after this time [s], with how often it came."""

PATIENCE = 2.0
"""How long [s] waiting for rest or a mounting, at the start or anew, goes without a word."""


class Diagnostics:
    """Faults by their class name, and the figures a node gives, once a second.

    ``figures`` returns what else is worth seeing, ``findings`` what is wrong now and lasts,
    ``awaited`` says what has not come yet.  The level is that of what lasts, and of the faults
    since the last time: error for wrong input, warning for dropped samples.
    """

    def __init__(
        self,
        node: Node,
        figures: Callable[[], Mapping[str, object]],
        findings: Callable[[], Iterable[Finding]],
        awaited: Callable[[], str],
    ) -> None:
        self._node = node
        self._figures = figures
        self._findings = findings
        self._awaited = awaited
        self._publisher = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._faults: Counter[str] = Counter()
        self._recent: dict[str, DeadReckoningError] = {}
        self._said: dict[str, tuple[float, int]] = {}
        self._lasting: dict[tuple[str, str], DeadReckoningError] = {}
        self._waiting_since: dict[str, float] = {}
        self.samples = 0
        """Samples taken in so far."""
        self.dropped = 0
        """Those of them that could not be used."""

    def fault(self, error: DeadReckoningError) -> None:
        """Count a fault; log it when it is new, or has gone on for `REPEAT`."""
        kind = type(error).__name__
        self._faults[kind] += 1
        if error.severity == 'none':
            return
        self._recent[kind] = error
        now = time.monotonic()
        if isinstance(error, SampleError) and not isinstance(error, NotLevelledError):
            self.dropped += 1
        if (
            isinstance(error, (MissingMountingError, NotLevelledError))
            and now - self._waiting_since.setdefault(kind, now) < PATIENCE
        ):
            return
        last, count = self._said.get(kind, (-REPEAT, 0))
        if now - last < REPEAT:
            return
        self._said[kind] = (now, self._faults[kind])
        more = self._faults[kind] - count - 1
        self._log(error, f' ({more} more of these)' if count and more else '')

    def look(self) -> None:
        """See what lasts: count and log what has begun since the last look, log what is over.

        `publish` looks once a second; who knows of a change lets it be seen at once.
        """
        before = self._lasting
        self._lasting = {(about, type(e).__name__): e for about, e in self._findings()}
        for about, kind in before:
            if (about, kind) not in self._lasting:
                self._node.get_logger().info(f'{about}: {kind} is over')
        for (about, kind), error in self._lasting.items():
            if (about, kind) not in before:
                self._faults[kind] += 1
                self._log(error)

    def _log(self, error: DeadReckoningError, more: str = '') -> None:
        log = self._node.get_logger()
        if error.severity == 'warning':
            log.warning(f'{error}{more}')
        else:
            log.error(f'{error}{more}')

    def publish(self) -> None:
        """Publish counts, figures and the level since the last time."""
        self.look()
        for over in self._waiting_since.keys() - self._recent.keys():
            del self._waiting_since[over]
        status = DiagnosticStatus(
            name=self._node.get_fully_qualified_name().lstrip('/'), hardware_id='dead_reckoning'
        )
        status.level, status.message = self._level()
        figures = {'samples': self.samples, **self._figures(), **self._faults}
        status.values = [KeyValue(key=key, value=str(value)) for key, value in figures.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
        self._recent.clear()

    def _level(self) -> tuple[bytes, str]:
        # What lasts explains what came of it, so it stands first.
        present = [*self._lasting.values(), *self._recent.values()]
        if not present:
            return DiagnosticStatus.OK, 'running' if self.samples else self._waiting()
        worst = min(error.severity for error in present)  # errors before warnings
        said = '; '.join(str(error) for error in present if error.severity == worst)
        return DiagnosticStatus.WARN if worst == 'warning' else DiagnosticStatus.ERROR, said

    def _waiting(self) -> str:
        awaited = self._awaited()
        return 'waiting for samples' + (f' on {awaited}' if awaited else '')
