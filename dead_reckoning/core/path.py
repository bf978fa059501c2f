"""Keep the way so far as poses, few enough to be drawn."""

from __future__ import annotations

from dataclasses import dataclass
from math import dist
from typing import TypeAlias

from dead_reckoning.core.samples import NANOSECONDS, NavigationState, Quaternion, Vector

MOST = 5000
"""Poses at most; then every second one goes."""

SPACING = 0.1
"""Way between two poses at first [m]."""

PERIOD_NS = NANOSECONDS
"""Time between two that are given, at least."""


Pose: TypeAlias = tuple[int, Vector, Quaternion]
"""Stamp [ns], position [m] and attitude, world frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """Poses along a way, at least one."""

    poses: tuple[Pose, ...]

    @property
    def stamp_ns(self) -> int:
        """Stamp of the last pose [ns]."""
        return self.poses[-1][0]


class PathKeeper:
    """Make a path of states: a pose where the body has come far enough from the last one."""

    def __init__(self) -> None:
        self._poses: list[Pose] = []
        self._spacing = SPACING
        self._last_ns = 0
        self._given_ns: int | None = None
        self._new = False

    def take(self, state: NavigationState) -> None:
        """Take the next state."""
        self._last_ns = state.stamp_ns
        poses = self._poses
        if not poses or dist(poses[-1][1], state.position) >= self._spacing:
            poses.append((state.stamp_ns, state.position, state.attitude))
            self._new = True
            if len(poses) > MOST:
                del poses[1::2]
                self._spacing *= 2.0

    def path(self) -> Path | None:
        """Return the path up to the last state, at most once a second, where it has grown."""
        given_ns = self._given_ns
        if not self._new or (given_ns is not None and self._last_ns - given_ns < PERIOD_NS):
            return None
        self._given_ns, self._new = self._last_ns, False
        return Path(tuple(self._poses))
