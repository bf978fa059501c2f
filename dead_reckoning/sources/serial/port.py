"""A serial port that is read in a thread of its own; the one module that knows pySerial."""

from __future__ import annotations

import errno
import os
import queue
import termios
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
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
"""Time [s] to the next try to open the port, twice as long after each in vain."""

LONGEST_RETRY = 8.0
"""Longest time [s] between two tries."""

LOOK = 0.1
"""How often [s] it is looked whether the device file appeared: that is tried at once."""

READ_TIMEOUT = 0.2
"""Longest time [s] of one read, and so the longest that the end waits for it."""

WRITE_TIMEOUT = 0.2
"""Longest time [s] of a write to a board that takes no bytes."""

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
    locked, so that no other program that locks it reads half of the bytes.  What the board is told
    is written by whoever calls `send`.
    """

    def __init__(self, settings: SerialSettings, now_ns: Callable[[], int]) -> None:
        """Start to read; ``now_ns`` is called in the thread and gives the stamps [ns]."""
        self._port = settings.port
        self._baud = settings.baud
        self._now_ns = now_ns
        self._events: queue.Queue[PortEvent] = queue.Queue(WAITING)
        self._closing = threading.Event()
        self._device: serial.SerialBase | None = None
        self._writing = threading.Lock()
        self._thread = threading.Thread(target=self._run, name='serial port', daemon=True)
        self._thread.start()

    def poll(self) -> list[PortEvent]:
        """Return what has happened since the last time, in its order.

        An error comes again for each try that fails.
        """
        return [self._events.get() for _ in range(self._events.qsize())]

    def send(self, data: bytes) -> int | None:
        """Tell the board something; return the stamp [ns] from just before.

        None where it can not be told: what is wrong with the port comes from `poll`.
        """
        with self._writing:
            if self._device is None:
                return None
            stamp_ns = self._now_ns()
            try:
                self._device.write(data)
            except FAILURES:
                return None
            return stamp_ns

    def close(self, goodbye: bytes = b'') -> None:
        """End the thread, which closes the port; tell the board ``goodbye`` before."""
        if goodbye:
            self.send(goodbye)  # the system sends what it has taken, closed or not
        self._closing.set()
        self._thread.join(10.0 * READ_TIMEOUT)

    def _run(self) -> None:
        lost: PortError | None = None
        delay = RETRY
        while not self._closing.is_set():
            device = None
            tried = self._file()
            try:
                device = self._open()
                delay = RETRY
                with self._writing:
                    self._device = device
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
                with self._writing:
                    self._device = None
                if device is not None:
                    device.close()
            delay = RETRY if self._wait(delay, tried) else min(2.0 * delay, LONGEST_RETRY)

    def _open(self) -> serial.SerialBase:
        return serial.serial_for_url(
            self._port,
            self._baud,
            timeout=READ_TIMEOUT,
            write_timeout=WRITE_TIMEOUT,
            exclusive=True,
        )

    def _file(self) -> tuple[int, ...] | None:
        """Say which device file is there; it is another when its rights change, too."""
        try:
            status = os.stat(self._port)
        except OSError:
            return None
        # Time stands still for some ms at a time in st_ctime_ns.
        return status.st_dev, status.st_ino, status.st_ctime_ns, status.st_mode, status.st_gid

    def _wait(self, delay: float, tried: tuple[int, ...] | None) -> bool:
        """Wait for the next try; return early, and True, where another device file appears."""
        until = time.monotonic() + delay
        while (left := until - time.monotonic()) > 0.0:
            if self._closing.wait(min(LOOK, left)):
                return False
            if self._file() not in (None, tried):
                return True
        return False

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
                f'{self._port}: another program has it{_holders(self._port)}; end that one '
                f'(`fuser -v {self._port}` names it)'
            )
        return PortError(
            f'{self._port}: it can not be opened as a serial port at {self._baud} baud '
            f'({failure}); set driver.serial.port and driver.serial.baud'
        )


def _holders(port: str) -> str:
    """Name the programs that have a port open, as far as this user may see."""
    found: dict[str, str] = {}
    device = os.path.realpath(port)
    for process in Path('/proc').glob('[0-9]*'):
        try:
            files = process / 'fd'
            if any(os.readlink(files / name) == device for name in os.listdir(files)):
                found[process.name] = (process / 'comm').read_text().strip()
        except OSError:  # it has just ended, or belongs to others
            continue
    named = ', '.join(f'{name} (process {number})' for number, name in found.items())
    return f': {named}' if named else ''
