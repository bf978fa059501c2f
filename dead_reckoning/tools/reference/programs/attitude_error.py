"""The program `attitude-error`: CH Robotics' Table 1."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from dead_reckoning.core.reference.attitude_error import table

SUMMARY = 'CH Robotics, Table 1: errors of velocity and position by the error of the attitude'

HEADER = (
    'angle_deg,acceleration,velocity_10s,position_10s,position_1min,position_10min,position_1h'
)


def add_arguments(parser: ArgumentParser) -> None:
    """Add what the program takes."""
    parser.add_argument(
        '--corrected', action='store_true', help='positions ½·a·t² where the table has a·t²'
    )


def run(arguments: Namespace) -> list[str]:
    """Return a row per angle, in SI but for the angle."""
    lines = [HEADER]
    for row in table(arguments.corrected):
        *positions, last = row.positions
        numbers = (row.angle, row.acceleration, row.velocity, *positions)
        # In thousands or millions, as the table does.
        lines.append(','.join([*map(str, numbers), last.to_eng_string().replace('E+', 'e')]))
    return lines
