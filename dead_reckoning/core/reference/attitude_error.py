"""CH Robotics' Table 1: what an error of the attitude does to acceleration, velocity and position.

Source: CH Robotics, *Using Accelerometers to Estimate Position and Velocity*, section 4.  Decimal
numbers, since the table was rounded before it was multiplied; docs/reference-algorithms.md derives
it.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal

ACCELERATIONS = {
    Decimal(angle): Decimal(accel)
    for angle, accel in (
        ('0.1', '0.017'),
        ('0.5', '0.086'),
        ('1.0', '0.17'),
        ('1.5', '0.256'),
        ('2.0', '0.342'),
        ('3.0', '0.513'),
        ('5.0', '0.854'),
    )
}
"""g · sin of the angle [m/s²] by the angle [°], as the table rounds it: 1.0 and 1.5 by no rule."""

VELOCITY_TIME = 10
"""When the velocity is given [s]."""

POSITION_TIMES = (10, 60, 600, 3600)
"""When the position is given [s]."""

DIGITS = 2
"""Significant digits of the last column."""


@dataclass(frozen=True, slots=True)
class Row:
    """Give a row of the table, each number with the digits it is printed with.

    ``angle`` [°], ``acceleration`` [m/s²], ``velocity`` [m/s], ``positions`` [m].
    """

    angle: Decimal
    acceleration: Decimal
    velocity: Decimal
    positions: tuple[Decimal, ...]


def table(corrected: bool = False) -> list[Row]:
    """Return the table with its positions a·t², or corrected with ½·a·t²; nothing else differs.

    >>> [str(table(corrected)[2].positions[0]) for corrected in (False, True)]
    ['17', '8.5']
    """
    factor = Decimal('0.5') if corrected else Decimal(1)
    rows = []
    for angle, accel in ACCELERATIONS.items():
        *positions, last = (_plain(factor * accel * time**2) for time in POSITION_TIMES)
        rounded = last.quantize(Decimal(1).scaleb(last.adjusted() - DIGITS + 1))
        velocity = _plain(accel * VELOCITY_TIME)
        rows.append(Row(angle, accel, velocity, (*positions, rounded)))
    return rows


def _plain(number: Decimal) -> Decimal:
    """Return a number without zeros at its end, and without an exponent."""
    plain = number.normalize()
    return plain.quantize(Decimal(1)) if plain == plain.to_integral_value() else plain
