"""The truth of a motion on a table that stands somehow in the world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.rotation import quaternion_from_matrix
from dead_reckoning.core.samples import NANOSECONDS, NavigationState, Vector
from dead_reckoning.sources.motions import Motion

Array = NDArray[np.float64]


def true_states(
    motion: Motion, rot_wt: Array, stamps_ns: Sequence[int], start_ns: int
) -> list[NavigationState]:
    """Return where the body is at each stamp; ``rot_wt``, shape (3, 3), takes the table into w."""
    truth = motion.at((np.array(stamps_ns) - start_ns) / NANOSECONDS)
    turns = truth.angular_velocity
    moves: NDArray[np.bool_] = np.logical_or.reduce(np.hstack((truth.velocity, turns)), axis=1)
    return [
        NavigationState(
            stamp_ns,
            _vector(rot_wt @ position),
            _vector(rot_wt @ velocity),
            quaternion_from_matrix(tuple((rot_wt @ rot_tb).ravel().tolist())),
            angular_velocity=_vector(turn),
            stationary=not moving,
        )
        for stamp_ns, position, velocity, rot_tb, turn, moving in zip(
            stamps_ns, truth.position, truth.velocity, truth.rotation, turns, moves, strict=True
        )
    ]


def _vector(array: Array) -> Vector:
    x, y, z = array.tolist()
    return (x, y, z)
