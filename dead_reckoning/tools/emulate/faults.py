"""What goes wrong between a board and its host, and how `--faults` says it."""

from __future__ import annotations

import argparse
from dataclasses import dataclass, fields

from dead_reckoning.tools.options import finite

SHORTEST_HANGUP = 0.1
"""Shortest time [s] between a return and the next hang-up."""


@dataclass(frozen=True, kw_only=True)
class Faults:
    """Faults of a wire.

    ``drop``, ``flip``, ``double``  probability of each byte to be lost, to have a bit turned, to
                                    come twice.
    ``pause``   probability of each byte to be followed by a pause of the board.
    ``hangup``  the board is pulled out after so long [s], comes back, and so on; 0 for never.
    """

    drop: float = 0.0
    flip: float = 0.0
    double: float = 0.0
    pause: float = 0.0
    hangup: float = 0.0


NAMES = tuple(field.name for field in fields(Faults))


def parse(text: str) -> Faults:
    """Convert ``drop:0.001,hangup:10``; raises `argparse.ArgumentTypeError` for others."""
    found: dict[str, float] = {}
    for part in text.split(','):
        name, separator, value = part.strip().partition(':')
        if name not in NAMES or not separator:
            raise argparse.ArgumentTypeError(
                f'{part.strip()!r} is no fault; allowed are {", ".join(NAMES)}, each with its '
                "value and commas between, as 'drop:0.001,hangup:10'"
            )
        if name in found:
            raise argparse.ArgumentTypeError(f'{name} is there twice')
        number = finite(value)
        if name == 'hangup':
            if number < SHORTEST_HANGUP:
                raise argparse.ArgumentTypeError(
                    f'hangup: {value} is not allowed; a time from {SHORTEST_HANGUP:g} s'
                )
        elif not 0.0 <= number <= 1.0:
            raise argparse.ArgumentTypeError(
                f'{name}: {value} is not allowed; a probability of each byte, from 0 to 1'
            )
        found[name] = number
    return Faults(**found)
