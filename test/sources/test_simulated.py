"""The simulated sensor: exact truth, faults that can be switched, the same counts every time."""

import math

import numpy as np
import pytest

from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import matrix_from_quaternion, quaternion_from_euler
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.simulated import SimulatedAccelerometer, SimulatedSettings

RATE = 6400.0
START_NS = 1_700_000_000_000_000_000
IDEAL = {
    'noise': False,
    'quantise': False,
    'offset': (0.0, 0.0, 0.0),
    'sensitivity_error': (0.0, 0.0, 0.0),
}
UP = np.array([0.0, 0.0, GRAVITY])
MODEL = DriverSettings(range_g=2.0).model()


def sensor(motion='slide', rate=RATE, start_ns=START_NS, motion_settings=None, **settings):
    kind = motions.motion_class(motion)
    return SimulatedAccelerometer(
        SimulatedSettings(**settings),
        MODEL,
        kind(kind.Settings(**(motion_settings or {}))),
        rate,
        start_ns,
    )


def ideal(motion='slide', **settings):
    return sensor(motion, **(IDEAL | settings))


def force(counts):
    return MODEL.force(counts, np.array(MODEL.zero_g))


def test_every_effect_is_on_unless_switched_off():
    settings = SimulatedSettings()
    assert settings.noise
    assert settings.quantise
    assert all(settings.offset)
    assert all(settings.sensitivity_error)


def test_ideal_sensor_shows_the_exact_force():
    source = ideal()
    conversions = source.read(round(5.0 * RATE))
    kind = motions.motion_class('slide')
    time = np.arange(len(conversions.counts)) / RATE
    expected = kind(kind.Settings()).at(time).acceleration + UP
    np.testing.assert_allclose(force(conversions.counts), expected, atol=1e-9)
    assert np.ptp(expected[:, 0]) > 5.0, 'it does move'


def test_conversion_k_happens_k_periods_after_the_start():
    conversions = ideal(rate=1000.0).read(5)
    assert (conversions.stamps_ns - START_NS).tolist() == [k * 1_000_000 for k in range(5)]
    assert conversions.stamps_ns.dtype == np.int64
    assert conversions.counts.shape == (5, 3)


def test_stamps_do_not_drift():
    """At a period that is no whole number of nanoseconds."""
    source = ideal('rest', rate=3.0)
    source.read(300_000)
    assert source.read(1).stamps_ns[0] - START_NS == 100_000 * 10**9


@pytest.mark.parametrize('pieces', [[10_000], [1] * 50 + [9_950], [0, 63, 65, 9_872], [64] * 156])
def test_reading_in_pieces_gives_the_same_counts(pieces):
    source = sensor()
    parts = [source.read(count) for count in pieces]
    whole = sensor().read(sum(pieces))
    np.testing.assert_array_equal(np.concatenate([p.counts for p in parts]), whole.counts)
    np.testing.assert_array_equal(np.concatenate([p.stamps_ns for p in parts]), whole.stamps_ns)


def test_seed_decides_the_noise():
    first, again, other = (sensor(seed=seed).read(1000).counts for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_noise_is_as_large_as_set():
    counts = ideal('rest', noise=True).read(20_000).counts
    volts = counts * MODEL.volts_per_count
    assert volts.std(axis=0) == pytest.approx([MODEL.noise] * 3, rel=0.03)
    assert force(counts).mean(axis=0) == pytest.approx([0.0, 0.0, GRAVITY], abs=0.005)


def test_without_noise_rest_is_one_value():
    counts = ideal('rest', quantise=True).read(100).counts
    np.testing.assert_array_equal(counts, np.broadcast_to(counts[0], counts.shape))


def test_rounding_can_be_switched():
    fractions, whole = (ideal(quantise=on).read(30_000).counts for on in (False, True))
    assert (fractions != np.round(fractions)).any()
    np.testing.assert_array_equal(whole, np.floor(fractions + 0.5))


def test_offset_adds_to_the_force():
    counts = ideal('rest', offset=(0.3, -0.2, 0.4)).read(1).counts
    assert force(counts)[0] == pytest.approx([0.3, -0.2, GRAVITY + 0.4])


def test_error_of_the_sensitivity_scales_the_force():
    errors = (0.01, -0.02, 0.03)
    slides = {'axis': 'x'}
    scaled = force(ideal(motion_settings=slides, sensitivity_error=errors).read(30_000).counts)
    exact = force(ideal(motion_settings=slides).read(30_000).counts)
    np.testing.assert_allclose(scaled, exact * (1.0 + np.array(errors)), atol=1e-9)


def test_table_that_tilts_shows_in_the_force_and_turns_the_truth():
    euler = (0.1, -0.2, 0.7)
    source = ideal(attitude=euler)
    rot_wt = np.reshape(matrix_from_quaternion(quaternion_from_euler(*euler)), (3, 3))
    at_rest = force(source.read(1).counts)[0]
    assert at_rest == pytest.approx(rot_wt.T @ UP)
    end = source.truth(START_NS + 10 * 10**9)
    assert end.position == pytest.approx(rot_wt @ [0.5, 0.0, 0.0])
    middle = source.truth(START_NS + round(3.5e9))
    assert middle.velocity == pytest.approx(rot_wt @ [0.5 * 30.0 / 16.0, 0.0, 0.0])
    assert middle.attitude == pytest.approx(quaternion_from_euler(*euler))


def test_yaw_of_the_table_does_not_show_in_the_force():
    turned, straight = (
        ideal(attitude=(0.0, 0.0, yaw)).read(30_000).counts for yaw in (math.pi / 3, 0.0)
    )
    np.testing.assert_allclose(turned, straight, atol=1e-9)


def test_truth_rests_slides_and_rests():
    source = sensor()
    stationary = [
        source.truth(START_NS + round(seconds * 1e9)).stationary
        for seconds in (0.0, 2.9, 3.5, 4.0, 9.0)
    ]
    assert stationary == [True, True, False, True, True]
    assert source.truth(START_NS).position == (0.0, 0.0, 0.0)
    assert source.truth(START_NS + 9 * 10**9).position == (0.5, 0.0, 0.0)
    assert source.truth(START_NS + 5).stamp_ns == START_NS + 5


def test_integrating_the_conversions_gives_the_truth():
    """Twice the trapezoid over an ideal sensor ends where the truth does."""
    conversions = ideal().read(round(5.0 * RATE))
    acceleration = force(conversions.counts) - UP
    mean = 0.5 * (acceleration[1:] + acceleration[:-1])
    velocity = np.concatenate(([[0.0] * 3], np.cumsum(mean, axis=0) / RATE))
    position = (0.5 * (velocity[1:] + velocity[:-1])).sum(axis=0) / RATE
    assert velocity[-1] == pytest.approx([0.0] * 3, abs=1e-6)
    assert position == pytest.approx([0.5, 0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize(
    ('after_ns', 'count'),
    [(-(10**9), 0), (-1, 0), (0, 1), (156_249, 1), (156_250, 2), (10**9, 6401)],
)
def test_available_counts_the_conversions_that_have_happened(after_ns, count):
    assert sensor().available(START_NS + after_ns) == count


def test_what_was_read_is_no_longer_available():
    source = sensor()
    source.read(6400)
    assert source.available(START_NS + 10**9) == 1
    assert source.available(START_NS) == 0
