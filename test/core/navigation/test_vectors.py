"""Velocities, positions and poses from elsewhere: what they measure, when they are refused."""

import numpy as np
import pytest
from moving_state import STATE, jacobian, measurements, placed
from scipy.spatial.transform import Rotation
from simulated_walks import filtered

from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.kernels.navigation.measurement import normalized_square
from dead_reckoning.core.navigation.aids import aid_row
from dead_reckoning.core.samples import UNMEASURED_VARIANCE

ARM = np.array([0.4, -1.3, 0.6])
ROOT = np.array([[0.3, 0.0, 0.0], [0.1, 0.2, 0.0], [-0.05, 0.15, 0.4]])
COVARIANCE = ROOT @ ROOT.T
HALF = COVARIANCE[np.triu_indices(3)]
ROW_OF_STATE = np.array([[0.0, 1.0, 0.0]])


def vector(what, value, half=HALF, arm=ARM, interval=0.1, age=0.0):
    values = (what, layout.BY_TWIST, interval, *value, *half, *arm)
    return np.array([aid_row(0, layout.VECTOR, values, round(age * 1e9))])


def pose(position, half, attitude, of_attitude, arm=ARM):
    values = (*position, *half, *attitude, *of_attitude, *arm)
    return np.array([aid_row(0, layout.PLACE, values, 0)])


def at_point(what):
    """Return what is measured of a point, by velocity, attitude and bias of the gyro."""

    def value(velocity, rotation, bias):
        swing = np.cross(STATE['rate'] - bias, ARM)
        if what == layout.BODY_VELOCITY:
            return rotation.inv().apply(velocity) + swing
        if what == layout.WORLD_VELOCITY:
            return velocity + rotation.apply(swing)
        return rotation.apply(ARM)

    return value


@pytest.mark.parametrize(
    'what', [layout.BODY_VELOCITY, layout.WORLD_VELOCITY, layout.WORLD_POSITION]
)
def test_what_a_vector_measures(what):
    rules, state, row = placed(aiding_gate=1e9, averaging=0.0)
    seen = np.array([0.3, -0.2, 0.5])
    x, found = measurements(rules, state, row, vector(what, seen))
    value = at_point(what)
    expected = jacobian(value, x)
    predicted = value(x[3:6], Rotation.from_quat(x[13:17]), x[6:9])
    if what == layout.WORLD_POSITION:
        expected[:, :3] += np.eye(3)
        predicted = predicted + x[:3]
    h = np.array([h for h, _ in found])
    np.testing.assert_allclose(ROOT @ h, expected, atol=1e-7)
    assert found[0][1] == pytest.approx((seen - predicted)[0] / ROOT[0, 0])


def test_a_vector_is_taken_as_one_measurement_of_its_covariance():
    rules, state, row = placed(aiding_gate=1e9)
    before = filtered(rules, state.copy(), row, ROW_OF_STATE)[1][0]
    p, x = before[33 : 33 + 256].reshape(16, 16), before[16:33]
    h = jacobian(at_point(layout.WORLD_VELOCITY), x)
    gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + COVARIANCE)
    aids = vector(layout.WORLD_VELOCITY, (2.9, -0.8, 0.6))
    after = filtered(rules, state.copy(), row, ROW_OF_STATE, aids)[1][0]
    expected = p - gain @ h @ p
    np.testing.assert_allclose(after[33 : 33 + 256].reshape(16, 16), expected, atol=1e-12)
    y = (2.9, -0.8, 0.6) - at_point(layout.WORLD_VELOCITY)(
        x[3:6], Rotation.from_quat(x[13:17]), x[6:9]
    )
    np.testing.assert_allclose(after[16:19] - x[:3], (gain @ y)[:3], rtol=1e-6)


def test_a_position_is_where_the_point_was_when_it_was_measured():
    rules, state, row = placed(aiding_gate=1e9)
    late = measurements(rules, state.copy(), row, vector(layout.WORLD_POSITION, ARM, age=0.02))
    prompt = measurements(rules, state.copy(), row, vector(layout.WORLD_POSITION, ARM))
    x = prompt[0]
    moved = 0.02 * at_point(layout.WORLD_VELOCITY)(x[3:6], Rotation.from_quat(x[13:17]), x[6:9])
    assert late[1][0][1] - prompt[1][0][1] == pytest.approx(moved[0] / ROOT[0, 0])


def test_what_is_not_measured_along_an_axis_changes_nothing_there():
    rules, state, row = placed(aiding_gate=1e9)
    half = (0.01, 0.0, 0.0, UNMEASURED_VARIANCE, 0.0, UNMEASURED_VARIANCE)
    ends = []
    for y in (0.0, 500.0):
        aids = vector(layout.BODY_VELOCITY, (1.0, y, -y), half)
        ends.append(filtered(rules, state.copy(), row, ROW_OF_STATE, aids)[0][0, :10])
    np.testing.assert_allclose(*ends, atol=1e-6)


