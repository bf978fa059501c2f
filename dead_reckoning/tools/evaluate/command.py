"""The command `evaluate`: read estimate and truth, compare, print tables, write figures."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from dead_reckoning.core.errors import InputError
from dead_reckoning.tools.options import positive, whole

ALIGNMENTS = ('yaw', 'se3', 'none')
UNITS = ('frames', 'm', 's')
TRACKS = ('odometry', 'smoothed', 'pedestrian')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what the command takes."""
    add = parser.add_argument
    add('folder', metavar='DIR', type=Path, help='what `dead-reckoning replay` wrote')
    add(
        '--truth',
        metavar='FILE',
        type=Path,
        help='a TUM file, an odometry.csv, a steps.csv or a recording',
    )
    add('--topic', help='Odometry or PoseStamped of the recording that is the truth')
    add('--steps', type=whole(0), metavar='N', help='how many steps were walked')
    add('--distance', type=positive, metavar='M', help='how far it was [m]')
    add('--track', choices=TRACKS, help='which CSV of DIR to compare; default: the first there')
    add(
        '--align',
        choices=ALIGNMENTS,
        default='yaw',
        help='lay the estimate over the truth by heading and translation (the default), by any '
        'rotation and translation (Umeyama), or not',
    )
    add(
        '--max-difference',
        type=positive,
        default=0.01,
        metavar='S',
        help='how far stamps of one pair may be apart [s]; default 0.01',
    )
    add('--delta', type=positive, default=1.0, metavar='D', help='motion of the RPE; default 1')
    add('--delta-unit', choices=UNITS, default='s', help='its unit; default s')
    add('--output', type=Path, metavar='FILE', help='figures; default: DIR/evaluation.json')


def main(arguments: argparse.Namespace) -> int:
    """Compare, print the tables and write evaluation.json; return the exit status."""
    from dead_reckoning.tools.evaluate.comparison import Options, compare
    from dead_reckoning.tools.evaluate.text import text
    from dead_reckoning.tools.files import complete_or_absent

    if arguments.truth is None and arguments.steps is None and arguments.distance is None:
        raise InputError('nothing to compare with: name --truth, --steps or --distance')
    if arguments.topic is not None and arguments.truth is None:
        raise InputError('--topic names one of the recording that --truth names, which is missing')
    if arguments.delta_unit == 'frames' and arguments.delta % 1.0:
        raise InputError(f'--delta {arguments.delta:g}: frames are whole')
    output = arguments.output or arguments.folder / 'evaluation.json'
    if output.is_dir():
        raise InputError(f'--output {output}: a folder, where a file is to be named')
    given = vars(arguments)
    evaluation = compare(Options(**{name: given[name] for name in Options.__dataclass_fields__}))
    with complete_or_absent(output.parent, [output.name]) as folder:
        figures = json.dumps(evaluation, indent=2)
        (folder / output.name).write_text(f'{figures}\n', encoding='utf-8')
    print(text(evaluation))
    print(f'\nfigures  {output}')
    return 0
