"""Freescale's ZSTAR3: the ZSTAR's protocol with values of 16 bits.

Order of their bytes and whether they have a sign are not confirmed, and so parameters.  The one
frame that its manual shows, and a host program, have the high byte first and a sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.serial.protocols.zstar import ZstarBoard, ZstarDecoder, ZstarSettings

MIDDLE = 0x8000
"""Count at half of the scale; a value with a sign counts from there."""


@dataclass(frozen=True, kw_only=True)
class Zstar3Settings(ZstarSettings, prefix='driver.serial.zstar3'):
    """A ZSTAR3, polled through its USB stick."""

    request: str = parameter(
        'V',
        'What it is asked: V, or v, whose longer answer always shows a byte that is lost or '
        'doubled',
        choices=('V', 'v'),
    )
    byte_order: str = parameter(
        'big', 'Which byte of a value comes first: the high one (big) or the low one (little)',
        choices=('big', 'little'),
    )  # fmt: skip
    signed: bool = parameter(
        True, 'Whether values have a sign and count from half of the supply, else from 0 V'
    )

    @property
    def order(self) -> Literal['big', 'little']:
        """The order of the bytes, as Python calls it."""
        return 'little' if self.byte_order == 'little' else 'big'


class Zstar3Decoder(ZstarDecoder):
    """Do as with a ZSTAR, in the mode of 16 bits; a board that was reset leaves it."""

    Settings: ClassVar[type[Settings]] = Zstar3Settings
    BITS: ClassVar[int | None] = 16
    HELLO: ClassVar[bytes] = b'r'
    READY: ClassVar[bytes] = b'z'
    ANSWERS: ClassVar[dict[str, bytes]] = {
        'V': rb'x(..)y(..)z(..)',
        'v': rb'x(..)y(..)z(..)s.t..b..',
    }

    def __init__(self, settings: Zstar3Settings) -> None:
        super().__init__(settings)
        self._order = settings.order
        self._flip = MIDDLE if settings.signed else 0

    def _value(self, raw: bytes) -> float:
        return float(int.from_bytes(raw, self._order) ^ self._flip)

    def goodbye(self) -> bytes:
        """Return to 8 bits, which other programs may expect."""
        return b'R'


class Zstar3Board(ZstarBoard):
    """Answer as a ZSTAR until it is told to use 16 bits; a g-select is answered."""

    BITS: ClassVar[int] = 16
    GREETINGS: ClassVar[dict[bytes, bytes]] = {b'R': b'N', b'r': b'z'}

    def __init__(self, settings: Zstar3Settings) -> None:
        super().__init__(settings)
        self._order = settings.order
        self._flip = MIDDLE if settings.signed else 0
        self._wide = False

    def _greet(self, letter: bytes) -> bytes:
        self._wide = letter == b'r'
        return super()._greet(letter)

    def _select(self, range_: int) -> bytes:
        return super()._select(range_) + b'G%d' % range_

    def _number(self, value: int) -> bytes:
        raw = (value ^ self._flip).to_bytes(2, self._order)
        high = (value ^ self._flip) >> 8
        return raw if self._wide else bytes([high])

    def _more(self) -> bytes:
        return b's\0t\0\0b\0\0' if self._wide else super()._more()


PROTOCOL, BOARD = Zstar3Decoder, Zstar3Board
