"""The command `demo`: run the cases, print the tables, write pictures and the page."""

from __future__ import annotations

import argparse
import os
import select
import sys
import time
from collections.abc import Mapping
from pathlib import Path

from dead_reckoning.core.errors import RecordingError, SettingsError
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import GROUND_TRUTH, ODOMETRY
from dead_reckoning.tools.demo.cases import CASES, Case
from dead_reckoning.tools.demo.recording import Recording, parse
from dead_reckoning.tools.processes import Interruption, Nodes, environment, interruptible
from dead_reckoning.tools.table import table

START_DEADLINE = 30.0
"""How long [s] the nodes may take to find each other."""

SILENCE = 10.0
"""How long [s] nothing may come once samples flow."""

MARGIN = 0.3
"""How long [s] before the motion the estimate has to be there."""

ENDS = 'ends'
"""How a line begins with which the recorder says who is there."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what the command takes."""
    parser.add_argument(
        'case',
        nargs='*',
        metavar='CASE',
        help='what to show; all if none is named: ' + ', '.join(case.name for case in CASES),
    )
    parser.add_argument(
        '--output', type=Path, default=Path('out/demo'), help='folder for pictures and page'
    )


def main(arguments: argparse.Namespace) -> int:
    """Run the demo; return the exit status."""
    from dead_reckoning.tools.demo.page import Result, write

    arguments.output.mkdir(parents=True, exist_ok=True)
    results = []
    for case in _chosen(arguments.case):
        recording = run(case)
        rows = case.view.rows(recording)
        said = table(('', 'truth', 'estimate', 'error'), [row.cells for row in rows])
        print(f'\n{case.title}\n{said}\n', flush=True)
        pictures = case.view.draw(case.name, recording, arguments.output)
        results.append(Result(case, recording, rows, pictures))
    page = arguments.output / 'index.html'
    write(page, results)
    for result in results:
        for picture in result.pictures:
            print(f'picture  {picture}')
    print(f'page     {page}')
    return 0


def _chosen(names: list[str]) -> list[Case]:
    by_name = {case.name: case for case in CASES}
    for name in names:
        if name not in by_name:
            raise SettingsError(f'no case {name!r}; there are {", ".join(by_name)}')
    return [by_name[name] for name in names] or list(CASES)


def run(case: Case) -> Recording:
    """Run one case over DDS and return what was recorded.

    Raises `NodeEndedError`, `RecordingError` if samples are missing, or `KeyboardInterrupt`.
    """
    surroundings = environment()
    domain = surroundings['ROS_DOMAIN_ID']
    setup = case.setup
    count = len(setup.nodes) + 1
    print(f'{case.title}: starting {count} nodes on ROS_DOMAIN_ID {domain}', flush=True)
    with interruptible() as interruption, Nodes(surroundings) as nodes:
        output = nodes.start('recorder', {}, read=True)
        for name in setup.nodes:
            nodes.start(name, case.all_parameters)
        lines = Lines(output.fileno(), nodes, interruption)
        lines.wait_for(setup.ends)
        nodes.start(setup.source, case.all_parameters)
        recording = parse(_collect(case, lines), case.view.topics)
    if ODOMETRY in case.view.topics:
        begin = recording.track(ODOMETRY).time[0]
        if begin > case.start - MARGIN:
            raise RecordingError(
                f'the estimate begins {begin:.1f} s after the start, too close to the motion: the '
                'machine is too busy, run the demo again'
            )
    return recording


class Lines:
    """The lines that the recorder writes, as they come."""

    def __init__(self, descriptor: int, nodes: Nodes, interruption: Interruption) -> None:
        self._descriptor = descriptor
        self._nodes = nodes
        self._interruption = interruption
        self._rest = b''

    def wait_for(self, ends: Mapping[str, int]) -> None:
        """Return once topics have that many publishers and subscribers together.

        Raises `RecordingError` if they do not get them.
        """
        missing = dict(ends)
        deadline = time.monotonic() + START_DEADLINE
        while missing:
            if time.monotonic() > deadline:
                raise RecordingError(
                    f'the nodes did not find each other in {START_DEADLINE:g} s: too few '
                    f'publishers and subscribers of {", ".join(missing)}'
                )
            for line in self.read():
                word, *rest = line.split()
                if word == ENDS and int(rest[1]) >= missing.get(rest[0], int(rest[1]) + 1):
                    del missing[rest[0]]

    def read(self) -> list[str]:
        """Return the lines that came, none after a short while without.

        Raises `NodeEndedError` if a node has ended, `KeyboardInterrupt` if a signal came.
        """
        self._interruption.check()
        self._nodes.check()
        if not select.select([self._descriptor], [], [], 0.1)[0]:
            return []
        read = self._rest + os.read(self._descriptor, 1 << 16)
        *whole, self._rest = read.split(b'\n')
        return [line.decode() for line in whole]


def _collect(case: Case, lines: Lines) -> list[str]:
    """Read lines until the truth has reached the end of the case."""
    collected: list[str] = []
    first_ns: int | None = None
    reached = 0.0
    deadline = time.monotonic() + START_DEADLINE
    progress = Progress()
    while reached < case.duration:
        if time.monotonic() > deadline:
            raise RecordingError(f'no samples came for {SILENCE:g} s')
        for line in lines.read():
            topic, stamp_ns, _ = line.split(maxsplit=2)
            if topic == ENDS:
                continue
            collected.append(line)
            if topic == GROUND_TRUTH:
                first_ns = int(stamp_ns) if first_ns is None else first_ns
                reached = (int(stamp_ns) - first_ns) / NANOSECONDS
                deadline = time.monotonic() + SILENCE
        progress.show(reached / case.duration)
    return collected


class Progress:
    """A bar on a terminal, redrawn when it has something new to show; elsewhere one word."""

    WIDTH = 40

    def __init__(self) -> None:
        self._shown = -1

    def show(self, part: float) -> None:
        """Show that ``part``, 0 to 1, is done."""
        percent = int(100 * min(part, 1.0))
        if percent == self._shown:
            return
        self._shown = percent
        if sys.stdout.isatty():
            filled = self.WIDTH * percent // 100
            bar = '█' * filled + '·' * (self.WIDTH - filled)
            print(f'\r  {bar} {percent:3}%', end='\n' if percent == 100 else '', flush=True)
        elif percent == 100:
            print('  recorded', flush=True)
