"""The driver's settings describe the sensor of the data sheet."""

import numpy as np
import pytest

from dead_reckoning.core import sensors
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver_settings import DriverSettings

RANGES = [(name, range_g) for name in sensors.names() for range_g in sensors.part(name).ranges]


@pytest.mark.parametrize(
    ('range_g', 'sensitivity'), [(1.5, 0.8), (2.0, 0.6), (4.0, 0.3), (6.0, 0.2)]
)
def test_sensitivity_follows_the_range(range_g, sensitivity):
    model = DriverSettings(range_g=range_g).model()
    assert model.sensitivity == pytest.approx((sensitivity,) * 3)
    assert model.range_g == range_g


def test_mma7260qt_at_its_smallest_range_is_the_default():
    driver = DriverSettings()
    assert (driver.sensor, driver.range_g, driver.supply) == ('mma7260qt', 1.5, 3.3)
    model = driver.model()
    assert model.zero_g == pytest.approx((1.65,) * 3)
    assert model.zero_g_tolerance == pytest.approx(0.165)
    assert model.swing == pytest.approx((0.25, 3.05))
    assert model.noise == 0.0047
    assert model.unit_per_count == 3.3 / 4096
    assert model.limits == (0.0, 4095.0)


def test_everything_is_ratiometric_to_the_supply():
    model = DriverSettings(supply=2.75).model()
    assert model.zero_g == pytest.approx((1.375,) * 3)
    assert model.sensitivity == pytest.approx((0.8 * 2.75 / 3.3,) * 3)
    assert model.zero_g_tolerance == pytest.approx(0.165 * 2.75 / 3.3)
    assert model.swing == pytest.approx((0.25, 2.5))


def test_what_is_measured_of_a_part_overrides_the_data_sheet():
    model = DriverSettings(zero_g=(1.6, 1.7, 1.65), sensitivity=(0.79, 0.8, 0.81)).model()
    assert model.zero_g == (1.6, 1.7, 1.65)
    assert model.sensitivity == (0.79, 0.8, 0.81)


def test_circuit_is_as_set():
    model = DriverSettings(adc_bits=8, adc_reference=2.5, noise=0.01).model()
    assert model.limits == (0.0, 255.0)
    assert (model.unit_per_count, model.noise) == (2.5 / 256, 0.01)


# ADXL345 --------------------------------------------------------------------------------------


@pytest.mark.parametrize(('range_g', 'bits'), [(2.0, 10), (4.0, 11), (8.0, 12), (16.0, 13)])
def test_adxl345_has_counts_of_one_size_and_more_bits_in_larger_ranges(range_g, bits):
    model = DriverSettings(sensor='adxl345', range_g=range_g).model()
    assert model.force_per_count / GRAVITY == pytest.approx([0.00390625] * 3)
    half = 1 << (bits - 1)
    assert model.limits == model.swing == (-half, half - 1)
    beyond = np.array([[-1.5, 0.0, 1.5]]) * range_g * GRAVITY
    counts = model.counts(model.output(beyond))
    np.testing.assert_array_equal(counts, [[-half, 0, half - 1]])
    np.testing.assert_array_equal(model.clipped(counts), [[True, False, True]])
    within = model.counts(model.output(beyond * 0.66))
    assert not model.clipped(within).any()
    np.testing.assert_allclose(
        model.force(within, np.array(model.zero_g)), beyond * 0.66, atol=0.02
    )


def test_adxl345_is_digital_so_the_adc_and_the_supply_do_not_matter():
    plain, other = (
        DriverSettings(sensor='adxl345', **circuit).model()
        for circuit in ({}, {'adc_bits': 8, 'adc_reference': 1.0, 'supply': 3.6})
    )
    assert plain == other
    assert plain.zero_g == (0.0, 0.0, 0.0)
    assert plain.noise == 1.0


# ADXL330 --------------------------------------------------------------------------------------


