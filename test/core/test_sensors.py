"""What the data sheets say, and what follows from it."""

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
