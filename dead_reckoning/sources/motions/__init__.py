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
    """The truth at n times, in the frame t of the table the motion happens on.

    ``position`` [m], ``velocity`` [m/s], ``acceleration`` [m/s²], shapes (n, 3), frame t.
    ``euler`` and ``euler_rate``, shapes (n, 3) [rad], [rad/s]: roll, pitch, yaw of the body
    against the table, and how they change.
    """

    position: Array
    velocity: Array
    acceleration: Array
    euler: Array
    euler_rate: Array

    @property
    def rotation(self) -> Array:
        """Return ``rot_tb`` at each time, shape (n, 3, 3)."""
        roll, pitch, yaw = self.euler.T
        cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (np.cos, np.sin))
        matrices: Array = np.stack(
            [
                cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,
                sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,
                -sp, cp * sr, cp * cr,
            ],
            axis=1,
        ).reshape(-1, 3, 3)  # fmt: skip
        return matrices

    @property
    def angular_velocity(self) -> Array:
        """Return the rate of turn, shape (n, 3) [rad/s], frame of the body."""
        roll, pitch, _ = self.euler.T
        roll_rate, pitch_rate, yaw_rate = self.euler_rate.T
        return np.stack(
            [
                roll_rate - yaw_rate * np.sin(pitch),
                pitch_rate * np.cos(roll) + yaw_rate * np.cos(pitch) * np.sin(roll),
                -pitch_rate * np.sin(roll) + yaw_rate * np.cos(pitch) * np.cos(roll),
            ],
            axis=1,
        )


def kinematics(
    position: Array,
    velocity: Array,
    acceleration: Array,
    euler: Array | None = None,
    euler_rate: Array | None = None,
) -> Kinematics:
    """Return the truth of a motion that turns as given, or not at all."""
    nothing = np.zeros_like(position)
    return Kinematics(
        position,
        velocity,
        acceleration,
        nothing if euler is None else euler,
        nothing if euler_rate is None else euler_rate,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """The steps of a walk: when the foot lands, shape (m,) [s], and how long each is [m]."""

    times: Array
    lengths: Array


NO_STEPS = Steps(np.empty(0), np.empty(0))


class Motion(Protocol):
    """How a body moves, for ever: a motion that has ended rests."""

    Settings: ClassVar[type[Settings]]

    @property
    def duration(self) -> float:
        """Time [s] after which the body rests for good."""

    @property
    def steps(self) -> Steps:
        """The steps in it, `NO_STEPS` where nobody walks."""

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s] since the start."""


def names() -> tuple[str, ...]:
    """List the motions there are."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def motion_class(name: str) -> Any:
    """Return the class of a motion by its name."""
    return import_module(f'{__name__}.{name}').MOTION
