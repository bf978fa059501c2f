"""The MMA7260QT behind an ADC, against its data sheet."""

import numpy as np
import pytest

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.sensors.mma7260qt import PART

RANGES = (1.5, 2.0, 4.0, 6.0)
BITS = (8, 10, 12, 16)
TABLE = [(range_g, bits) for range_g in RANGES for bits in BITS]


def sensor(range_g=1.5, bits=12, supply=3.3, reference=3.3, **kwargs):
    scale = PART.scale(supply)
    settings = {
        'range_g': range_g,
        'zero_g': (PART.zero_g * scale,) * 3,
        'sensitivity': (PART.ranges[range_g] * scale,) * 3,
        'zero_g_tolerance': PART.zero_g_tolerance * scale,
        'swing': (PART.swing_margin, supply - PART.swing_margin),
        'noise': PART.noise,
        'unit_per_count': reference / (1 << bits),
        'limits': (0.0, (1 << bits) - 1.0),
    }
    return Accelerometer(**(settings | kwargs))


@pytest.mark.parametrize(('bits', 'mg'), [(8, 16.1), (10, 4.03), (12, 1.01), (16, 0.063)])
def test_size_of_a_count(bits, mg):
    counted = sensor(1.5, bits).force_per_count / GRAVITY * 1000.0
    assert counted == pytest.approx([mg] * 3, rel=5e-3)


@pytest.mark.parametrize(('range_g', 'share'), [(2.0, 0.8 / 0.6), (4.0, 0.8 / 0.3), (6.0, 4.0)])
def test_count_grows_with_the_range(range_g, share):
    ratio = sensor(range_g).force_per_count / sensor(1.5).force_per_count
    assert ratio == pytest.approx([share] * 3)


@pytest.mark.parametrize(
    ('range_g', 'limit'), [(1.5, 1.75), (2.0, 7.0 / 3.0), (4.0, 14.0 / 3.0), (6.0, 7.0)]
)
@pytest.mark.parametrize('sign', [-1.0, 1.0])
def test_swing_clips_outside_the_nominal_range(range_g, limit, sign):
    model = sensor(range_g, 16)
    inside, outside = (
        model.counts(model.output(np.full((1, 3), sign * share * limit * GRAVITY)))
        for share in (0.999, 1.5)
    )
    assert not model.clipped(inside).any()
    assert model.clipped(outside).all()
    force = model.force(outside, np.array(model.zero_g))
    assert force / GRAVITY == pytest.approx(np.full((1, 3), sign * limit), abs=1e-3)


@pytest.mark.parametrize(('range_g', 'bits'), TABLE)
def test_round_trip_stays_within_half_a_count(range_g, bits):
    model = sensor(range_g, bits)
    random = np.random.default_rng(bits)
    force = random.uniform(-range_g, range_g, (1000, 3)) * GRAVITY
    counts = model.counts(model.output(force))
    error = np.abs(model.force(counts, np.array(model.zero_g)) - force)
    assert (error <= 0.5 * model.force_per_count * (1.0 + 1e-9)).all()
    assert error.max() > 0.4 * model.force_per_count.max(), 'it does round'
    assert (counts == np.round(counts)).all()


@pytest.mark.parametrize(('range_g', 'bits'), TABLE)
def test_round_trip_without_rounding_is_exact(range_g, bits):
    model = sensor(range_g, bits)
    force = np.linspace(-range_g, range_g, 30).reshape(10, 3) * GRAVITY
    counts = model.counts(model.output(force), quantise=False)
    np.testing.assert_allclose(model.force(counts, np.array(model.zero_g)), force, atol=1e-10)


def test_zero_g_is_half_the_supply():
    model = sensor()
    assert model.output(np.zeros((1, 3))) == pytest.approx(np.full((1, 3), 1.65))
    assert model.counts(np.full((1, 3), 1.65)) == pytest.approx(np.full((1, 3), 2048.0))


def test_outputs_are_ratiometric_to_the_supply():
    """At 2.2 V of supply and of reference the counts are those at 3.3 V of both."""
    force = np.linspace(-1.0, 1.0, 30).reshape(10, 3) * GRAVITY
    low, nominal = sensor(supply=2.2, reference=2.2), sensor()
    assert low.sensitivity == pytest.approx([0.8 * 2.0 / 3.0] * 3)
    assert low.zero_g_tolerance == pytest.approx(0.11)
    np.testing.assert_array_equal(
        low.counts(low.output(force)), nominal.counts(nominal.output(force))
    )


def test_axes_have_their_own_offset_and_sensitivity():
    model = sensor(zero_g=(1.6, 1.65, 1.7), sensitivity=(0.7, 0.8, 0.9))
    volts = model.output(np.full((1, 3), GRAVITY))
    np.testing.assert_allclose(volts, [[2.3, 2.45, 2.6]])
    np.testing.assert_allclose(
        model.force(volts / model.unit_per_count, np.array(model.zero_g)),
        np.full((1, 3), GRAVITY),
    )


@pytest.mark.parametrize('quantise', [True, False])
@pytest.mark.parametrize('reference', [2.5, 3.3])
def test_clipping_is_flagged_on_its_axis_only(reference, quantise):
    """With a reference of 2.5 V the ADC ends before the swing does."""
    model = sensor(reference=reference)
    volts = np.array([[0.2, 1.65, 1.65], [1.65, 5.0, 1.65], [1.65, 1.65, 1.65], [1.0, 1.0, 2.4]])
    flagged = model.clipped(model.counts(volts, quantise=quantise))
    expected = [[True, False, False], [False, True, False], [False] * 3, [False] * 3]
    np.testing.assert_array_equal(flagged, expected)


def test_counts_stay_within_the_adc():
    model = sensor(swing=(-10.0, 10.0), bits=8)
    counts = model.counts(np.array([[-5.0, 1.65, 5.0]]))
    np.testing.assert_array_equal(counts, [[0.0, 128.0, 255.0]])


@pytest.mark.parametrize(('bits', 'noise'), [(12, 0.0047), (8, 0.0047), (8, 0.02)])
def test_variance_is_that_of_noise_and_rounding(bits, noise):
    model = sensor(bits=bits, noise=noise)
    random = np.random.default_rng(3)
    force = random.uniform(-1.0, 1.0, (100_000, 3)) * GRAVITY
    volts = model.output(force) + noise * random.standard_normal(force.shape)
    error = model.force(model.counts(volts), np.array(model.zero_g)) - force
    assert error.var(axis=0) == pytest.approx(model.variance(1), rel=0.03)


def test_averaging_takes_off_noise_but_not_rounding():
    model = sensor(bits=8)
    rounding = model.force_per_count**2 / 12.0
    assert model.variance(64) - rounding == pytest.approx((model.variance(1) - rounding) / 64.0)
