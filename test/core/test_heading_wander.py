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


def test_after_a_turn_it_is_the_change_times_distance_across():
    """Turned by 3 rad, (cos ψ, sin ψ) has moved by 2 sin 1.5."""
    wander = HeadingWander(DEVIATION, 0)
    drive(wander, [0.0])
    position, velocity = drive(wander, np.full(100, 3.0))
    across = np.array([-math.sin(3.0), math.cos(3.0), 0.0])
    variance = (DEVIATION * 2.0 * math.sin(1.5)) ** 2
    np.testing.assert_allclose(position, 100.0 * variance * np.outer(across, across), atol=1e-12)
    np.testing.assert_allclose(velocity, variance * np.outer(across, across), atol=1e-12)


def test_noise_of_the_heading_is_hardly_a_turn():
    random = np.random.default_rng(1)
    position, _ = drive(HeadingWander(DEVIATION, 0), 0.7 + random.normal(0.0, 0.02, 1000))
    assert np.sqrt(position.max()) < DEVIATION * 0.05 * 100.0


def test_it_agrees_with_iron_on_a_figure_of_eight():
    """Each draw has iron of its own along the axes of the body, which bends all headings."""
    u = np.linspace(0.0, 4.0 * math.pi, 1000)
    yaws = np.unwrap(np.arctan2(2.0 * np.cos(2.0 * u), 2.0 * np.cos(u)))
    position, _ = drive(HeadingWander(DEVIATION, 0), yaws)
    random = np.random.default_rng(2)
    ends = []
    for x, y in random.normal(0.0, DEVIATION, (2000, 2)):
        bent = np.sin(yaws) * y + np.cos(yaws) * x
        across = 0.1 * np.array([-np.sin(yaws), np.cos(yaws)])
        ends.append(across @ (bent - bent[0]))
    np.testing.assert_allclose(np.cov(np.transpose(ends)), position[:2, :2], rtol=0.1, atol=0.1)
    assert np.trace(position) > 10.0


def test_every_round_of_a_circle_adds_as_much():
    """A round of length L leaves πd·L/2π across, and the start's part cancels."""
    wander = HeadingWander(DEVIATION, 0)
    for rounds in (1, 2, 3):
        position, _ = drive(wander, np.arange(0.0, 2.0 * math.pi, math.pi / 50.0))
        deviations = np.sqrt(np.diag(position))
        np.testing.assert_allclose(deviations[:2], DEVIATION * 5.0 * rounds, rtol=1e-9)


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
