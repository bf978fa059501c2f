"""The command `reference`: choose a document's program, run it, print what it gives."""

from __future__ import annotations

import argparse
import os
import sys

from dead_reckoning.tools.reference.programs import programs


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add a command per program."""
    commands = parser.add_subparsers(dest='program', required=True, metavar='PROGRAM')
    for name, program in programs().items():
        command = commands.add_parser(name, help=program.SUMMARY, description=program.SUMMARY)
        program.add_arguments(command)


def main(arguments: argparse.Namespace) -> int:
    """Run the program and print all lines, or none if it raises; return the exit status."""
    lines = programs()[arguments.program].run(arguments)
    try:
        print('\n'.join(lines), flush=True)
    except BrokenPipeError:
        # Whoever reads has seen enough, as `head` does; the interpreter must not write again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return 0
