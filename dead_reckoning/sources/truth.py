"""The truth of a motion on a table that stands somehow in the world."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.rotation import quaternion_from_matrix
from dead_reckoning.core.samples import NANOSECONDS, NavigationState, Vector
from dead_reckoning.sources.motions import Motion

Array = NDArray[np.float64]


def true_state(motion: Motion, rot_wt: Array, stamp_ns: int, start_ns: int) -> NavigationState:
    """Return where the body is at a stamp; ``rot_wt``, shape (3, 3), takes the table into w."""
    truth = motion.at(np.array([(stamp_ns - start_ns) / NANOSECONDS]))
    rot_wb = rot_wt @ truth.rotation[0]
    turn = truth.angular_velocity[0]
    return NavigationState(
        stamp_ns,
        _vector(rot_wt @ truth.position[0]),
        _vector(rot_wt @ truth.velocity[0]),
        quaternion_from_matrix(tuple(rot_wb.ravel().tolist())),
        angular_velocity=_vector(turn),
        stationary=not truth.velocity.any() and not turn.any(),
    )


def _vector(array: Array) -> Vector:
    x, y, z = array.tolist()
    return (x, y, z)
