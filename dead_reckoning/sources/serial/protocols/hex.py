"""Lines of thirteen hexadecimal digits: a running number and three counts of 10 bits."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import ClassVar

from dead_reckoning.core.errors import FrameError
from dead_reckoning.core.parameters import Settings
from dead_reckoning.sources.serial.lines import SHOWN, LineDecoder
from dead_reckoning.sources.serial.protocols import Measurement, Reading

MODULUS = 1 << 16
"""What the running number is sent modulo."""

_LINE = re.compile('([0-9A-Fa-f]{4})' + 3 * '([0-3][0-9A-Fa-f]{2})')


@dataclass(frozen=True, kw_only=True)
class HexSettings(Settings, prefix='driver.serial.hex'):
    """Lines AAAAXXXYYYZZZ of hexadecimal digits; there is nothing to set."""


class HexDecoder(LineDecoder):
    """Read lines ``AAAAXXXYYYZZZ``: a number that runs by 1 a line, and counts of x, y, z.

    A line is a reading only if it is thirteen digits, and no count is above 10 bits.  The running
    number is unwrapped to the nearest.  A disturbed one makes the clock go back, once or with the
    line behind it, and what fits it starts anew.
    """

    Settings: ClassVar[type[Settings]] = HexSettings
    BITS = 10
    unit = 'counts'

    def __init__(self, settings: HexSettings) -> None:
        super().__init__()
        self._number: int | None = None

    def _reading(self, text: str, start: int) -> Reading:
        found = _LINE.fullmatch(text)
        if found is None:
            raise FrameError(
                f'{text[:SHOWN]!r} is not AAAAXXXYYYZZZ, thirteen hexadecimal digits with counts '
                'to 3FF: is driver.serial.protocol another, or the line disturbed?'
            )
        number, x, y, z = (int(digits, 16) for digits in found.groups())
        last = number if self._number is None else self._number
        half = MODULUS // 2
        self._number = last + (number - last + half) % MODULUS - half
        return Reading((float(x), float(y), float(z)), start, clock=float(self._number))


class HexBoard:
    """Send each measurement as a line, and number them."""

    def __init__(self, settings: HexSettings) -> None:
        self._number = 0

    def hear(self, data: bytes) -> bytes:
        """Take no notice."""
        return b''

    def measure(self, measurement: Measurement) -> bytes:
        """Return a line, its counts kept within 10 bits."""
        counts = [min(max(round(count), 0), 0x3FF) for count in measurement.values['counts']]
        number, self._number = self._number, (self._number + 1) % MODULUS
        return (f'{number:04X}' + ''.join(f'{count:03X}' for count in counts) + '\r\n').encode()


PROTOCOL, BOARD = HexDecoder, HexBoard
