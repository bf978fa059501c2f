"""Read an accelerometer from a board on a serial port."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator, Mapping

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.errors import (
    DeadReckoningError,
    PortError,
    SilentPortError,
    ZeroStampError,
)
from dead_reckoning.nodes.chain_node import STEADY, ChainNode
from dead_reckoning.nodes.diagnostics import Finding
from dead_reckoning.nodes.driver import Driver
from dead_reckoning.sources.driver import serial_receiver
from dead_reckoning.sources.serial.port import Opened, Received, SerialPort
from dead_reckoning.sources.serial.protocols import decoder_class
from dead_reckoning.sources.serial.settings import SerialSettings

PERIOD = 0.01
"""Time [s] between two looks at what the port brought; stamps are those of the port's thread."""

SILENCE = 5.0
"""Time [s] without a reading after which an open port is called silent."""


class SerialDriver(Driver):
    """Feed a node with the samples of a board, whatever happens to its port.

    What is wrong with the port lasts until readings come.  Readings before and after a loss of the
    port are never averaged together, and a board that is told what to do is told it anew.
    """

    def __init__(self, node: ChainNode, configuration: Configuration) -> None:
        super().__init__(node, configuration)
        self._settings = configuration[SerialSettings]
        self._receiver = serial_receiver(configuration)
        self._state = 'closed'
        self._open = False
        self._told = -math.inf
        self._error: PortError | None = None
        self._openings = 0
        self._bytes = 0
        self._quiet_since = time.monotonic()
        self._bytes_then = 0
        clock = node.get_clock()
        self._port = SerialPort(self._settings, lambda: clock.now().nanoseconds)
        node.at_end(lambda: self._port.close(self._receiver.goodbye()))
        node.watch(self._findings)
        node.create_timer(PERIOD, self._tick, clock=STEADY)

    @classmethod
    def outputs(cls, configuration: Configuration) -> tuple[str, ...]:
        """Name the topic of what the board measures."""
        return (decoder_class(configuration[SerialSettings].protocol).OUTPUT,)

    def figures(self) -> Mapping[str, object]:
        """Return the port and its state, how often it came back, and what came through it."""
        return {
            **super().figures(),
            'port': self._settings.port,
            'port_state': self._state,
            'reconnections': max(0, self._openings - 1),
            'bytes': self._bytes,
            **self._receiver.figures(),
        }

    def _tick(self) -> None:
        for event in self._port.poll():
            if isinstance(event, Received):
                self._take(event)
                self._tell()
            elif isinstance(event, Opened):
                self._openings += 1
                self._open = True
                self._begin()
            else:
                self._open = False
                self._fail(event)
        self._tell()
        if self._state in ('open', 'reading') and time.monotonic() - self._quiet_since > SILENCE:
            self._fail(self._silence())

    def _tell(self) -> None:
        """Tell the board what it is to be told now."""
        if not self._open:
            return
        now = time.monotonic()
        data = self._receiver.due(now - self._told)
        if data:
            self._told = now
            stamp_ns = self._port.send(data)
            if stamp_ns is not None:
                self._receiver.told(data, stamp_ns)

    def _begin(self) -> None:
        """Begin with bytes that do not follow on those before."""
        self._state = 'open'
        self._told = -math.inf
        self._note_quiet()
        self._count(self._receiver.restart())
        self.front_end.interrupt()

    def _take(self, received: Received) -> None:
        self._bytes += len(received.data)
        if received.arrival_ns == 0:
            self._count([ZeroStampError('use_sim_time is set, and there is no /clock: unset it')])
            self._begin()
            return
        conversions, errors, positions = self._receiver.take(received.data, received.arrival_ns)
        self._count(errors)
        if len(conversions) or positions:
            self._note_quiet()
            if self._state != 'reading':
                self._state, self._error = 'reading', None
                self._node.diagnostics.look()
                self._node.get_logger().info(
                    f'{self._settings.port}: readings come, {self._settings.protocol} at '
                    f'{self._settings.baud} baud'
                )
            self.deliver(conversions)
            for position in positions:
                self._node.feed(self._output, position)

    def _fail(self, error: PortError) -> None:
        self._state, self._error = type(error).__name__, error
        self._node.diagnostics.look()

    def _findings(self) -> Iterator[Finding]:
        if self._error is not None:
            yield self._settings.port, self._error

    def _note_quiet(self) -> None:
        self._quiet_since = time.monotonic()
        self._bytes_then = self._bytes

    def _silence(self) -> SilentPortError:
        said = f'{self._settings.port}: it is open, and no reading has come for {SILENCE:g} s'
        if self._bytes > self._bytes_then:
            return SilentPortError(
                f'{said}, though bytes have: set driver.serial.baud and driver.serial.protocol as '
                'the board sends'
            )
        return SilentPortError(f'{said}: is the board on, and does it send by itself?')

    def _count(self, errors: Iterable[DeadReckoningError]) -> None:
        for error in errors:
            self._node.diagnostics.fault(error)


DRIVER = SerialDriver
