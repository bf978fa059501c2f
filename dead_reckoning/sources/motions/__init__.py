"""Motions of the simulator with their exact truth: one module each, found by its name.

A module of this package offers ``MOTION``, a class that is built from its own settings (their
prefix is ``driver.`` and the name of the module) and gives `Kinematics` for any times.  A new
motion is one file.
"""

from __future__ import annotations

import pkgutil
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.parameters import Settings

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Kinematics:
    """The truth at n times, in the frame of the table the motion happens on.

    ``position`` [m], ``velocity`` [m/s], ``acceleration`` [m/s²], shapes (n, 3).  The body does
    not turn against the table.
    """

    position: Array
    velocity: Array
    acceleration: Array


class Motion(Protocol):
    """How a body moves, for ever: a motion that has ended rests."""

    Settings: ClassVar[type[Settings]]

    @property
    def duration(self) -> float:
        """Time [s] after which the body rests for good."""

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s] since the start."""


def names() -> tuple[str, ...]:
    """List the motions there are."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def motion_class(name: str) -> Any:
    """Return the class of a motion by its name."""
    return import_module(f'{__name__}.{name}').MOTION
