"""What boards send and are told, and how to read it: one module each, found by its name.

A module of this package offers both ends of the wire, neither of which sees a port or a clock:
``PROTOCOL``, a `Decoder`, is the end of the driver, ``BOARD``, a `Board`, that of the emulator.
Both are built from the settings of the protocol (their prefix is ``driver.serial.`` and the name
of the module).  A new protocol is one file.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, Protocol, TypeAlias

from dead_reckoning.core.errors import ReadingError
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.samples import Quaternion, Vector
from dead_reckoning.core.stages import RAW


@dataclass(frozen=True, slots=True)
class Reading:
    """One conversion of the three axes, as a board sent it.

    ``values``       x, y, z in the ``unit`` of its decoder.
    ``start``        how many bytes the decoder had been fed before the first of its bytes.
    ``clock``        when, by the clock of the board: a running number of conversions or a time, in
                     any unit, that does not wrap; None where it sends none.
    ``rate``         rate of turn [rad/s], frame s; None where it has no gyroscope.
    ``orientation``  of the sensor in the world (ENU), x, y, z, w; None unless it measures that.
    """

    values: Vector
    start: int
    clock: float | None = None
    rate: Vector | None = None
    orientation: Quaternion | None = None


@dataclass(frozen=True, slots=True)
class Position:
    """Where a board says it is: ``x``, ``y`` [m] from its start; ``start`` as in `Reading`."""

    x: float
    y: float
    start: int


Event: TypeAlias = Reading | Position | ReadingError
"""What a decoder finds in the bytes: a reading, or why there is none."""


class Decoder(Protocol):
    """Find readings in the bytes of a board, whatever else comes, and say what the board is told.

    However the bytes are cut into calls of `feed`, the events are the same.  No bytes make it
    raise, or keep more than a bounded number of them.
    """

    Settings: ClassVar[type[Settings]]
    BITS: ClassVar[int | None] = None
    """Bits of the counts it reads, where the protocol fixes them."""
    POLLED: ClassVar[bool] = False
    """Whether each reading answers what `due` said, so that it was measured in between."""
    OUTPUT: ClassVar[str] = RAW
    """Topic of what it reads."""

    unit: str
    """Unit of the readings: one of `dead_reckoning.core.accelerometer.UNITS`."""
    range_g: float | None = None
    """Range ± [g] that the board has or is told to take, where the decoder sees to it."""

    def feed(self, data: bytes) -> list[Event]:
        """Take the next bytes and return what they complete, in the order of the bytes."""

    def restart(self) -> list[Event]:
        """Forget what is incomplete, since the bytes to come do not follow on.

        What comes first then may be the rest of something, and is no reading.  Bytes are counted
        on, and what the board is told begins anew.
        """

    def due(self, waited: float) -> bytes:
        """Return what the board is to be told now; empty for nothing.

        ``waited`` [s] since it was told something, infinite after a restart.  Asked after each
        `feed`, and a hundred times a second besides.
        """
        return b''

    def goodbye(self) -> bytes:
        """Return what the board is told before the port is closed, so that it falls silent."""
        return b''


@dataclass(frozen=True, slots=True)
class Measurement:
    """What a board has just measured.

    ``values``       x, y, z in each of `dead_reckoning.core.accelerometer.UNITS`, by its name.
    ``time``         since the board was switched on [s].
    ``rate``         [rad/s], frame s.
    ``orientation``  of the sensor in the world (ENU), x, y, z, w.
    ``position``     of the sensor in the world [m].
    """

    values: Mapping[str, Vector]
    time: float
    rate: Vector
    orientation: Quaternion
    position: Vector


class Board(Protocol):
    """A board as it is seen from its wire: what it sends, and what it makes of what it is told.

    One that averages many measurements into what it sends says how many it takes a second [Hz], in
    a class attribute ``RATE``.
    """

    def hear(self, data: bytes) -> bytes:
        """Take bytes and return the answer."""

    def measure(self, measurement: Measurement) -> bytes:
        """Take a measurement; return what is sent of it at once, nothing where it is polled."""


def names() -> tuple[str, ...]:
    """List the protocols there are."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def decoder_class(name: str) -> Any:
    """Return the decoder of a protocol by its name."""
    return import_module(f'{__name__}.{name}').PROTOCOL


def board_class(name: str) -> Any:
    """Return the board of a protocol by its name."""
    return import_module(f'{__name__}.{name}').BOARD
