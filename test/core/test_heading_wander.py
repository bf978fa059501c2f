"""The changing part of a heading error against closed forms and a Monte Carlo."""

import math

import numpy as np
import pytest

from dead_reckoning.core.heading_wander import HeadingWander
from dead_reckoning.core.rotation import matrix_from_quaternion, quaternion_from_euler
from dead_reckoning.core.samples import UNKNOWN

DEVIATION = 0.05


def drive(wander, yaws, speed=1.0, dt=0.1):
    """Drive along the headings; return covariances of position and velocity, shape (3, 3)."""
    for yaw in yaws:
        velocity = (speed * math.cos(yaw), speed * math.sin(yaw), 0.0)
        rot_ws = matrix_from_quaternion(quaternion_from_euler(0.0, 0.0, float(yaw)))
        wander.step(dt, rot_ws, velocity)
    return [np.reshape(c, (3, 3)) for c in wander.added(UNKNOWN, UNKNOWN, velocity)]


def test_straight_on_from_the_start_there_is_none():
    for covariance in drive(HeadingWander(DEVIATION, 0), np.full(100, 0.7)):
        np.testing.assert_array_equal(covariance, np.zeros((3, 3)))


def test_after_a_turn_it_is_the_deviation_times_distance_across():
    wander = HeadingWander(DEVIATION, 0)
    drive(wander, [0.0])
    position, velocity = drive(wander, np.full(100, 3.0))
    kept = math.exp(-3.0)
    across = np.array([-math.sin(3.0), math.cos(3.0), 0.0])
    variance = DEVIATION**2 * (1.0 - kept**2)
    np.testing.assert_allclose(position, 100.0 * variance * np.outer(across, across))
    np.testing.assert_allclose(velocity, variance * np.outer(across, across))


def test_noise_of_the_heading_is_no_turn():
    random = np.random.default_rng(1)
    position, _ = drive(HeadingWander(DEVIATION, 0), 0.7 + random.normal(0.0, 0.02, 1000))
    np.testing.assert_array_equal(position, np.zeros((3, 3)))


def test_round_and_round_it_agrees_with_drawn_errors():
    """A circle of 10 m round: each draw errs by its own d, correlated over 1 rad."""
    yaws = np.linspace(0.0, 4.0 * math.pi, 400)
    position, _ = drive(HeadingWander(DEVIATION, 0), yaws)
    random = np.random.default_rng(2)
    ends = []
    for _ in range(2000):
        anchor, d, end = yaws[0], 0.0, np.zeros(2)
        for yaw in yaws:
            if yaw - anchor > 0.2:
                kept = math.exp(anchor - yaw)
                d = kept * d + math.sqrt(1.0 - kept**2) * random.normal(0.0, DEVIATION)
                anchor = yaw
            end += 0.1 * d * np.array([-math.sin(yaw), math.cos(yaw)])
        ends.append(end)
    np.testing.assert_allclose(np.cov(np.transpose(ends)), position[:2, :2], atol=0.06)
    assert np.trace(position) > 0.1


@pytest.mark.parametrize('axis', [0, 1])
def test_turning_about_the_axis_itself_is_no_other_heading(axis):
    wander = HeadingWander(DEVIATION, axis)
    for angle in np.linspace(0.0, 3.0, 50).tolist():
        turns = [0.0, 0.0, 0.0]
        turns[axis] = angle
        rot_ws = matrix_from_quaternion(quaternion_from_euler(*turns))
        wander.step(0.1, rot_ws, (1.0, 0.0, 0.0))
    np.testing.assert_array_equal(wander.added(UNKNOWN, UNKNOWN, (1.0, 0.0, 0.0))[0], UNKNOWN)


def test_reset_forgets_all():
    wander = HeadingWander(DEVIATION, 0)
    drive(wander, np.linspace(0.0, 3.0, 50))
    wander.reset()
    assert not np.any(drive(wander, np.full(10, 0.0)))
