"""Options that several programs take, with their checks; argparse ends with status 2."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path


def add_counts(parser: argparse.ArgumentParser, what: str) -> None:
    """Add the file of counts."""
    parser.add_argument('counts', metavar='COUNTS.csv', type=Path, help=what)


def whole(minimum: int, maximum: int | None = None) -> Callable[[str], int]:
    """Return a converter of whole numbers, hexadecimal with 0x, from one number to another."""

    def convert(text: str) -> int:
        try:
            value = int(text, 0)
        except ValueError:
            raise argparse.ArgumentTypeError(f'{text!r} is no whole number') from None
        if value < minimum or (maximum is not None and value > maximum):
            allowed = f'below {minimum}' if maximum is None else f'outside {minimum} to {maximum}'
            raise argparse.ArgumentTypeError(f'{text} is {allowed}')
        return value

    return convert


def finite(text: str) -> float:
    """Convert a number that is neither infinite nor NaN."""
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r} is no number') from None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f'{text} is not finite')
    return value


def positive(text: str) -> float:
    """Convert a finite number above 0."""
    value = finite(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f'{text} is not above 0')
    return value
