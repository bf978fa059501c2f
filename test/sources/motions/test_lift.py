"""A lift goes up or down, at its speed and no faster."""

import numpy as np
import pytest

from dead_reckoning.sources.motions.lift import Lift, LiftSettings


@pytest.mark.parametrize(('height', 'top'), [(3.0, 1.0), (-3.0, 1.0), (0.6, 0.5), (0.0, 0.0)])
def test_it_ends_at_its_height_at_its_speed_or_below(height, top):
    body = Lift(LiftSettings(height=height, speed=1.0, ramp=1.2, start=2.0))
    truth = body.at(np.linspace(0.0, body.duration + 1.0, 5001))
    np.testing.assert_array_equal(truth.position[-1], [0.0, 0.0, height])
    assert not truth.position[:, :2].any()
    assert np.abs(truth.velocity[:, 2]).max() == pytest.approx(top)


def test_it_pushes_no_harder_than_a_lift_for_people():
    """Lifts for people keep to about 1.5 m/s²."""
    body = Lift(LiftSettings())
    acceleration = body.at(np.linspace(0.0, body.duration, 5001)).acceleration[:, 2]
    assert 1.0 < acceleration.max() < 1.6