def test_the_gate_is_on_the_nis_of_three_dimensions():
    rules, state, row = placed()
    trace = filtered(rules, state.copy(), row, ROW_OF_STATE)[1][0]
    p, x = trace[33 : 33 + 256].reshape(16, 16), trace[16:33]
    h = jacobian(at_point(layout.BODY_VELOCITY), x)
    spread = h @ p @ h.T + COVARIANCE
    predicted = at_point(layout.BODY_VELOCITY)(x[3:6], Rotation.from_quat(x[13:17]), x[6:9])
    direction = np.array([0.6, -0.5, 0.9])
    unit = direction / np.sqrt(direction @ np.linalg.solve(spread, direction))
    counts = layout.COUNTS + layout.AIDED + 2 * layout.BY_TWIST
    for size, taken in ((0.999, True), (1.001, False)):
        there = state.copy()
        seen = predicted + size * np.sqrt(rules[layout.AIDING_GATE]) * unit
        filtered(rules, there, row, ROW_OF_STATE, vector(layout.BODY_VELOCITY, seen))
        assert there[counts : counts + 2].tolist() == [float(taken), float(not taken)]


@pytest.mark.parametrize('ratio', [1.0, 1e6, 1e9, 1e12])
def test_the_nis_keeps_its_digits_however_much_worse_an_axis_is_known(ratio):
    """With S = I + r n nᵀ it is |y|² less r (n y)²/(1 + r), but for the rounding of S itself."""
    random = np.random.default_rng(1)
    for _ in range(50):
        n, y = random.normal(size=(2, 3))
        n /= np.linalg.norm(n)
        s = np.eye(3) + ratio * np.outer(n, n)
        across = y - (n @ y) * n
        expected = across @ across + (n @ y) ** 2 / (1.0 + ratio)
        found = normalized_square(tuple(s[np.triu_indices(3)]), tuple(y))
        assert found == pytest.approx(expected, rel=1e-12 + 1e-15 * ratio)


def test_what_stays_refused_is_believed_in_the_end():
    rules, state, row = placed(aiding_patience=0.35)
    rest = row.copy()
    rest[0, 0] = 1e-6  # nothing moves meanwhile
    begin = layout.COUNTS + layout.AIDED + 2 * layout.BY_TWIST
    small = np.diag([1e-4] * 3)[np.triu_indices(3)]
    for _ in range(5):
        aids = vector(layout.WORLD_VELOCITY, (9.0, 9.0, 9.0), small, np.zeros(3))
        filtered(rules, state, rest, ROW_OF_STATE, aids)
    assert state[begin : begin + 2].tolist() == [1.0, 4.0]
    np.testing.assert_allclose(state[3:6], 9.0, atol=0.05)


def test_a_pose_is_set_and_the_velocity_turns_along():
    rules, state, row = placed()
    rest = row.copy()
    rest[0, 0] = 0.0
    turn = Rotation.from_euler('xyz', [0.1, 0.2, -2.5])
    half, of_attitude = (0.04, 0.01, 0.0, 0.09, 0.0, 0.16), (1e-4, 0.0, 0.0, 4e-4, 0.0, 9e-4)
    before = Rotation.from_quat(state[13:17]).inv().apply(state[3:6])
    filtered(
        rules, state, rest, ROW_OF_STATE, pose((5.0, 6.0, 7.0), half, turn.as_quat(), of_attitude)
    )
    rotation = Rotation.from_quat(state[13:17])
    assert (rotation * turn.inv()).magnitude() == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(state[:3], np.array((5.0, 6.0, 7.0)) + turn.apply(ARM))
    np.testing.assert_allclose(rotation.inv().apply(state[3:6]), before, atol=1e-9)
    p = state[layout.COVARIANCE : layout.COVARIANCE + 256].reshape(16, 16)
    np.testing.assert_allclose(p[6:9, 6:9][np.triu_indices(3)], of_attitude, rtol=1e-6, atol=1e-9)
    np.testing.assert_array_equal(p, p.T)
    # It is the point at −ARM from the sensor: p_s = p + R ARM, δp_s = δp + θ × R ARM.
    x, y, z = turn.apply(ARM)
    h = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    told = np.zeros((3, 3))
    told[np.triu_indices(3)] = half
    told += np.triu(told, 1).T
    np.testing.assert_allclose(p[:3, 6:9], h @ p[6:9, 6:9], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(p[:3, :3], told + h @ p[6:9, 6:9] @ h.T, rtol=1e-5)
    assert not p[:3, 3:6].any()
    assert not p[:3, 9:].any()
    assert not p[6:9, 9:].any()


def test_a_pose_in_a_plane_leaves_height_and_tilt():
    rules, state, row = placed()
    rest = row.copy()
    rest[0, 0] = 0.0
    huge = UNMEASURED_VARIANCE
    state[layout.X_POSITION + 2] = 1.5
    euler = Rotation.from_quat(state[13:17]).as_euler('xyz')
    aids = pose(
        (5.0, 6.0, 0.0), (0.04, 0.0, 0.0, 0.04, 0.0, huge), (0.0, 0.0, 0.0, 1.0),
        (huge, 0.0, 0.0, huge, 0.0, 0.01), np.zeros(3),
    )  # fmt: skip
    p = state[layout.COVARIANCE : layout.COVARIANCE + 256].reshape(16, 16)
    tilt, height = p[6, 6] + p[7, 7], p[2, 2]
    filtered(rules, state, rest, ROW_OF_STATE, aids)
    np.testing.assert_allclose(state[:3], (5.0, 6.0, 1.5))
    expected = (euler[0], euler[1], 0.0)
    np.testing.assert_allclose(
        Rotation.from_quat(state[13:17]).as_euler('xyz'), expected, atol=1e-9
    )
    assert p[6, 6] + p[7, 7] == pytest.approx(tilt)
    assert p[2, 2] == pytest.approx(height)
    assert p[8, 8] == pytest.approx(0.01)
