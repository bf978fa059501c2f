"""A body that does not move."""

import numpy as np

from dead_reckoning.sources.motions.rest import Rest, RestSettings


def test_it_stays_where_it_was_put():
    truth = Rest(RestSettings(position=(1.0, 2.0, 3.0))).at(np.array([0.0, 1.0, 1e6]))
    np.testing.assert_array_equal(truth.position, [[1.0, 2.0, 3.0]] * 3)
    assert not truth.velocity.any()
    assert not truth.acceleration.any()
