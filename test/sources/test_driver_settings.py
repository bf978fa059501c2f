"""The driver's settings describe the sensor of the data sheet."""

import pytest

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver_settings import DriverSettings


@pytest.mark.parametrize(
    ('range_g', 'sensitivity'), [(1.5, 0.8), (2.0, 0.6), (4.0, 0.3), (6.0, 0.2)]
)
def test_sensitivity_follows_the_range(range_g, sensitivity):
    model = DriverSettings(range_g=range_g).model()
    assert model.sensitivity == pytest.approx((sensitivity,) * 3)
    assert model.range_g == range_g


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
    assert (model.bits, model.reference, model.noise) == (8, 2.5, 0.01)


def test_simulated_sensor_is_calibrated_on_start():
    assert DriverSettings(source='simulated').calibrate_on_start
    assert not DriverSettings(source='simulated', calibrate_on_start=False).calibrate_on_start


@pytest.mark.parametrize(
    ('key', 'value'),
    [('range_g', 3.0), ('adc_bits', 14), ('supply', 5.0), ('motion', 'jump'), ('noise', -1.0)],
)
def test_what_the_sensor_can_not_be_is_refused(key, value):
    with pytest.raises(SettingsError, match=rf'driver\.{key}'):
        DriverSettings(**{key: value})


def test_every_motion_can_be_chosen():
    assert {'rest', 'slide'} <= set(motions.names())
    for name in motions.names():
        assert DriverSettings(motion=name).motion == name
