"""The command `calibrate`: what to calibrate, its options, and what is printed and written."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from dead_reckoning.core import step_lengths
from dead_reckoning.core.errors import InputError, RecordingError, SettingsError
from dead_reckoning.tools.options import add_recordings, positive


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add a command for each thing that can be calibrated."""
    commands = parser.add_subparsers(dest='what', required=True, metavar='WHAT')
    words = 'fit the constant of every model of step lengths to walks of known distances'
    step_length = commands.add_parser('step-length', help=words, description=words)
    add_recordings(step_length)
    step_length.add_argument(
        '--distance',
        type=positive,
        nargs='+',
        required=True,
        metavar='M',
        help='how far was walked in each recording, or in all alike [m]',
    )
    step_length.add_argument(
        '--config', type=Path, metavar='YAML', help='parameter file of the nodes; default: none'
    )
    step_length.add_argument(
        '--model',
        choices=step_lengths.names(),
        help='which to write; default: the one with the smallest error, that of --config where '
        'a single recording tells none',
    )
    step_length.add_argument(
        '--output',
        type=Path,
        default=Path('step_length.yaml'),
        metavar='YAML',
        help='parameter file to write; default: step_length.yaml',
    )


def main(arguments: argparse.Namespace) -> int:
    """Calibrate the step length; print the tables, write the file; return the exit status."""
    from dead_reckoning.core.kernels import SLOW, accelerated
    from dead_reckoning.tools.calibrate.step_length import Walk, calibrate, configured, walk
    from dead_reckoning.tools.files import complete_or_absent
    from dead_reckoning.tools.replay.command import faults

    inputs, distances, output = arguments.inputs, arguments.distance, arguments.output
    if len(distances) == 1:
        distances *= len(inputs)
    if len(distances) != len(inputs):
        raise InputError(
            f'--distance: {len(distances)} of them for {len(inputs)} recordings; name one for '
            'each, or one for all'
        )
    if output.is_dir():
        raise InputError(f'--output {output}: a folder, where a file is to be named')
    if not accelerated():
        print(SLOW, file=sys.stderr)
    try:
        configuration = configured(arguments.config)
        walks: list[Walk] = []
        for path, distance in zip(inputs, distances, strict=True):
            walked = walk(
                path, distance, configuration, arguments.imu, arguments.rate, arguments.remap
            )
            for said in faults(walked):
                print(f'{path}: {said}', file=sys.stderr)
            walks.append(walked)
        found = calibrate(walks, configuration, arguments.model)
    except (RecordingError, SettingsError) as error:
        raise InputError(str(error)) from error
    with complete_or_absent(output.parent, [output.name]) as folder:
        (folder / output.name).write_text(found.yaml(), encoding='utf-8')
    print(found.text())
    print(f'\nparameters  {output}')
    return 0