def test_adxl330_has_300_millivolts_per_g_at_3_volts():
    driver = DriverSettings(sensor='adxl330')
    assert (driver.range_g, driver.supply, driver.adc_reference) == (3.0, 3.0, 3.0)
    model = driver.model()
    assert model.zero_g == (1.5,) * 3
    assert model.sensitivity == (0.3,) * 3
    assert model.force_per_count / GRAVITY == pytest.approx([3.0 / 4096 / 0.3] * 3)
    counts = model.counts(model.output(np.array([[-3.0, 0.0, 3.0]]) * GRAVITY))
    assert not model.clipped(counts).any(), 'the range fits into the swing'
    np.testing.assert_array_equal(counts, [[819, 2048, 3277]])


def test_adxl330_is_ratiometric():
    model = DriverSettings(sensor='adxl330', supply=2.0).model()
    assert model.zero_g == pytest.approx((1.0,) * 3)
    assert model.sensitivity == pytest.approx((0.2,) * 3)


# All sensors ----------------------------------------------------------------------------------


def test_there_are_the_sensors_of_the_documents():
    assert sensors.names() == ('adxl330', 'adxl345', 'mma7260qt', 'um7')


@pytest.mark.parametrize(('name', 'range_g'), RANGES)
def test_range_is_within_what_the_sensor_can_show(name, range_g):
    model = DriverSettings(sensor=name, range_g=range_g).model()
    force = np.array([[-0.99, 0.0, 0.99]]) * range_g * GRAVITY
    assert not model.clipped(model.counts(model.output(force))).any()
    assert 0.0 < model.noise < np.min(model.sensitivity), 'less than 1 g'
    assert model.zero_g_tolerance <= max(model.sensitivity), 'an upside-down one is found out'


@pytest.mark.parametrize('name', sensors.names())
def test_smallest_range_is_the_default(name):
    assert DriverSettings(sensor=name).range_g == min(sensors.part(name).ranges)


@pytest.mark.parametrize(
    ('name', 'range_g', 'said'),
    [
        ('mma7260qt', 3.0, '3 is not allowed; the mma7260qt has 1.5, 2, 4, 6'),
        ('adxl330', 1.5, '1.5 is not allowed; the adxl330 has 3'),
        ('adxl345', 6.0, '6 is not allowed; the adxl345 has 2, 4, 8, 16'),
    ],
)
def test_range_that_a_sensor_has_not_is_refused_with_those_it_has(name, range_g, said):
    with pytest.raises(SettingsError) as caught:
        DriverSettings(sensor=name, range_g=range_g)
    assert str(caught.value).startswith(f'driver.range_g: {said}')


@pytest.mark.parametrize(('name', 'supply'), [('mma7260qt', 2.0), ('adxl345', 1.9)])
def test_supply_that_a_sensor_does_not_take_is_refused(name, supply):
    with pytest.raises(SettingsError, match=rf'driver\.supply: {supply:g} .* the {name} takes 2'):
        DriverSettings(sensor=name, supply=supply)


def test_simulated_sensor_is_calibrated_on_start():
    assert DriverSettings(source='simulated').calibrate_on_start
    assert not DriverSettings(source='simulated', calibrate_on_start=False).calibrate_on_start


@pytest.mark.parametrize(
    ('key', 'value'),
    [
        ('sensor', 'adxl999'),
        ('adc_bits', 14),
        ('supply', 5.0),
        ('motion', 'jump'),
        ('noise', -1.0),
    ],
)
def test_what_the_sensor_can_not_be_is_refused(key, value):
    with pytest.raises(SettingsError, match=rf'driver\.{key}'):
        DriverSettings(**{key: value})


def test_every_motion_can_be_chosen():
    expected = {'gait', 'lift', 'rest', 'slide', 'square', 'turntable', 'vehicle', 'walk'}
    assert expected <= set(motions.names())
    for name in motions.names():
        assert DriverSettings(motion=name).motion == name
