"""Strapdown against closed forms, and its errors against their linearization."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dead_reckoning.core.kernels.navigation.layout import ERRORS
from dead_reckoning.core.kernels.navigation.strapdown import (
    carry,
    carry_back,
    increments,
    integral,
    moved,
    spread,
)

GRAVITY = 9.81
UP = np.array([0.0, 0.0, GRAVITY])


def vectors(rows):
    return [tuple(row) for row in np.asarray(rows, float).tolist()]


def integrated(dt, force, rate, attitude=(0.0, 0.0, 0.0, 1.0), averaging=0.0):
    """Return position, velocity and attitude after samples ``dt`` apart, shapes (n, 3)."""
    force, rate = vectors(force), vectors(rate)
    position, velocity = np.zeros(3), (0.0, 0.0, 0.0)
    for k in range(1, len(force)):
        dt0, before = (dt, k - 2) if k > 1 else (0.0, 0)
        turn = integral(dt, dt0, rate[k], rate[k - 1], rate[before], averaging)
        push = integral(dt, dt0, force[k], force[k - 1], force[before], averaging)
        turn, push = increments(dt, turn, push, rate[k - 1], rate[k], force[k - 1], force[k])
        way, velocity, attitude, _ = moved(dt, GRAVITY, velocity, attitude, turn, push)
        position += way
    return position, np.array(velocity), Rotation.from_quat(attitude)


def test_constant_rate_turns_by_its_angle():
    rate = np.tile([0.3, -1.2, 2.0], (501, 1))
    _, _, found = integrated(0.01, np.zeros((501, 3)), rate)
    error = found * Rotation.from_rotvec(rate[0] * 5.0).inv()
    assert error.magnitude() < 1e-8  # a quaternion is left alone within 1e-9 of unit length


def test_free_fall_and_level_rest():
    position, velocity, _ = integrated(0.01, np.zeros((101, 3)), np.zeros((101, 3)))
    np.testing.assert_allclose(position, [0.0, 0.0, -0.5 * GRAVITY], atol=1e-12)
    np.testing.assert_allclose(velocity, [0.0, 0.0, -GRAVITY], atol=1e-12)
    rest = np.tile([0.0, 0.0, GRAVITY], (101, 1))
    position, velocity, _ = integrated(0.01, rest, np.zeros((101, 3)))
    assert not position.any()
    assert not velocity.any()


def test_parabola_is_integrated_exactly_and_an_uneven_step_by_a_line():
    def value(t):
        return tuple((1.0 - 2.0 * t + 3.0 * t * t) * np.array([1.0, -2.0, 0.5]))

    def area(t):
        return (t - t * t + t**3) * np.array([1.0, -2.0, 0.5])

    found = integral(0.3, 0.2, value(0.5), value(0.2), value(0.0), 0.0)
    np.testing.assert_allclose(found, area(0.5) - area(0.2), rtol=1e-12)
    found = integral(0.3, 0.01, value(0.5), value(0.2), value(0.19), 0.0)
    np.testing.assert_allclose(found, 0.15 * (np.array(value(0.2)) + value(0.5)), rtol=1e-12)


def coning(time, swing=0.4, turn=7.0):
    """Return the attitude of an axis that swings around a cone, and its rate [rad/s]."""

    def rotation(t):
        axes = np.column_stack([np.cos(turn * t), np.sin(turn * t), 0.0 * t])
        return Rotation.from_rotvec(swing * axes)

    h = 1e-5
    rate = (rotation(time - h).inv() * rotation(time + h)).as_rotvec() / (2.0 * h)
    return rotation(time), rate


@pytest.mark.parametrize('averaging', [0.0, 1.0])
@pytest.mark.parametrize('accelerated', [False, True])
def test_coning_and_sculling_are_integrated_to_third_order(accelerated, averaging):
    """Of values of an instant, and of means over the time between samples."""
    swings = np.array([3.0, -2.0, 5.0]) * accelerated
    inside = averaging * (np.arange(10) - 4.5) / 10.0
    errors = []
    for dt in (0.02, 0.01, 0.005):
        time = np.arange(round(2.0 / dt) + 1) * dt
        truth, _ = coning(time)
        force, rate = np.zeros((2, len(time), 3))
        for part in inside:
            within = time + part * dt
            rotation, turn = coning(within)
            acceleration_w = np.cos(within[:, None] * [5.0, 6.0, 7.0]) * swings
            force += 0.1 * rotation.inv().apply(acceleration_w + UP)
            rate += 0.1 * turn
        _, velocity, found = integrated(
            dt, force, rate, tuple(truth[0].as_quat()), averaging=averaging
        )
        expected = np.sin(2.0 * np.array([5.0, 6.0, 7.0])) / [5.0, 6.0, 7.0] * swings
        turned = (found * truth[-1].inv()).magnitude()
        errors.append((turned, np.linalg.norm(velocity - expected)))
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    assert (ratios > 5.0).all(), errors


def step(position, velocity, rotation, rate_bias, force_bias, dt=1e-3):
    """Return state and what `carry` takes, one sample later."""
    rate = np.array([[2.0, -5.0, 3.0], [2.3, -4.6, 3.1]]) - rate_bias
    force = np.array([[12.0, 4.0, -15.0], [12.5, 3.0, -14.0]]) - force_bias
    (w1, w2), (f1, f2) = vectors(rate), vectors(force)
    turn, push = integral(dt, 0.0, w2, w1, w1, 1.0), integral(dt, 0.0, f2, f1, f1, 1.0)
    turn, push = increments(dt, turn, push, w1, w2, f1, f2)
    attitude = tuple(rotation.as_quat().tolist())
    way, after, attitude, rot = moved(dt, GRAVITY, tuple(velocity), attitude, turn, push)
    return position + way, np.array(after), Rotation.from_quat(attitude), (rot, way, after)


POSITION, VELOCITY = np.array([3.0, -2.0, 1.0]), np.array([4.0, -1.0, 2.0])
ROTATION = Rotation.from_euler('xyz', [0.4, -0.9, 2.0])


def test_analytic_jacobian_is_the_numeric_one():
    dt, h = 1e-3, 1e-5
    zero = np.zeros(3)
    *expected, carried = step(POSITION, VELOCITY, ROTATION, zero, zero)
    analytic = np.eye(ERRORS)
    carry(analytic, dt, GRAVITY, *carried)
    numeric = np.eye(ERRORS)
    for j in range(15):
        ends = []
        for sign in (h, -h):
            e = np.zeros(15)
            e[j] = sign
            turn = Rotation.from_rotvec(e[6:9])
            position, velocity, rotation, _ = step(
                POSITION + e[:3],
                turn.apply(VELOCITY) + e[3:6],
                turn * ROTATION,
                e[9:12],
                e[12:15],
            )
            turned = rotation * expected[2].inv()
            xi = velocity - turned.apply(expected[1])
            ends.append(np.concatenate([position - expected[0], xi, turned.as_rotvec()]))
        numeric[:9, j] = (ends[0] - ends[1]) / (2.0 * h)
    difference = np.abs(analytic - numeric)
    # What is left are products of the step with rate, force and step; of the position, of third
    # order.
    assert difference[:3].max() < 10.0 * dt**3
    assert difference[3:9].max() < 40.0 * dt**2
    assert np.abs(analytic - np.eye(ERRORS)).max() > 100.0 * difference.max()


def test_heading_stays_unobservable():
    """A turn of the whole way about the vertical stays one, whatever is measured."""
    after, _, _, carried = step(POSITION, VELOCITY, ROTATION, np.zeros(3), np.zeros(3))
    up = np.array([0.0, 0.0, 1.0])
    turn = np.concatenate([np.cross(up, POSITION), np.zeros(3), up, np.zeros(7)])[:, None]
    carry(turn, 1e-3, GRAVITY, *carried)
    expected = np.concatenate([np.cross(up, after), np.zeros(3), up, np.zeros(7)])
    np.testing.assert_allclose(turn[:, 0], expected, atol=1e-15)


def test_going_back_is_the_transpose():
    carried = step(POSITION, VELOCITY, ROTATION, np.zeros(3), np.zeros(3))[3]
    forth, back = np.eye(ERRORS), np.eye(ERRORS)
    carry(forth, 0.01, GRAVITY, *carried)
    carry_back(back, 0.01, GRAVITY, *carried)
    np.testing.assert_allclose(back, forth.T, atol=1e-15)


def test_noise_of_the_rate_reaches_the_velocity_as_it_does():
    p = np.zeros((ERRORS, ERRORS))
    spread(p, tuple(VELOCITY), 0.5, 0.01)
    x, y, z = VELOCITY
    crossed = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    g = np.vstack([crossed, np.eye(3)])
    expected = 0.01 * g @ g.T
    expected[:3, :3] += 0.5 * np.eye(3)
    upper = np.triu_indices(6)
    np.testing.assert_allclose(p[3:9, 3:9][upper], expected[upper], atol=1e-15)
