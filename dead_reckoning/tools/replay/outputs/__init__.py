"""What ``replay`` writes, a module each, found by its name: `Output` says what is in one."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, TypeAlias, cast

from dead_reckoning.tools.replay.task import Task

Takers: TypeAlias = Mapping[str, Callable[[Any], object]]
"""What an output does with what goes into the chain and comes out of it, by name."""

BLOCK_END = 'end of block'
"""Name under which every output may learn that all of a block has come."""

SMOOTHED_STATES = 'smoothed states (the smoother of inertial_navigator)'
"""What an output may need besides topics."""


class Output(Protocol):
    """What a module of this folder offers."""

    FILES: tuple[str, ...]
    """Files or folders it writes; those of an earlier replay are replaced."""

    NEEDS: str
    """Name without which there is nothing to write; empty for none."""

    def write(self, folder: Path, task: Task) -> AbstractContextManager[Takers]:
        """Write into a folder while the context lasts; leaving it completes the files."""


def outputs() -> dict[str, Output]:
    """Return all outputs by their names."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    return {name: cast(Output, import_module(f'{__name__}.{name}')) for name in names}
