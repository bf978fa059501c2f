"""The command line: `dead-reckoning COMMAND`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from dead_reckoning.core.errors import DeadReckoningError
from dead_reckoning.tools.demo import command as demo
from dead_reckoning.tools.processes import InterruptedRunError

COMMANDS = {
    'demo': (demo, 'simulate a motion, run the nodes, compare with the truth'),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status: 0 done, 1 failed, 2 wrong usage, 130 interrupted."""
    parser = argparse.ArgumentParser(prog='dead-reckoning', description=__doc__)
    commands = parser.add_subparsers(dest='command', required=True, metavar='COMMAND')
    for name, (module, words) in COMMANDS.items():
        module.add_arguments(commands.add_parser(name, help=words, description=words))
    given = parser.parse_args(arguments)
    try:
        return COMMANDS[given.command][0].main(given)
    except (KeyboardInterrupt, InterruptedRunError):
        print('\ninterrupted', file=sys.stderr)
        return 130
    except DeadReckoningError as error:
        print(f'\ndead-reckoning {given.command}: {error}', file=sys.stderr)
        return 1


if __name__ == '__main__':
    sys.exit(main())
