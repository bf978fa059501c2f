"""The command `replay`: run the configured chain over recordings."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from dead_reckoning.core.errors import DeadReckoningError, InputError
from dead_reckoning.tools.options import add_recordings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what the command takes."""
    add_recordings(parser)
    parser.add_argument('--config', type=Path, required=True, help='parameter file of the nodes')
    parser.add_argument(
        '--output',
        type=Path,
        required=True,
        metavar='DIR',
        help='folder for the outputs; of several inputs each gets a folder in it',
    )
    parser.add_argument(
        '--outputs', metavar='LIST', help='names of outputs with commas between; default: all'
    )
    parser.add_argument(
        '--jobs', type=_jobs, default=1, metavar='N', help='replay so many inputs at a time'
    )
    parser.add_argument(
        '--scheduler', metavar='ADDRESS', help='replay on the Dask cluster of this scheduler'
    )


def main(arguments: argparse.Namespace) -> int:
    """Replay the inputs; return the exit status: 1 where one of several failed."""
    from dead_reckoning.configuration import Configuration
    from dead_reckoning.core.errors import RecordingError, SettingsError
    from dead_reckoning.core.kernels import SLOW, accelerated
    from dead_reckoning.core.pipeline import Pipeline
    from dead_reckoning.tools.files import made
    from dead_reckoning.tools.replay.many import executor, folders, run_all
    from dead_reckoning.tools.replay.progress import Progress
    from dead_reckoning.tools.replay.run import Job, chosen

    wanted = None if arguments.outputs is None else tuple(arguments.outputs.split(','))
    try:
        configuration = Configuration.load(arguments.config)
        chosen(wanted, Pipeline(configuration, blocks=True))  # what is wrong for all is said once
    except SettingsError as error:
        raise InputError(f'--config {error}') from error
    at_once = min(arguments.jobs, len(arguments.inputs))
    alone = at_once == 1 and arguments.scheduler is None
    jobs = [
        Job(
            path=path.absolute(),
            folder=folder.absolute(),
            configuration=configuration,
            wanted=wanted,
            imu=arguments.imu,
            rate=arguments.rate,
            remaps=dict(arguments.remap),
            watched=alone,
        )
        for path, folder in zip(
            arguments.inputs, folders(arguments.inputs, arguments.output), strict=True
        )
    ]
    if not accelerated():
        print(SLOW, file=sys.stderr)
    with (
        made(arguments.output),
        executor(at_once, arguments.scheduler) as pool,
        Progress('recordings', len(jobs), not alone) as progress,
    ):
        outcomes = run_all(jobs, pool, progress)
    if len(outcomes) == 1 and isinstance(outcomes[0], DeadReckoningError):
        only = outcomes[0]
        if isinstance(only, (RecordingError, SettingsError)):
            raise InputError(str(only)) from only
        raise only
    print(table(arguments.inputs, outcomes))
    for path, outcome in zip(arguments.inputs, outcomes, strict=True):
        for said in faults(outcome):
            print(f'{path}: {said}', file=sys.stderr)
    return int(any(isinstance(outcome, DeadReckoningError) for outcome in outcomes))


HEAD = (
    'input', 'samples', 'duration', 'steps', 'strides', 'distance', 'path', 'end position',
    'dropped', 'took',
)  # fmt: skip
NONE = '–'


def table(paths: list[Path], outcomes: list[Any]) -> str:
    """Return a line for each input: figures, those that some have, or why there are none."""
    rows: list[tuple[str, ...]] = [HEAD]
    for path, outcome in zip(paths, outcomes, strict=True):
        if isinstance(outcome, DeadReckoningError):
            rows.append((str(path), str(outcome).removeprefix(str(path.absolute())).lstrip(':, ')))
            continue
        figures = outcome.figures
        end = figures['end_position_m']
        rows.append(
            (
                str(path),
                str(figures['samples']),
                f'{figures["duration_s"]:.1f} s',
                _said(figures['steps'], ''),
                _said(figures['strides'], ''),
                _said(figures['distance_m'], '.1f', ' m'),
                _said(figures['path_length_m'], '.1f', ' m'),
                NONE if end is None else ', '.join(f'{x:.2f}' for x in end) + ' m',
                str(sum(figures['dropped'].values())),
                f'{outcome.seconds:.1f} s',
            )
        )
    columns = list(zip(*(row for row in rows if len(row) == len(HEAD)), strict=True))
    shown = [k for k, column in enumerate(columns) if set(column[1:]) != {NONE}]
    rows = [tuple(row[k] for k in shown) if len(row) == len(HEAD) else row for row in rows]
    whole = [row for row in rows if len(row) == len(shown)]
    widths = [max(map(len, column)) for column in zip(*whole, strict=True)]
    widths[0] = max(len(row[0]) for row in rows)
    lines = []
    for row in rows:
        first, *rest = row
        if len(row) == len(shown):
            rest = [f'{cell:>{width}}' for cell, width in zip(rest, widths[1:], strict=True)]
        lines.append('  '.join([f'{first:<{widths[0]}}', *rest]))
    return '\n'.join(lines)


def faults(outcome: Any) -> list[str]:
    """Return a line for each class of faults: how often it came, and what the first one said."""
    if isinstance(outcome, DeadReckoningError):
        return []
    return [
        f'{fault.count} × {name}: {fault.first}'
        for name, fault in outcome.faults.items()
        if fault.first.severity != 'none'
    ]


def _said(value: float | None, form: str, unit: str = '') -> str:
    return NONE if value is None else f'{value:{form}}{unit}'


def _jobs(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f'{text!r} is no number of processes')
    return int(text)
