"""The simulated sensor: exact truth, faults that can be switched, the same counts every time."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import matrix_from_quaternion, quaternion_from_euler
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.motions import NO_STEPS, kinematics
from dead_reckoning.sources.simulated import SimulatedAccelerometer, SimulatedSettings

RATE = 6400.0
START_NS = 1_700_000_000_000_000_000
UP = np.array([0.0, 0.0, GRAVITY])
DRIVER = DriverSettings(range_g=2.0)
MODEL = DRIVER.model()


def sensor(
    motion='slide',
    rate=RATE,
    start_ns=START_NS,
    motion_settings=None,
    driver=DRIVER,
    settings=None,
    **changes,
):
    """Return a sensor on a motion given by name, or as an object that has `at`."""
    if isinstance(motion, str):
        kind = motions.motion_class(motion)
        motion = kind(kind.Settings(**(motion_settings or {})))
    settings = dataclasses.replace(settings or SimulatedSettings(), **changes)
    return SimulatedAccelerometer(settings, driver.part, driver.model(), motion, rate, start_ns)


def ideal(motion='slide', **changes):
    return sensor(motion, settings=SimulatedSettings.ideal(), **changes)


def pushed(push):
    """Return a motion with the acceleration ``push(time)``, one number along each axis."""

    def at(time):
        acceleration = np.column_stack([push(time)] * 3)
        return kinematics(acceleration * 0.0, acceleration * 0.0, acceleration)

    return SimpleNamespace(at=at, duration=1.0, steps=NO_STEPS)


def wave(time):
    """An acceleration that goes through all of the range within 0.2 s."""
    return 0.9 * GRAVITY * np.sin(2.0 * np.pi * time / 0.2)


def force(counts, model=MODEL):
    return model.force(counts, np.array(model.zero_g))


def seen(source, count=1280, model=MODEL):
    return force(source.read(count).counts, model)


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


EVERYTHING = {
    'supply_error': 0.05,
    'temperature': 40.0,
    'warming': 20.0,
    'warming_time': 0.5,
    'sleep_until': 0.3,
    'nonlinearity': 0.01,
    'axis_delay': 0.0001,
    'attitude': (0.1, -0.2, 0.7),
}


@pytest.mark.parametrize('pieces', [[10_000], [1] * 50 + [9_950], [0, 63, 65, 9_872], [64] * 156])
@pytest.mark.parametrize('motion', ['slide', 'gait'])
def test_reading_in_pieces_gives_the_same_counts_with_all_effects(motion, pieces):
    walking = {'motion_settings': {'start': 0.2}}
    source = sensor(motion, **walking, **EVERYTHING)
    parts = [source.read(count) for count in pieces]
    whole = sensor(motion, **walking, **EVERYTHING).read(sum(pieces))
    assert len(np.unique(whole.counts)) > 100
    np.testing.assert_array_equal(np.concatenate([p.counts for p in parts]), whole.counts)
    np.testing.assert_array_equal(np.concatenate([p.stamps_ns for p in parts]), whole.stamps_ns)


def test_seed_decides_the_noise():
    first, again, other = (sensor(seed=seed).read(1000).counts for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_noise_is_as_large_as_set():
    counts = ideal('rest', noise=True).read(20_000).counts
    volts = counts * MODEL.unit_per_count
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


def test_cross_axis_shows_parts_of_the_other_axes():
    parts = (0.01, 0.02, 0.03, 0.04, 0.05, 0.06)
    slides = {'motion_settings': {'axis': 'y', 'start': 0.0}}
    mixed, exact = (
        seen(ideal(**slides, **change), 6400) for change in ({'cross_axis': parts}, {})
    )
    mixing = np.array([[1.0, 0.01, 0.02], [0.03, 1.0, 0.04], [0.05, 0.06, 1.0]])
    np.testing.assert_allclose(mixed, exact @ mixing.T, atol=1e-9)


@pytest.mark.parametrize('bend', [0.01, -0.01])
def test_nonlinearity_bends_most_at_full_scale(bend):
    exact, bent = (
        seen(ideal(pushed(lambda t: t * 100.0), nonlinearity=part), 600)[:, 0]
        for part in (0.0, bend)
    )
    full = MODEL.range_g * GRAVITY
    np.testing.assert_allclose(bent - exact, bend * full * (exact / full) ** 2, atol=1e-9)


@pytest.mark.parametrize('bend', [0.2, -0.2])
def test_characteristic_rises_everywhere(bend):
    """Up to four times the range, where a polynomial would fall again."""
    driver = DriverSettings(range_g=1.5, adc_reference=10.0)
    rising = pushed(lambda t: (t - 0.01) * 300.0)
    shown = seen(ideal(rising, driver=driver, nonlinearity=bend), model=driver.model())[:, 0]
    assert (np.diff(shown) > 0.0).all()


@pytest.mark.parametrize('error', [0.1, -0.05])
def test_wrong_supply_scales_the_output_of_a_ratiometric_sensor(error):
    right, wrong = (
        ideal(pushed(wave), supply_error=part).read(1280).counts for part in (0.0, error)
    )
    np.testing.assert_allclose(wrong, right * (1.0 + error), rtol=1e-12)
    rest = ideal('rest', supply_error=error).read(1).counts
    shown = force(rest)[0]
    assert shown[0] == pytest.approx(error * 1.65 / 0.6 * GRAVITY), 'it looks like an offset'


def test_wrong_supply_does_nothing_to_a_digital_sensor():
    driver = DriverSettings(sensor='adxl345')
    right, wrong = (
        ideal(pushed(wave), driver=driver, supply_error=part).read(1280).counts
        for part in (0.0, 0.1)
    )
    np.testing.assert_array_equal(right, wrong)


def test_swing_ends_with_the_supply():
    """At 10 % less supply the upper end is at 2.97 − 0.25 V; the lower one stays."""
    hard = pushed(lambda t: np.where(t < 0.1, 5.0, -5.0) * GRAVITY)
    counts = ideal(hard, clip=True, supply_error=-0.1).read(1280).counts
    volts = counts * MODEL.unit_per_count
    assert volts[:, :2].max() == pytest.approx(2.72)
    assert volts[:, :2].min() == pytest.approx(0.25)


@pytest.mark.parametrize(
    ('driver', 'low', 'high'),
    [
        (DriverSettings(range_g=1.5), -1.75, 1.75),
        (DriverSettings(range_g=6.0), -7.0, 7.0),
        (DriverSettings(sensor='adxl330'), -14.0 / 3.0, 14.0 / 3.0),
        (DriverSettings(sensor='adxl345', range_g=4.0), -4.0, 4.0 - 1.0 / 256.0),
        (DriverSettings(sensor='adxl345', range_g=16.0), -16.0, 16.0 - 1.0 / 256.0),
    ],
)
def test_output_is_clipped_where_the_sensor_ends(driver, low, high):
    hard = pushed(lambda t: np.where(t < 0.1, 20.0, -20.0) * GRAVITY)
    shown = seen(ideal(hard, driver=driver, clip=True), model=driver.model())[:, :2] / GRAVITY
    np.testing.assert_allclose(shown[:640], high)
    np.testing.assert_allclose(shown[640:], low)


def test_clipping_can_be_switched_off_down_to_the_ends_of_the_adc():
    hard = pushed(lambda t: np.where(t < 0.1, 5.0, -5.0) * GRAVITY)
    counts = ideal(hard).read(1280).counts
    assert (counts.min(), counts.max()) == MODEL.limits


def test_temperature_moves_offset_and_sensitivity():
    """MMA7260QT: 2 mg/K and 0.03 %/K."""
    warm, right = (
        seen(ideal(pushed(wave), temperature=temperature)) for temperature in (35.0, 25.0)
    )
    np.testing.assert_allclose(warm, right * 1.003 + 0.02 * GRAVITY, atol=1e-9)


def test_it_warms_up_with_its_time_constant():
    drift = seen(ideal('rest', warming=20.0, warming_time=0.1))[:, 0] / GRAVITY
    time = np.arange(1280) / RATE
    np.testing.assert_allclose(drift, 0.002 * 20.0 * (1.0 - np.exp(-time / 0.1)), atol=1e-9)
    steady = seen(ideal('rest', warming=20.0, temperature=5.0, warming_time=0.1), 64_000)
    np.testing.assert_allclose(steady[0], -0.04 * GRAVITY + UP * 0.994, atol=1e-9)
    np.testing.assert_allclose(steady[-1], UP, atol=1e-9)


def test_low_pass_weakens_each_axis_at_its_corner():
    """MMA7260QT: 350 Hz for x and y, 150 Hz for z."""
    rate = 50_000.0
    for corner, axes in ((350.0, [0, 1]), (150.0, [2])):
        omega = 2.0 * np.pi * corner
        source = ideal(pushed(lambda t, w=omega: 5.0 * np.sin(w * t)), rate=rate, low_pass=True)
        shown = seen(source, 20_000)[10_000:] - UP
        weakened = np.sqrt(2.0) * shown.std(axis=0) / 5.0
        assert weakened[axes] == pytest.approx([np.sqrt(0.5)] * len(axes), rel=3e-3)
        z_and_x = {350.0: 150.0 / 350.0, 150.0: 350.0 / 150.0}[corner]
        other = weakened[2 if axes == [0, 1] else 0]
        assert other == pytest.approx(1.0 / np.hypot(1.0, 1.0 / z_and_x), rel=3e-3)


def test_low_pass_is_settled_at_the_start():
    np.testing.assert_allclose(seen(ideal('rest', low_pass=True)), np.tile(UP, (1280, 1)))


def test_axes_are_converted_one_after_the_other():
    delay = 0.002
    shown = seen(ideal(pushed(wave), axis_delay=delay)) - UP
    time = np.arange(1280) / RATE
    for axis in range(3):
        np.testing.assert_allclose(shown[:, axis], wave(time + axis * delay), atol=1e-9)


def test_asleep_it_gives_nothing_and_woken_it_settles():
    wake_time = DRIVER.part.wake_time
    source = ideal('rest', sleep_until=0.1, rate=100_000.0)
    volts = source.read(20_000).counts * MODEL.unit_per_count
    time = np.arange(20_000) / 100_000.0
    assert not volts[time <= 0.1].any()
    share = volts[:, 2] / volts[-1, 2]
    np.testing.assert_allclose(share[time <= 0.1 + wake_time][-1], 1.0 - math.exp(-5.0))
    np.testing.assert_allclose(volts[time > 0.11] - volts[-1], 0.0, atol=1e-9)
    assert force(volts[-1] / MODEL.unit_per_count) == pytest.approx(UP)


def test_sleep_shows_as_clipped_conversions():
    counts = ideal('rest', sleep_until=0.1, clip=True, quantise=True).read(700).counts
    assert MODEL.clipped(counts[:640]).all()
    assert not MODEL.clipped(counts[690:]).any()


ON = {
    'noise': True,
    'clip': True,
    'quantise': True,
    'offset': (0.3, -0.2, 0.4),
    'sensitivity_error': (0.01, 0.01, 0.01),
    'cross_axis': (0.01,) * 6,
    'nonlinearity': 0.01,
    'supply_error': 0.01,
    'temperature': 40.0,
    'warming': 10.0,
    'low_pass': True,
    'axis_delay': 0.001,
    'sleep_until': 0.01,
    'attitude': (0.1, 0.0, 0.0),
}
NOT_FAULTS = {'seed', 'warming_time'}


def test_every_fault_is_tried():
    fields = {field.name for field in dataclasses.fields(SimulatedSettings)}
    assert set(ON) | NOT_FAULTS == fields


@pytest.mark.parametrize('fault', ON)
def test_every_fault_shows_alone_and_is_off_in_the_ideal_sensor(fault):
    hard = pushed(lambda t: 3.0 * wave(t))
    without = ideal(hard).read(1280).counts
    with_it = ideal(hard, **{fault: ON[fault]}).read(1280).counts
    assert (without != with_it).any()


def test_faults_that_are_on_by_default_are_small():
    """A calibrated one is off by less than its noise lets see at once: 2 % of g."""
    usual = SimulatedSettings(noise=False, quantise=False, offset=(0.0, 0.0, 0.0))
    calm = pushed(lambda t: 0.4 * wave(t))
    difference = seen(sensor(calm, settings=usual)) - seen(ideal(calm))
    assert 0.001 * GRAVITY < np.abs(difference).max() < 0.02 * GRAVITY


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
