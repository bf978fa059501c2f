"""A serial port that is read in a thread of its own; the one module that knows pySerial."""

from __future__ import annotations

import errno
import queue
import termios
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from dead_reckoning.core.errors import (
    BusyPortError,
    DependencyError,
    LostPortError,
    MissingPortError,
    PortError,
    PortPermissionError,
)
from dead_reckoning.sources.serial.settings import SerialSettings

try:
    import serial
except ImportError as error:
    raise DependencyError(
        "driver.source 'serial' needs pySerial: install python3-serial, or pyserial with pip"
    ) from error

RETRY = 1.0
"""Time [s] between two tries to open the port."""

READ_TIMEOUT = 0.2
"""Longest time [s] of one read, and so the longest that the end waits for it."""

WAITING = 1024
"""Events that may wait to be taken; the system keeps the bytes that come then."""


@dataclass(frozen=True, slots=True)
class Opened:
    """The port is open; no byte from before it was opened follows."""


@dataclass(frozen=True, slots=True)
class Received:
    """Bytes came, and the last of them just before ``arrival_ns``."""

    data: bytes
    arrival_ns: int


PortEvent: TypeAlias = Opened | Received | PortError

FAILURES = (OSError, ValueError, termios.error)
"""What pySerial raises for a port: its SerialException is an OSError, `termios.error` is none."""


class SerialPort:
    """Read a port for as long as it is there, and open it again whenever it comes back.

    The thread opens, reads and closes, and nobody else does: pySerial does not take a close during
    a read.  It never ends before `close`, and waits wherever there is nothing to do.  The port is
    locked, so that no other program that locks it reads half of the bytes.
    """

    def __init__(self, settings: SerialSettings, now_ns: Callable[[], int]) -> None:
        """Start to read; ``now_ns`` is called in the thread and gives the stamps [ns]."""
        self._port = settings.port
        self._baud = settings.baud
        self._now_ns = now_ns
        self._events: queue.Queue[PortEvent] = queue.Queue(WAITING)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name='serial port', daemon=True)
        self._thread.start()

    def poll(self) -> list[PortEvent]:
        """Return what has happened since the last time, in its order.

        An error comes again for each try that fails.
        """
        return [self._events.get() for _ in range(self._events.qsize())]

    def close(self) -> None:
        """End the thread, which closes the port."""
        self._closing.set()
        self._thread.join(10.0 * READ_TIMEOUT)

    def _run(self) -> None:
        lost: PortError | None = None
        while not self._closing.is_set():
            device = None
            try:
                device = self._open()
                self._put(Opened())
                self._read(device)
            except FAILURES as failure:
                if device is not None:
                    error = lost = self._lost()
                else:
                    error = self._not_opened(failure)
                    if lost is not None and isinstance(error, MissingPortError):
                        error = lost  # still the same
                self._put(error)
            finally:
                if device is not None:
                    device.close()
            self._closing.wait(RETRY)

    def _open(self) -> serial.SerialBase:
        return serial.serial_for_url(self._port, self._baud, timeout=READ_TIMEOUT, exclusive=True)

    def _read(self, device: serial.SerialBase) -> None:
        while not self._closing.is_set():
            # One byte, then the rest: a read of n bytes waits for all of them.
            data = device.read(1)
            if data:
                data += device.read(device.in_waiting)
                self._put(Received(data, self._now_ns()))

    def _put(self, event: PortEvent) -> None:
        while not self._closing.is_set():
            try:
                return self._events.put(event, timeout=READ_TIMEOUT)
            except queue.Full:
                continue

    def _lost(self) -> PortError:
        return LostPortError(
            f'{self._port}: the port is gone, unplugged or read by another program too; plug the '
            'board in again, or end that program: it is read on as soon as it is back'
        )

    def _not_opened(self, failure: Exception) -> PortError:
        number = getattr(failure, 'errno', None)
        if number in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
            return MissingPortError(
                f'{self._port}: there is no such port; plug the board in, or set '
                'driver.serial.port (ls /dev/serial/by-id shows those there are)'
            )
        if number in (errno.EACCES, errno.EPERM):
            return PortPermissionError(
                f'{self._port}: this user may not open it; `sudo usermod -aG dialout $USER`, then '
                'log in again'
            )
        if number in (errno.EAGAIN, errno.EBUSY):
            return BusyPortError(
                f'{self._port}: another program has it; end that one (`fuser -v {self._port}` '
                'names it)'
            )
        return PortError(
            f'{self._port}: it can not be opened as a serial port at {self._baud} baud '
            f'({failure}); set driver.serial.port and driver.serial.baud'
        )
