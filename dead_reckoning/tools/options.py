"""Options that several programs take, with their checks; argparse ends with status 2."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path


def add_counts(parser: argparse.ArgumentParser, what: str) -> None:
    """Add the file of counts."""
    parser.add_argument('counts', metavar='COUNTS.csv', type=Path, help=what)


def add_recordings(parser: argparse.ArgumentParser) -> None:
    """Add recordings, and what says how to read them."""
    parser.add_argument(
        'inputs',
        nargs='+',
        type=Path,
        metavar='INPUT',
        help='a rosbag2 folder, a ROS 1 .bag, or a .csv with a header',
    )
    parser.add_argument('--imu', metavar='TOPIC', help='topic of the Imu, where several may be')
    parser.add_argument(
        '-r',
        '--remap',
        type=_remap,
        action='append',
        default=[],
        metavar='NAME:=TOPIC',
        help='topic of a bag for an input, as aiding/odom:=/wheels/odom; may come several times',
    )
    parser.add_argument(
        '--rate', type=_rate, metavar='HZ', help='samples per second of a .csv without stamps'
    )


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


def _remap(text: str) -> tuple[str, str]:
    name, separator, topic = text.partition(':=')
    if not (name and separator and topic):
        raise argparse.ArgumentTypeError(f'{text!r} is not NAME:=TOPIC')
    return name, topic


def _rate(text: str) -> float:
    try:
        rate = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r} is no number') from None
    if not 0.0 < rate <= 1e6:
        raise argparse.ArgumentTypeError(f'{text} is no rate from 0 to 1000000 Hz')
    return rate
