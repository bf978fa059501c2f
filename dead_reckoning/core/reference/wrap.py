"""Integers as a controller keeps them."""


def signed(value: int, bits: int) -> int:
    """Return what is left of a number in a signed integer, as two's complement wraps it.

    >>> signed(0x7FFF + 1, 16), signed(-5, 16)
    (-32768, -5)
    """
    half = 1 << (bits - 1)
    return (value + half & (1 << bits) - 1) - half
