"""How an error of the attitude and an offset show in the linear acceleration.

An attitude error θ, shape (3,) [rad] about the axes of the world, and an offset b, shape (3,)
[m/s²] along the axes of the sensor, add ``J · (θ, b)`` to it, J of shape (…, 6).  Derived in
docs/integrator.md, "Covariance".
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import Matrix, Vector

Array = NDArray[np.float64]


def write_jacobian(out: Array, rot_ws: Matrix, force_w: Vector, mask: Array | None = None) -> None:
    """Write J of a body that moves freely into ``out``, shape (3, 6).

    ``force_w`` is the specific force, shape (3,) [m/s²], world.  ``mask``, shape (3, 3), is
    diagonal: 1 for the axes of the sensor along which it moves at all.
    """
    x, y, z = force_w
    a, b, c, d, e, f, g, h, i = rot_ws
    out[:] = ((0.0, z, -y, a, b, c), (-z, 0.0, x, d, e, f), (y, -x, 0.0, g, h, i))
    if mask is not None:
        rotation = np.reshape(rot_ws, (3, 3))
        moves = rotation @ mask @ rotation.T
        out[:, :3] = cross_matrix((0.0, 0.0, -GRAVITY))
        out[:] = moves @ out
        out[:, :3] -= cross_matrix(moves @ (x, y, z - GRAVITY))


def write_jacobian_along(out: Array, rot_ws: Matrix, axis: int) -> None:
    """Write J of the acceleration along one axis of the sensor, 0 to 2, into ``out``, (1, 6).

    The sensor measures along that axis wherever it points; the attitude only says how much of it
    is gravity.
    """
    out[0, :] = (-GRAVITY * rot_ws[3 + axis], GRAVITY * rot_ws[axis], 0.0, 0.0, 0.0, 0.0)
    out[0, 3 + axis] = 1.0


def cross_matrix(vector: Vector | Array) -> Array:
    """Return ``[v]×``, shape (3, 3): the matrix of v × …."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
