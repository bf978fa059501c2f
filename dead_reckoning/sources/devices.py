"""Devices that are read in a thread of their own, for as long as they are there."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.errors import DeadReckoningError, DeviceError
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stamps import RESTART_NS

RETRY = 1.0
"""Time [s] between two tries to open a device."""

WAITING = 1024
"""Events that may wait to be taken."""

PATIENCE = 0.2
"""Longest time [s] between two looks whether to end."""

GAIN = 0.05
"""How much of what a stamp is off goes into the period of a `FifoClock`."""


@dataclass(frozen=True, slots=True)
class Opened:
    """The device is set up; ``notice`` is what a user should know of how it is read."""

    notice: str = ''


@dataclass(frozen=True, slots=True)
class Heading:
    """A heading [rad], clockwise from magnetic north, at a stamp."""

    stamp_ns: int
    heading: float


@dataclass(frozen=True, slots=True)
class Calibration:
    """The device calibrates itself; ``said`` is for the user, and empty until it has ended."""

    said: str = ''


DeviceEvent: TypeAlias = Opened | Conversions | Heading | Calibration | DeadReckoningError
Wait: TypeAlias = Callable[[float], object]
"""Sleep this long [s], or until the end."""

Events: TypeAlias = Generator[DeviceEvent | None, None, None]
Session: TypeAlias = Callable[[Wait], Events]
"""Open a device, yield what happens, None where nothing does, and close it when closed.

It comes back to a yield every `PATIENCE`, and raises `DeviceError` when the device is lost.
"""


class DeviceThread:
    """Hold one session after the other, until `close`."""

    def __init__(self, session: Session, name: str) -> None:
        self._session = session
        self._events: queue.Queue[DeviceEvent] = queue.Queue(WAITING)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def poll(self) -> list[DeviceEvent]:
        """Return what has happened since the last time, in its order.

        A `DeviceError` comes again for each try that fails.
        """
        return [self._events.get() for _ in range(self._events.qsize())]

    def close(self) -> None:
        """End the session and the thread."""
        self._closing.set()
        self._thread.join(10.0 * PATIENCE)

    def _run(self) -> None:
        while not self._closing.is_set():
            try:
                with closing(self._session(self._closing.wait)) as events:
                    for event in events:
                        if event is not None:
                            self._put(event)
                        if self._closing.is_set():
                            break
            except DeviceError as error:
                self._put(error)
            self._closing.wait(RETRY)

    def _put(self, event: DeviceEvent) -> None:
        while not self._closing.is_set():
            try:
                return self._events.put(event, timeout=PATIENCE)
            except queue.Full:
                continue


class FifoClock:
    """Stamp samples that a device collects with a period of its own, and hands over at each look.

    The newest sample of a look is expected as many periods after the last one as samples came.  It
    can't be younger than the look, nor older than the look by a period, as another one would have
    come then: what lies beyond these bounds is moved to them, and a part of it corrects the
    period.  Looks at various times between two samples make the bounds tight.
    """

    def __init__(self, period: float) -> None:
        """``period`` [s] between samples, as far as it is known."""
        self._period_ns = period * NANOSECONDS
        self._last_ns: int | None = None

    def stamps(self, count: int, before_ns: int, after_ns: int) -> NDArray[np.int64]:
        """Return the stamps, shape (count,) [ns], of what a look between two stamps has found."""
        period_ns, last_ns = self._period_ns, self._last_ns
        if last_ns is None:
            expected_ns = after_ns - round(0.5 * period_ns)
        else:
            expected_ns = last_ns + round(count * period_ns)
        newest_ns = min(max(expected_ns, before_ns - round(period_ns)), after_ns)
        if last_ns is not None and 0 <= last_ns - newest_ns < RESTART_NS:
            newest_ns = last_ns + count  # the clock was set back a little: stamps rise
        elif last_ns is None or abs(newest_ns - expected_ns) >= RESTART_NS:
            last_ns = newest_ns - round(count * period_ns)
        else:
            off_ns = min(max(newest_ns - expected_ns, -period_ns), period_ns)
            self._period_ns += GAIN * off_ns / count
        self._last_ns = newest_ns
        steps = np.arange(1, count + 1) * ((newest_ns - last_ns) / count)
        stamps: NDArray[np.int64] = last_ns + np.rint(steps).astype(np.int64)
        return stamps
