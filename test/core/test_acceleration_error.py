"""The Jacobians of the linear acceleration against differences of the acceleration itself."""

import numpy as np
import pytest

from dead_reckoning.core.acceleration_error import (
    cross_matrix,
    gravity_variance,
    write_jacobian,
    write_jacobian_along,
)
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import matrix_from_quaternion, quaternion_from_euler
from dead_reckoning.core.samples import LinearAcceleration

ATTITUDES = [(0.0, 0.0, 0.0), (0.3, -0.2, 1.0), (-1.2, 0.9, -2.5)]
STEP = 1e-6


def rotation_of(vector):
    """Return the rotation by a vector of angles, shape (3, 3) (Rodrigues)."""
    angle = np.linalg.norm(vector)
    if angle == 0.0:
        return np.eye(3)
    k = cross_matrix(vector / angle)
    return np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k


def measured(rotation, force_s, mask, errors):
    """Return what errors of attitude, gravity and offset, shape (7,), make of a force."""
    tilt, heavier, offset = np.split(errors, [3, 4])
    wrong = rotation_of(tilt) @ rotation
    accel_s = force_s + offset - wrong.T @ [0.0, 0.0, GRAVITY + heavier[0]]
    return wrong @ mask @ accel_s


def differences(function, size=7):
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
    expected = differences(lambda errors: measured(rotation, force_s, mask, errors))
    jacobian = np.empty((3, 7))
    write_jacobian(jacobian, rot_ws, tuple(force_w), None if all(axes) else mask)
    np.testing.assert_allclose(jacobian, expected, atol=1e-8)


@pytest.mark.parametrize('euler', ATTITUDES, ids=str)
@pytest.mark.parametrize('axis', [0, 1, 2])
def test_along_an_axis(euler, axis):
    rot_ws = matrix_from_quaternion(quaternion_from_euler(*euler))
    rotation = np.reshape(rot_ws, (3, 3))
    force_s = rotation.T @ [1.5, -2.0, 0.7 + GRAVITY]

    def along(errors):
        tilt, heavier, offset = np.split(errors, [3, 4])
        wrong = rotation_of(tilt) @ rotation
        accel_s = force_s + offset - wrong.T @ [0.0, 0.0, GRAVITY + heavier[0]]
        return accel_s[axis : axis + 1]

    expected = differences(along)
    jacobian = np.empty((1, 7))
    write_jacobian_along(jacobian, rot_ws, axis)
    np.testing.assert_allclose(jacobian, expected, atol=1e-8)


def test_what_noise_and_attitude_leave_is_gravity():
    random = np.random.default_rng(1)
    noise, tilt = (root @ root.T for root in random.normal(0.0, 0.1, (2, 3, 3)))
    rot_ws = matrix_from_quaternion(quaternion_from_euler(0.3, -0.2, 1.0))
    rotation, accel_w = np.reshape(rot_ws, (3, 3)), np.array([1.5, -2.0, 0.7])
    spread = cross_matrix(np.add(accel_w, [0.0, 0.0, GRAVITY]))
    explained = rotation @ noise @ rotation.T + spread @ tilt @ spread.T
    for variance in (0.0, 0.0004):
        covariance = explained + np.diag([0.0, 0.0, variance])
        acceleration = LinearAcceleration(1, 'odom', tuple(accel_w), tuple(covariance.ravel()))
        given = tuple(tilt.ravel()), tuple(noise.ravel())
        assert gravity_variance(acceleration, rot_ws, *given) == pytest.approx(variance, abs=1e-15)
    unknown = LinearAcceleration(1, 'odom', tuple(accel_w))
    assert gravity_variance(unknown, rot_ws, *given) == 0.0


def test_cross_matrix_is_the_cross_product():
    a, b = np.array([1.0, -2.0, 3.0]), np.array([0.5, 4.0, -1.0])
    np.testing.assert_allclose(cross_matrix(a) @ b, np.cross(a, b))
