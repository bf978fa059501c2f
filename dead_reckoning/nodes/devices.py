"""What sensors on buses and of the kernel share: a thread that reads, and what is wrong."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from typing import TypeAlias

from dead_reckoning.core.errors import (
    DeviceError,
    ReadingError,
    SilentDeviceError,
    ZeroStampError,
)
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.nodes.chain_node import STEADY, ChainNode
from dead_reckoning.nodes.diagnostics import Finding
from dead_reckoning.sources.devices import Calibration, DeviceThread, Heading, Opened, Session

PERIOD = 0.01
"""Time [s] between two looks at what the thread brought; stamps are those of the thread."""

SILENCE = 5.0
"""Time [s] without a reading after which an open device is called silent."""

Taken: TypeAlias = Conversions | Heading | Calibration


class DeviceReader:
    """Hand on what a device brings; say what is wrong with it for as long as that lasts."""

    def __init__(
        self,
        node: ChainNode,
        name: str,
        session: Session,
        take: Callable[[Taken], None],
        lose: Callable[[DeviceError | ReadingError], None],
        period: float,
    ) -> None:
        """``lose`` hears of each error after which readings do not follow on those before.

        ``period`` [s] is that of the readings.
        """
        self._node = node
        self._name = name
        self._take = take
        self._lose = lose
        self._state = 'closed'
        self._error: DeviceError | None = None
        self._openings = self._readings = 0
        self._notice = ''
        self._silence = max(SILENCE, 5.0 * period)
        self._quiet_since = time.monotonic()
        self._thread = DeviceThread(session, name)
        node.at_end(self._thread.close)
        node.watch(self._findings)
        node.show(self.figures)
        node.create_timer(PERIOD, self._tick, clock=STEADY)

    def figures(self) -> Mapping[str, object]:
        """Return the device and its state, how often it came back, and what came from it."""
        return {
            'device': self._name,
            'device_state': self._state,
            'reconnections': max(0, self._openings - 1),
            'readings': self._readings,
        }

    def _tick(self) -> None:
        for event in self._thread.poll():
            if isinstance(event, Opened):
                self._open(event)
            elif isinstance(event, DeviceError):
                self._fail(event)
                self._lose(event)
            elif isinstance(event, ReadingError):
                self._node.diagnostics.fault(event)
                self._lose(event)
            elif isinstance(event, Calibration):
                self._quiet_since = time.monotonic()
                self._take(event)
            elif isinstance(event, (Conversions, Heading)):
                self._read(event)
        if (
            self._state in ('open', 'reading')
            and time.monotonic() - self._quiet_since > self._silence
        ):
            self._fail(
                SilentDeviceError(
                    f'{self._name}: it is set up, and no reading has come for '
                    f'{self._silence:g} s; does what starts its conversions, a trigger or an '
                    'interrupt, run?'
                )
            )

    def _open(self, opened: Opened) -> None:
        self._openings += 1
        self._state, self._quiet_since = 'open', time.monotonic()
        if opened.notice and opened.notice != self._notice:
            self._node.get_logger().warning(opened.notice)
        self._notice = opened.notice

    def _read(self, reading: Conversions | Heading) -> None:
        many = isinstance(reading, Conversions)
        if (reading.stamps_ns[-1] if many else reading.stamp_ns) <= 0:
            self._node.diagnostics.fault(
                ZeroStampError('use_sim_time is set, and there is no /clock: unset it')
            )
            return
        self._readings += len(reading) if many else 1
        self._quiet_since = time.monotonic()
        if self._state != 'reading':
            self._state, self._error = 'reading', None
            self._node.diagnostics.look()
            self._node.get_logger().info(f'{self._name}: readings come')
        self._take(reading)

    def _fail(self, error: DeviceError) -> None:
        self._state, self._error = type(error).__name__, error
        self._node.diagnostics.look()

    def _findings(self) -> Iterator[Finding]:
        if self._error is not None:
            yield self._name, self._error
