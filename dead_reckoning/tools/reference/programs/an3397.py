"""The program `an3397`: counts in, positions and frames out."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

from dead_reckoning.core.reference import an3397
from dead_reckoning.core.reference.an3397_frame import END_OF_FRAME, SHIFT
from dead_reckoning.tools.options import add_counts, whole
from dead_reckoning.tools.reference.table import Columns, read

SUMMARY = 'AN3397: acceleration, velocity, position and frame of an update of 64 conversions'

COLUMNS = Columns(
    names=('x', 'y'), minimum=0, maximum=255, rows=an3397.CALIBRATED + an3397.AVERAGED
)


def add_arguments(parser: ArgumentParser) -> None:
    """Add what the program takes."""
    add_counts(parser, 'columns x,y: a conversion per row; the first 1024 calibrate')
    parser.add_argument(
        '--corrected', action='store_true', help='clear the accumulator before each update'
    )
    parser.add_argument(
        '--shift',
        type=whole(0, 31),
        default=SHIFT,
        help='bits the position is shifted by to be sent; default %(default)s',
    )
    parser.add_argument(
        '--end-of-frame',
        type=whole(0, 255),
        default=END_OF_FRAME,
        metavar='BYTE',
        help='last byte of a frame; default 0xFE',
    )


def run(arguments: Namespace) -> list[str]:
    """Return a row per update."""
    updates = an3397.run(
        read(arguments.counts, COLUMNS),
        corrected=arguments.corrected,
        shift=arguments.shift,
        end_of_frame=arguments.end_of_frame,
    )
    rows = (f'{",".join(map(str, update[:-1]))},{update.frame.hex()}' for update in updates)
    return ['ax,ay,vx,vy,px,py,frame', *rows]
