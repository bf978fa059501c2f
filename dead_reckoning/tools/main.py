"""The command line: `dead-reckoning COMMAND`."""

from __future__ import annotations

import argparse
import gc
import signal
import sys
from collections.abc import Sequence
from importlib import import_module

from dead_reckoning.tools.signals import unwinding

COMMANDS = {
    'calibrate': (
        'dead_reckoning.tools.calibrate.command',
        'fit the step lengths of a pedometer to recorded walks of known distances',
    ),
    'demo': (
        'dead_reckoning.tools.demo.command',
        'simulate a motion, run the nodes, compare with the truth',
    ),
    'emulate': (
        'dead_reckoning.tools.emulate.command',
        'be a board: speak its protocol on a pseudo-terminal, a simulated sensor behind it',
    ),
    'evaluate': (
        'dead_reckoning.tools.evaluate.command',
        'compare what replay wrote with the truth: poses, steps or a distance',
    ),
    'replay': (
        'dead_reckoning.tools.replay.command',
        'run the chain of a parameter file over recordings, faster than real time',
    ),
    'reference': (
        'dead_reckoning.tools.reference.command',
        "run a document's own program, exact to the bit, on counts from a CSV file",
    ),
    'warmup': (
        'dead_reckoning.tools.warmup',
        'compile what replays use, and keep it, so that the first one does not have to',
    ),
}
"""Commands by name: the module, which offers `add_arguments` and `main`, and what it is for."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status.

    0 done, 1 failed, 2 wrong usage or input, 130 interrupted, 143 ended by SIGTERM.
    """
    # Messages and rows are many, and none is part of a cycle: to look for cycles after each 700
    # of them takes a fifth of a replay.
    gc.set_threshold(50_000)
    try:
        with unwinding(signal.SIGTERM, signal.SIGHUP):
            return _run(arguments)
    except KeyboardInterrupt:
        print('\ninterrupted', file=sys.stderr)
        return 130


def _run(arguments: Sequence[str] | None) -> int:
    # Imported here, so that Ctrl-C during the imports is caught above.
    from dead_reckoning.core.errors import DeadReckoningError, InputError

    parser = argparse.ArgumentParser(
        prog='dead-reckoning', description='Where did the sensor go? Tools that need no ROS.'
    )
    commands = parser.add_subparsers(dest='command', required=True, metavar='COMMAND')
    arguments = sys.argv[1:] if arguments is None else arguments
    for name, (module, words) in COMMANDS.items():
        command = commands.add_parser(name, help=words, description=words)
        if name in arguments[:1]:  # the others need not be imported
            import_module(module).add_arguments(command)
    given = parser.parse_args(arguments)
    try:
        return int(import_module(COMMANDS[given.command][0]).main(given))
    except DeadReckoningError as error:
        print(f'\ndead-reckoning {given.command}: {error}', file=sys.stderr)
        return 2 if isinstance(error, InputError) else 1


if __name__ == '__main__':
    sys.exit(main())
