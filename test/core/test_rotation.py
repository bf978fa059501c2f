"""Closed forms, laws, and numpy as the judge."""

import math
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import NotFiniteError
from dead_reckoning.core.rotation import (
    composed,
    cross_covariance,
    euler_from_gravity,
    isotropic,
    matrix_from_quaternion,
    normalized,
    quaternion_from_euler,
    quaternion_from_turn,
    rotate,
    rotate_back,
    rotate_covariance,
    similarity,
    yaw_from_quaternion,
)
from dead_reckoning.core.samples import IDENTITY, IDENTITY_QUATERNION

GRAVITY = (0.0, 0.0, 9.80665)

angles = st.floats(-pi, pi)
vectors = st.tuples(*[st.floats(-100.0, 100.0)] * 3)
quaternions = st.builds(quaternion_from_euler, angles, angles, angles)
matrices = st.tuples(*[st.floats(-10.0, 10.0)] * 9)


@st.composite
def covariances(draw):
    root = array(draw(matrices))
    return tuple((root @ root.T).ravel().tolist())


def array(matrix):
    return np.reshape(matrix, (3, 3))


def cross(vector):
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


@pytest.mark.parametrize(
    ('euler', 'vector', 'turned'),
    [
        ((0.0, 0.0, 0.0), (1.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
        ((pi / 2, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        ((0.0, pi / 2, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)),
        ((0.0, 0.0, pi / 2), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((pi, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)),
        ((pi / 2, 0.0, pi / 2), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        ((pi / 2, 0.0, pi / 2), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, 0.0, pi / 6), (2.0, 0.0, 0.0), (2.0 * cos(pi / 6), 2.0 * sin(pi / 6), 0.0)),
    ],
)
def test_turns_of_known_angle(euler, vector, turned):
    rot_wb = matrix_from_quaternion(quaternion_from_euler(*euler))
    assert rotate(rot_wb, vector) == pytest.approx(turned, abs=1e-15)


@given(angles, angles, angles)
def test_euler_angles_turn_about_fixed_x_then_y_then_z(roll, pitch, yaw):
    about_x = [[1, 0, 0], [0, cos(roll), -sin(roll)], [0, sin(roll), cos(roll)]]
    about_y = [[cos(pitch), 0, sin(pitch)], [0, 1, 0], [-sin(pitch), 0, cos(pitch)]]
    about_z = [[cos(yaw), -sin(yaw), 0], [sin(yaw), cos(yaw), 0], [0, 0, 1]]
    expected = np.array(about_z) @ about_y @ about_x
    rot_wb = matrix_from_quaternion(quaternion_from_euler(roll, pitch, yaw))
    np.testing.assert_allclose(array(rot_wb), expected, atol=1e-14)


@given(quaternions)
def test_matrix_is_a_rotation(quaternion):
    rot_wb = array(matrix_from_quaternion(quaternion))
    np.testing.assert_allclose(rot_wb @ rot_wb.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(rot_wb) == pytest.approx(1.0)


@given(quaternions, vectors)
def test_rotating_back_undoes_rotating(quaternion, vector):
    rot_wb = matrix_from_quaternion(quaternion)
    assert rotate_back(rot_wb, rotate(rot_wb, vector)) == pytest.approx(vector, abs=1e-12)
    assert rotate(rot_wb, rotate_back(rot_wb, vector)) == pytest.approx(vector, abs=1e-12)


@given(st.floats(-pi + 1e-9, pi - 1e-9), st.floats(-1.57, 1.57))
def test_gravity_shows_roll_and_pitch(roll, pitch):
    rot_ws = matrix_from_quaternion(quaternion_from_euler(roll, pitch, 0.0))
    seen_roll, seen_pitch = euler_from_gravity(rotate_back(rot_ws, GRAVITY))
    assert seen_roll == pytest.approx(roll, abs=1e-9)
    assert seen_pitch == pytest.approx(pitch, abs=1e-9)


@given(angles, st.floats(-1.5, 1.5), st.floats(-3.14, 3.14))
def test_yaw_is_read_back(roll, pitch, yaw):
    assert yaw_from_quaternion(quaternion_from_euler(roll, pitch, yaw)) == pytest.approx(
        yaw, abs=1e-9
    )


@given(matrices, covariances())
def test_similarity_agrees_with_numpy(m, s):
    expected = array(m) @ array(s) @ array(m).T
    scale = 1.0 + np.abs(expected).max()
    np.testing.assert_allclose(array(similarity(m, s)), expected, atol=1e-11 * scale)


@given(quaternions, covariances())
def test_rotated_covariance_agrees_with_numpy(quaternion, covariance):
    rot_wb = matrix_from_quaternion(quaternion)
    expected = array(rot_wb) @ array(covariance) @ array(rot_wb).T
    np.testing.assert_allclose(
        array(rotate_covariance(rot_wb, covariance)), expected, atol=1e-12 * (1 + expected.max())
    )


@given(quaternions, st.floats(0.0, 10.0))
def test_rotated_sphere_agrees_with_numpy(quaternion, deviation):
    """The short cut for equal variances must not change the result."""
    rot_wb = matrix_from_quaternion(quaternion)
    sphere = isotropic(deviation)
    assert rotate_covariance(rot_wb, sphere) is sphere
    expected = array(rot_wb) @ array(sphere) @ array(rot_wb).T
    np.testing.assert_allclose(array(rotate_covariance(rot_wb, sphere)), expected, atol=1e-12)


@given(st.floats(0.1, 4.0), st.sampled_from([(1,), (2,), (5,), (1, 2, 5)]))
def test_equal_variances_with_correlation_are_no_sphere(correlation, places):
    covariance = [9.0, 0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 9.0]
    for place in places:
        covariance[place] = covariance[place % 3 * 3 + place // 3] = correlation
    rot_wb = matrix_from_quaternion(quaternion_from_euler(0.3, -0.5, 1.1))
    expected = array(rot_wb) @ array(covariance) @ array(rot_wb).T
    np.testing.assert_allclose(
        array(rotate_covariance(rot_wb, tuple(covariance))), expected, atol=1e-12
    )


@given(vectors, covariances())
def test_cross_covariance_agrees_with_numpy(vector, covariance):
    expected = cross(vector) @ array(covariance) @ cross(vector).T
    scale = 1.0 + np.abs(expected).max()
    np.testing.assert_allclose(
        array(cross_covariance(vector, covariance)), expected, atol=1e-11 * scale
    )


def test_tilt_does_not_show_along_the_force():
    """At rest one degree of tilt is 0.171 m/s² on the horizontal axes, and nothing on z."""
    x, _, _, _, y, _, _, _, z = cross_covariance(GRAVITY, isotropic(math.radians(1.0)))
    assert math.sqrt(x) == pytest.approx(0.171, abs=5e-4)
    assert math.sqrt(y) == pytest.approx(0.171, abs=5e-4)
    assert z == 0.0


def test_isotropic_squares_the_deviation():
    np.testing.assert_array_equal(array(isotropic(3.0)), 9.0 * np.eye(3))


def test_identity():
    assert matrix_from_quaternion(IDENTITY_QUATERNION) == IDENTITY


def test_quaternion_of_unit_length_stays_as_it_is():
    quaternion = quaternion_from_euler(0.1, 0.2, 0.3)
    assert normalized(quaternion) is quaternion


@given(quaternions, st.floats(0.01, 100.0))
def test_quaternion_of_other_length_means_the_same_rotation(quaternion, scale):
    longer = tuple(scale * part for part in quaternion)
    assert normalized(longer) == pytest.approx(quaternion, abs=1e-9)


@pytest.mark.parametrize(
    'quaternion',
    [
        (0.0, 0.0, 0.0, 0.0),
        (1e-4, 0.0, 0.0, 0.0),
        (math.nan, 0.0, 0.0, 1.0),
        (0.0, math.inf, 0.0, 1.0),
        (0.0, 0.0, 1e200, 1.0),
    ],
)
def test_what_is_no_rotation_is_refused(quaternion):
    with pytest.raises(NotFiniteError, match='no rotation'):
        normalized(quaternion)


@given(quaternions, quaternions, vectors)
def test_composed_turns_one_after_the_other(first, second, vector):
    both = matrix_from_quaternion(composed(second, first))
    inner = rotate(matrix_from_quaternion(first), vector)
    expected = rotate(matrix_from_quaternion(second), inner)
    assert rotate(both, vector) == pytest.approx(expected, abs=1e-9)


@given(st.tuples(*[st.floats(-4.0, 4.0)] * 3))
def test_turn_is_that_of_rodrigues(turn):
    angle = float(np.linalg.norm(turn))
    k = cross(np.divide(turn, angle)) if angle > 1e-12 else np.zeros((3, 3))
    expected = np.eye(3) + sin(angle) * k + (1.0 - cos(angle)) * k @ k
    rotation = array(matrix_from_quaternion(quaternion_from_turn(turn)))
    np.testing.assert_allclose(rotation, expected, atol=1e-12)


@pytest.mark.parametrize('angle', [0.0, 1e-9, 0.99e-4, 1.01e-4, 1e-3])
def test_small_turn_is_exact_to_rounding(angle):
    x, y, z, w = quaternion_from_turn((0.0, angle, 0.0))
    assert (x, z) == (0.0, 0.0)
    assert y == pytest.approx(sin(angle / 2.0), rel=1e-14, abs=0.0)
    assert w == pytest.approx(cos(angle / 2.0), rel=1e-15)
