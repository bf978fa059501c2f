"""A square returns to where it began, resting at each corner."""

import numpy as np
import pytest

from dead_reckoning.sources.motions.square import Square, SquareSettings


def test_corners_come_in_order_with_a_rest_at_each():
    body = Square(SquareSettings(side=0.4, side_duration=1.0, pause=0.5, start=2.0))
    arrived = 3.0 + 1.5 * np.arange(4)
    corners = np.array([[0.4, 0.0, 0.0], [0.4, 0.4, 0.0], [0.0, 0.4, 0.0], [0.0, 0.0, 0.0]])
    for share in (0.0, 0.5, 1.0):
        truth = body.at(arrived + share * 0.5)
        np.testing.assert_allclose(truth.position, corners, atol=1e-15)
        np.testing.assert_allclose(truth.velocity, 0.0, atol=1e-12)
    assert body.duration == 7.5


def test_each_side_is_straight():
    body = Square(SquareSettings())
    velocity = body.at(np.linspace(0.0, body.duration, 1000)).velocity
    assert (np.count_nonzero(velocity, axis=1) <= 1).all()


def test_without_a_pause_it_still_stops_at_each_corner():
    body = Square(SquareSettings(side=0.4, side_duration=1.0, pause=0.0, start=0.0))
    corners = body.at(np.arange(5.0))
    np.testing.assert_allclose(corners.velocity, 0.0, atol=1e-12)
    np.testing.assert_allclose(corners.position[2], [0.4, 0.4, 0.0])
    assert body.duration == pytest.approx(4.0)
