"""Write and read the seven bytes in which AN3397's program sends a position.

Freescale AN3397, function ``data_transfer``: ``03 direction |x| |y| 01 01 end``.  The position was
shifted up first, and the highest byte of its magnitude is what is sent.  Neither the value of the
last byte nor the baud rate is in the document.
"""

from __future__ import annotations

from dead_reckoning.core.errors import FrameError
from dead_reckoning.core.reference.wrap import signed

SHIFT = 18
"""By how many bits the document's positions go up before they are sent."""

END_OF_FRAME = 0xFE
"""The last byte, by choice of this package."""

LENGTH = 7
HEAD = 0x03
FILL = 0x01

X_POSITIVE = 0x10
X_NEGATIVE = 0x80
Y_POSITIVE = 0x08
Y_NEGATIVE = 0x01
"""Bits of the second byte; a position of 0 is positive."""

SENT_BITS = 24
"""How many bits of a magnitude are below the byte that is sent."""

SIGNS = {
    positive_x | positive_y: (sign_x, sign_y)
    for positive_x, sign_x in ((X_POSITIVE, 1), (X_NEGATIVE, -1))
    for positive_y, sign_y in ((Y_POSITIVE, 1), (Y_NEGATIVE, -1))
}
"""Signs of x and y by the direction byte: four values, all others are no direction."""


def encode(x: int, y: int, shift: int = SHIFT, end_of_frame: int = END_OF_FRAME) -> bytes:
    """Return the frame of a position in counts; what the shift pushes out of 32 bits is lost.

    >>> encode(640, -640).hex(' ')
    '03 11 0a 0a 01 01 fe'
    """
    sent_x = signed(x << shift, 32)
    sent_y = signed(y << shift, 32)
    direction = X_POSITIVE if sent_x >= 0 else X_NEGATIVE
    direction |= Y_POSITIVE if sent_y >= 0 else Y_NEGATIVE
    byte_x = abs(sent_x) >> SENT_BITS
    byte_y = abs(sent_y) >> SENT_BITS
    return bytes((HEAD, direction, byte_x, byte_y, FILL, FILL, end_of_frame))


def decode(frame: bytes, shift: int = SHIFT, end_of_frame: int = END_OF_FRAME) -> tuple[int, int]:
    """Return the position of a frame in counts, as far as the frame holds it.

    By the document's shift that is trunc(p / 64) · 64.  Raises `FrameError` for bytes that
    `encode` does not make.

    >>> decode(bytes.fromhex('03 11 0a 0a 01 01 fe'))
    (640, -640)
    """
    if len(frame) != LENGTH:
        raise FrameError(f'a frame of AN3397 has {LENGTH} bytes, not {len(frame)}')
    head, direction, byte_x, byte_y, *fill, end = frame
    if (head, *fill, end) != (HEAD, FILL, FILL, end_of_frame):
        raise FrameError(
            f'{frame.hex(" ")} is no frame of AN3397: '
            f'{HEAD:02x} … {FILL:02x} {FILL:02x} {end_of_frame:02x}'
        )
    if direction not in SIGNS:
        raise FrameError(f'{direction:#04x} in {frame.hex(" ")} is no direction of AN3397')
    sign_x, sign_y = SIGNS[direction]
    return (
        _position(sign_x, byte_x, shift, frame),
        _position(sign_y, byte_y, shift, frame),
    )


def _position(sign: int, byte: int, shift: int, frame: bytes) -> int:
    # A positive 32-bit number ends at 127.99, a negative one at -128.
    if byte > (127 if sign > 0 else 128):
        raise FrameError(f'{byte} in {frame.hex(" ")} is beyond what 32 bits hold')
    return sign * (byte << SENT_BITS >> shift)
