"""The program `an900`: counts in, steps and their lengths out."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from dead_reckoning.core.reference import an900
from dead_reckoning.tools.options import add_counts, whole
from dead_reckoning.tools.reference.table import Columns, read

SUMMARY = 'AN-900: the steps, their lengths and the distance'

COLUMNS = Columns(names=('x', 'y'), minimum=an900.LOWEST, maximum=an900.HIGHEST, rows=an900.FEWEST)

INT_MAX = 2**31 - 1


def add_arguments(parser: ArgumentParser) -> None:
    """Add what the program takes."""
    add_counts(parser, 'columns x,y: a sample per row, which is the sum of four conversions')
    parser.add_argument(
        '--corrected',
        action='store_true',
        help='the middle of maximum and minimum, and absolute values of floats',
    )
    parser.add_argument(
        '--avgconst',
        type=whole(1, INT_MAX),
        default=1,
        metavar='N',
        help='how slowly the average follows the stride; default %(default)s: not averaged',
    )


def run(arguments: Namespace) -> list[str]:
    """Return a row per step."""
    steps = an900.run(
        read(arguments.counts, COLUMNS),
        corrected=arguments.corrected,
        average=arguments.avgconst,
    )
    rows = (
        f'{step.sample},{step.stride:.6f},{step.average_stride:.6f},{step.steps},'
        f'{step.distance:.6f}'
        for step in steps
    )
    return ['sample,stride,average_stride,steps,distance', *rows]
