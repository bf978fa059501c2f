"""The centre of the circle that a turn draws is found, and what is no circle refused."""

import math

import numpy as np
import pytest

from dead_reckoning.core.errors import CalibrationError
from dead_reckoning.core.hard_iron import HardIronCalibration


def turn(calibration, degrees, offset=(0.1, -0.2), strength=1.0, noise=0.0, rate=1e9 / 20.0):
    """Turn in steps of 5°, 20 a second; return whether it was enough."""
    random = np.random.default_rng(1)
    sign = math.copysign(1.0, degrees)
    for number, angle in enumerate(np.arange(0.0, abs(degrees) + 1e-9, 5.0)):
        x = strength * math.cos(math.radians(sign * angle)) + offset[0]
        y = strength * math.sin(math.radians(sign * angle)) + offset[1]
        x, y = (np.array([x, y]) + noise * random.standard_normal(2)).tolist()
        if calibration.add(round(number * rate), x, y):
            return True
    return False


@pytest.mark.parametrize('direction', [370.0, -370.0])
@pytest.mark.parametrize('strength', [1.0, 45.0])
def test_offset_is_found_whatever_the_direction_and_the_unit(direction, strength):
    calibration = HardIronCalibration(15.0)
    offset = (0.1 * strength, -0.2 * strength)
    assert turn(calibration, direction, offset, strength)
    assert calibration.finish() == pytest.approx(offset)


def test_noise_averages_out():
    calibration = HardIronCalibration(15.0)
    assert turn(calibration, 380.0, noise=0.01)
    assert calibration.finish() == pytest.approx((0.1, -0.2), abs=0.004)


@pytest.mark.parametrize('degrees', [0.0, 90.0, 350.0])
def test_less_than_a_turn_is_not_enough(degrees):
    assert not turn(HardIronCalibration(15.0), degrees, offset=(0.0, 0.0))


def test_turning_back_and_forth_is_no_turn():
    calibration = HardIronCalibration(60.0)
    for _ in range(3):
        assert not turn(calibration, 120.0, offset=(0.0, 0.0))


def test_turn_that_takes_too_long_is_refused_with_what_it_was():
    with pytest.raises(CalibrationError) as caught:
        turn(HardIronCalibration(2.0), 370.0, offset=(0.0, 0.0))
    said = str(caught.value)
    assert 'turned by 205° in 2 s' in said
    assert 'turn it level once around' in said


def test_field_that_draws_no_circle_is_refused():
    calibration = HardIronCalibration(15.0)
    for angle in np.radians(np.arange(0.0, 375.0, 5.0)):
        if calibration.add(0, math.cos(angle), 0.4 * math.sin(angle)):
            break
    with pytest.raises(CalibrationError, match=r'drew no circle: it is off by .*% of its radius'):
        calibration.finish()
