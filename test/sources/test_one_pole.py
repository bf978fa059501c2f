"""A low-pass of one pole, against the solution of its differential equation."""

import numpy as np
import pytest

from dead_reckoning.sources.one_pole import OnePole

RATE = 6400.0
CORNER = (350.0, 350.0, 150.0)


def columns(values):
    return np.repeat(np.asarray(values, dtype=float)[:, None], 3, axis=1)


def test_step_approaches_with_its_time_constant():
    """A step that takes one period and then holds."""
    period = 1.0 / RATE
    after = OnePole(CORNER, RATE).filter(columns([0.0] + [1.0] * 200))[1:]
    for axis, corner in enumerate(CORNER):
        omega = 2.0 * np.pi * corner
        time = period * np.arange(1, 201)
        # The integral of the response to a sharp step over the period of the rise.
        expected = 1.0 - np.exp(-omega * time) * np.expm1(omega * period) / (omega * period)
        np.testing.assert_allclose(after[:, axis], expected, rtol=1e-12)


@pytest.mark.parametrize('rate', [30.0, 100.0, 6400.0])
def test_ramp_lags_by_the_time_constant_at_any_rate(rate):
    ramp = columns(np.arange(400) / rate)
    late = ramp - OnePole(CORNER, rate).filter(ramp)
    np.testing.assert_allclose(late[-1], 1.0 / (2.0 * np.pi * np.array(CORNER)), rtol=1e-6)


@pytest.mark.parametrize('share', [0.1, 1.0, 3.0])
def test_sine_is_weakened_and_late_as_one_pole_has_it(share):
    rate, corner = 100_000.0, 350.0
    omega = 2.0 * np.pi * corner * share
    time = np.arange(40_000) / rate
    filtered = OnePole((corner,) * 3, rate).filter(columns(np.sin(omega * time)))[:, 0]
    settled = slice(20_000, None)
    basis = np.column_stack([np.sin(omega * time), np.cos(omega * time)])[settled]
    (a, b), *_ = np.linalg.lstsq(basis, filtered[settled], rcond=None)
    response = 1.0 / (1.0 + 1j * share)
    assert a + 1j * b == pytest.approx(response, abs=2e-3)
    if share == 1.0:
        assert np.hypot(a, b) == pytest.approx(np.sqrt(0.5), rel=1e-3)


def test_it_starts_settled_and_keeps_what_does_not_change():
    steady = columns([0.1] * 50)
    np.testing.assert_array_equal(OnePole(CORNER, RATE).filter(steady), steady)


def test_corner_of_zero_lets_everything_pass():
    noise = np.random.default_rng(1).standard_normal((500, 3))
    filtered = OnePole((0.0, 350.0, 0.0), RATE).filter(noise)
    np.testing.assert_array_equal(filtered[:, [0, 2]], noise[:, [0, 2]])
    assert filtered[:, 1].std() < 0.7
    np.testing.assert_array_equal(OnePole((0.0,) * 3, RATE).filter(noise), noise)


@pytest.mark.parametrize('cuts', [[1, 2, 3], [0, 64, 64, 128, 999], list(range(1000))])
def test_cutting_the_samples_changes_nothing(cuts):
    noise = np.random.default_rng(2).standard_normal((1000, 3))
    pole = OnePole(CORNER, RATE)
    parts = [pole.filter(noise[a:b]) for a, b in zip([0, *cuts], [*cuts, 1000], strict=True)]
    np.testing.assert_array_equal(np.concatenate(parts), OnePole(CORNER, RATE).filter(noise))
