"""The Jacobians of the linear acceleration against differences of the acceleration itself."""

import numpy as np
import pytest

from dead_reckoning.core.acceleration_error import (
    cross_matrix,
    write_jacobian,
    write_jacobian_along,
)
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import matrix_from_quaternion, quaternion_from_euler

ATTITUDES = [(0.0, 0.0, 0.0), (0.3, -0.2, 1.0), (-1.2, 0.9, -2.5)]
STEP = 1e-6


def rotation_of(vector):
    """Return the rotation by a vector of angles, shape (3, 3) (Rodrigues)."""
    angle = np.linalg.norm(vector)
    if angle == 0.0:
        return np.eye(3)
    k = cross_matrix(vector / angle)
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


def measured(rotation, force_s, mask, tilt, offset):
    """Return what an attitude wrong by ``tilt`` and an offset make of a force, shape (3,)."""
    wrong = rotation_of(tilt) @ rotation
    accel_s = force_s + offset - wrong.T @ [0.0, 0.0, GRAVITY]
    return wrong @ mask @ accel_s


def differences(function, size=3):
    columns = [
        (function(STEP * axis) - function(-STEP * axis)) / (2.0 * STEP) for axis in np.eye(size)
    ]
    return np.transpose(columns)


@pytest.mark.parametrize('euler', ATTITUDES, ids=str)
@pytest.mark.parametrize('axes', [(1, 1, 1), (1, 1, 0), (0, 1, 0), (1, 0, 1)], ids=str)
def test_free_body(euler, axes):
    rot_ws = matrix_from_quaternion(quaternion_from_euler(*euler))
    rotation, mask = np.reshape(rot_ws, (3, 3)), np.diag(np.array(axes, dtype=float))
    force_w = np.array([1.5, -2.0, 0.7 + GRAVITY])
    force_s = rotation.T @ force_w
    expected = np.hstack(
        [
            differences(lambda tilt: measured(rotation, force_s, mask, tilt, np.zeros(3))),
            differences(lambda offset: measured(rotation, force_s, mask, np.zeros(3), offset)),
        ]
    )
    jacobian = np.empty((3, 6))
    write_jacobian(jacobian, rot_ws, tuple(force_w), None if all(axes) else mask)
    np.testing.assert_allclose(jacobian, expected, atol=1e-8)


@pytest.mark.parametrize('euler', ATTITUDES, ids=str)
@pytest.mark.parametrize('axis', [0, 1, 2])
def test_along_an_axis(euler, axis):
    rot_ws = matrix_from_quaternion(quaternion_from_euler(*euler))
    rotation = np.reshape(rot_ws, (3, 3))
    force_s = rotation.T @ [1.5, -2.0, 0.7 + GRAVITY]

    def along(tilt, offset):
        wrong = rotation_of(tilt) @ rotation
        return (force_s + offset - wrong.T @ [0.0, 0.0, GRAVITY])[axis : axis + 1]

    expected = np.hstack(
        [
            differences(lambda tilt: along(tilt, np.zeros(3))),
            differences(lambda offset: along(np.zeros(3), offset)),
        ]
    )
    jacobian = np.empty((1, 6))
    write_jacobian_along(jacobian, rot_ws, axis)
    np.testing.assert_allclose(jacobian, expected, atol=1e-8)


def test_cross_matrix_is_the_cross_product():
    a, b = np.array([1.0, -2.0, 3.0]), np.array([0.5, 4.0, -1.0])
    np.testing.assert_allclose(cross_matrix(a) @ b, np.cross(a, b))
