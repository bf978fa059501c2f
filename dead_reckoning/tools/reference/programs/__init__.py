"""The programs of the command ``reference``, a module each, found by its name.

A module offers ``SUMMARY``, a line for the help; ``add_arguments(parser)``; and
``run(arguments)``, which returns the lines to print, all of them or an error.  An underscore in
its name is a hyphen in the command.
"""

import pkgutil
from argparse import ArgumentParser, Namespace
from importlib import import_module
from typing import Protocol, cast


class Program(Protocol):
    """What a module of this folder offers."""

    SUMMARY: str

    def add_arguments(self, parser: ArgumentParser) -> None:
        """Add what the program takes."""

    def run(self, arguments: Namespace) -> list[str]:
        """Return the lines to print, header first; raise `DeadReckoningError` otherwise."""


def programs() -> dict[str, Program]:
    """Return all programs by the names of their commands."""
    modules = sorted(module.name for module in pkgutil.iter_modules(__path__))
    return {
        name.replace('_', '-'): cast(Program, import_module(f'{__name__}.{name}'))
        for name in modules
    }
