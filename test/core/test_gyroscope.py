"""A gyroscope rounds, ends at its range, and says so."""

import numpy as np
import pytest

from dead_reckoning.core.gyroscope import Gyroscope

GYRO = Gyroscope(range=5.0, noise=0.01, resolution=0.001)


def test_reading_is_rounded_to_whole_counts():
    rate = np.random.default_rng(1).uniform(-4.0, 4.0, (1000, 3))
    reading = GYRO.reading(rate)
    np.testing.assert_allclose(reading / 0.001, np.round(reading / 0.001), atol=1e-9)
    assert 0.0004 < np.abs(reading - rate).max() <= 0.0005 + 1e-12


def test_without_a_resolution_nothing_is_rounded():
    rate = np.array([[0.12345678, -1e-9, 0.0]])
    fine = Gyroscope(range=5.0, noise=0.0, resolution=0.0)
    np.testing.assert_array_equal(fine.reading(rate), rate)


@pytest.mark.parametrize('resolution', [0.0, 0.001, 0.3])
def test_reading_ends_at_the_range_and_shows_it(resolution):
    gyro = Gyroscope(range=5.0, noise=0.01, resolution=resolution)
    reading = gyro.reading(np.array([[6.0, -7.0, 4.5]]))
    np.testing.assert_allclose(reading, [[5.0, -5.0, 4.5]], atol=0.5 * resolution)
    np.testing.assert_array_equal(gyro.saturated(reading), [[True, True, False]])


def test_variance_is_that_of_noise_and_rounding():
    random = np.random.default_rng(2)
    for noise in (0.0, 0.01):
        gyro = Gyroscope(range=5.0, noise=noise, resolution=0.02)
        rate = random.uniform(-4.0, 4.0, (100_000, 3))
        error = gyro.reading(rate + noise * random.standard_normal(rate.shape)) - rate
        assert error.var(axis=0) == pytest.approx([gyro.variance(1)] * 3, rel=0.03)
    assert gyro.variance(64) == pytest.approx(0.01**2 / 64 + 0.02**2 / 12)
