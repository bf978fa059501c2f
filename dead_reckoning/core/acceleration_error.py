"""How an error of the attitude and an offset show in the linear acceleration.

An attitude error θ, shape (3,) [rad] about the axes of the world, an error γ [m/s²] of the
magnitude of gravity, and an offset b, shape (3,) [m/s²] along the axes of the sensor, add
``J · (θ, γ, b)`` to it, J of shape (…, 7).  Derived in docs/integrator.md, "Covariance".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.checks import LARGEST_VARIANCE
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import variance_along
from dead_reckoning.core.samples import LinearAcceleration, Matrix, Vector

Array = NDArray[np.float64]


def write_jacobian(out: Array, rot_ws: Matrix, force_w: Vector, mask: Array | None = None) -> None:
    """Write J of a body that moves freely into ``out``, shape (3, 7).

    ``force_w`` is the specific force, shape (3,) [m/s²], world.  ``mask``, shape (3, 3), is
    diagonal: 1 for the axes of the sensor along which it moves at all.
    """
    x, y, z = force_w
    a, b, c, d, e, f, g, h, i = rot_ws
    out[:] = ((0.0, z, -y, 0.0, a, b, c), (-z, 0.0, x, 0.0, d, e, f), (y, -x, 0.0, -1.0, g, h, i))
    if mask is not None:
        rotation = np.reshape(rot_ws, (3, 3))
        moves = rotation @ mask @ rotation.T
        out[:, :3] = cross_matrix((0.0, 0.0, -GRAVITY))
        out[:] = moves @ out
        out[:, :3] -= cross_matrix(moves @ (x, y, z - GRAVITY))


def write_jacobian_along(out: Array, rot_ws: Matrix, axis: int) -> None:
    """Write J of the acceleration along one axis of the sensor, 0 to 2, into ``out``, (1, 7).

    The sensor measures along that axis wherever it points; the attitude only says how much of it
    is gravity.
    """
    x, y, z = rot_ws[axis::3]
    out[0, :] = (-GRAVITY * y, GRAVITY * x, 0.0, -z, 0.0, 0.0, 0.0)
    out[0, 4 + axis] = 1.0


def gravity_variance(
    acceleration: LinearAcceleration, rot_ws: Matrix, attitude: Matrix, noise: Matrix
) -> float:
    """Return the variance of γ [m²/s⁴]: what noise and attitude leave of that of the vertical.

    ``attitude`` and ``noise`` are the covariances of attitude [rad²], world, and specific force
    [m²/s⁴], sensor, shapes (3, 3), of the same moment.
    """
    x, y, _ = acceleration.acceleration
    explained = variance_along(rot_ws[6:], noise) + variance_along((-y, x, 0.0), attitude)
    return min(max(0.0, acceleration.covariance[8] - explained), LARGEST_VARIANCE)


def cross_matrix(vector: Vector | Array) -> Array:
    """Return ``[v]×``, shape (3, 3): the matrix of v × …."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
