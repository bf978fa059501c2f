"""What boards send, and how to read it: one module each, found by its name.

A module of this package offers ``PROTOCOL``, a `Decoder` that is built from its own settings
(their prefix is ``driver.serial.`` and the name of the module).  A new protocol is one file.
"""

from __future__ import annotations

import pkgutil
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, Protocol, TypeAlias

from dead_reckoning.core.errors import ReadingError
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.samples import Vector


@dataclass(frozen=True, slots=True)
class Reading:
    """One conversion of the three axes, as a board sent it.

    ``values``  x, y, z in the ``unit`` of its decoder.
    ``start``   how many bytes the decoder had been fed before the first of its bytes.
    """

    values: Vector
    start: int


Event: TypeAlias = Reading | ReadingError
"""What a decoder finds in the bytes: a reading, or why there is none."""


class Decoder(Protocol):
    """Find readings in the bytes of a board, whatever else comes; no port, no clock.

    However the bytes are cut into calls of `feed`, the events are the same.  No bytes make it
    raise, or keep more than a bounded number of them.
    """

    Settings: ClassVar[type[Settings]]

    unit: str
    """Unit of the readings: one of `dead_reckoning.core.accelerometer.UNITS`."""

    def feed(self, data: bytes) -> list[Event]:
        """Take the next bytes and return what they complete, in the order of the bytes."""

    def restart(self) -> list[Event]:
        """Forget what is incomplete, since the bytes to come do not follow on.

        What comes first then may be the rest of something, and is no reading.  Bytes are counted
        on.
        """


def names() -> tuple[str, ...]:
    """List the protocols there are."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def decoder_class(name: str) -> Any:
    """Return the decoder of a protocol by its name."""
    return import_module(f'{__name__}.{name}').PROTOCOL
