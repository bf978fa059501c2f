"""The program `mbed`: counts in, acceleration, velocity and position out."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from dataclasses import fields

from dead_reckoning.core.reference import mbed
from dead_reckoning.tables import number_rows
from dead_reckoning.tools.options import add_counts, finite, whole
from dead_reckoning.tools.reference.table import Columns, read

SUMMARY = 'mbed page: acceleration, velocity and position of an update, in units of the gain'

INT_MAX = 2**31 - 1


def add_arguments(parser: ArgumentParser) -> None:
    """Add what the program takes; the page leaves all of it to its user."""
    add_counts(parser, 'column x: a conversion per row; the first ones calibrate')
    for option, convert, words in (
        ('calibration-count', whole(1, INT_MAX), 'conversions of the zero'),
        ('sample-count', whole(1, INT_MAX), 'conversions of an update'),
        ('window-min', finite, 'least average without its zero that counts as none'),
        ('window-max', finite, 'greatest average without its zero that counts as none'),
        ('gain', finite, 'acceleration per count'),
        ('update-time', finite, 'time of an update'),
        ('no-movement', whole(0, INT_MAX), 'more quiet updates than this end the movement'),
    ):
        parser.add_argument(f'--{option}', type=convert, required=True, metavar='N', help=words)


def run(arguments: Namespace) -> list[str]:
    """Return a row per update, in as many digits as the doubles need."""
    constants = mbed.Constants(
        **{field.name: getattr(arguments, field.name) for field in fields(mbed.Constants)}
    )
    columns = Columns(
        names=('x',),
        minimum=-32768,
        maximum=32767,
        rows=constants.calibration_count + constants.sample_count,
    )
    updates = mbed.run(read(arguments.counts, columns)[:, 0], constants)
    return ['a,v,p', *number_rows(updates)]
