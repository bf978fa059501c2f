"""What the data sheets say, and what follows from it."""

import math

import pytest

from dead_reckoning.core import sensors


def test_mma7260qt_has_the_figures_of_its_sheet():
    part = sensors.part('mma7260qt')
    assert part.ranges == {1.5: 0.8, 2.0: 0.6, 4.0: 0.3, 6.0: 0.2}
    assert part.supply == (3.3, 2.2, 3.6)
    assert (part.zero_g, part.zero_g_tolerance) == (1.65, 0.165)
    assert part.low_pass == (350.0, 350.0, 150.0)
    assert part.swing_margin == 0.25
    assert not part.digital


def test_adxl345_has_the_figures_of_its_sheet():
    part = sensors.part('adxl345')
    assert part.digital
    assert set(part.ranges) == {2.0, 4.0, 8.0, 16.0}
    for counts_per_g in part.ranges.values():
        assert 1000.0 / counts_per_g == pytest.approx(3.9, abs=0.01), 'mg'
    assert part.limits(16.0)[1] - part.limits(16.0)[0] == (1 << 13) - 1
    assert part.zero_g_tolerance == pytest.approx(0.25 * 256.0), 'z, the worst axis'
    assert part.wake_time == pytest.approx(1.0 / 3200.0 + 0.0011, abs=1e-4)


def test_adxl330_has_the_figures_of_its_sheet():
    part = sensors.part('adxl330')
    assert part.ratiometric
    assert part.ranges == {3.0: 0.3}
    assert (part.supply[0], part.zero_g, part.zero_g_tolerance) == (3.0, 1.5, 0.3)
    assert part.low_pass == (30.0,) * 3
    assert part.noise == pytest.approx(280e-6 * math.sqrt(1.57 * 30.0) * 0.3, rel=0.01)


def test_um7_is_a_16_bit_sensor_of_8_g_with_4_mg_of_noise():
    part = sensors.part('um7')
    assert part.digital
    assert part.limits(8.0) == (-32_768.0, 32_767.0)
    assert part.noise / part.ranges[8.0] == pytest.approx(0.004, rel=0.01)
    assert part.zero_g_tolerance / part.ranges[8.0] == pytest.approx(0.08, rel=0.01)


@pytest.mark.parametrize('name', sensors.names())
def test_nominal_supply_is_allowed_and_scales_by_one(name):
    part = sensors.part(name)
    nominal, low, high = part.supply
    assert low <= nominal <= high
    assert part.scale(nominal) == 1.0


def test_only_a_ratiometric_output_follows_the_supply():
    assert sensors.part('mma7260qt').scale(2.2) == pytest.approx(2.0 / 3.0)
    assert sensors.part('adxl345').scale(2.0) == 1.0


def test_counts_span_the_range():
    part = sensors.part('adxl345')
    assert part.limits(2.0) == (-512.0, 511.0)
    assert part.limits(16.0) == (-4096.0, 4095.0)


@pytest.mark.parametrize('name', sensors.names())
def test_figures_are_plausible(name):
    part = sensors.part(name)
    assert min(part.ranges) > 0.0
    assert all(sensitivity > 0.0 for sensitivity in part.ranges.values())
    assert 0.0 <= part.offset_drift < 0.01
    assert 0.0 <= part.sensitivity_drift < 0.001
    assert 0.0 < part.wake_time < 0.1
