"""Calibration at rest finds the offsets, keeps +g, and refuses what is no rest."""

import math

import numpy as np
import pytest

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.errors import CalibrationError, NotAtRestError
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.zero_g import ZeroGCalibration

CONVERSIONS = 1024
UP = np.array([0.0, 0.0, GRAVITY])


def sensor(bits=12):
    return Accelerometer(
        range_g=1.5,
        zero_g=(1.65, 1.65, 1.65),
        sensitivity=(0.8, 0.8, 0.8),
        zero_g_tolerance=0.165,
        swing=(0.25, 3.05),
        noise=0.0047,
        unit_per_count=3.3 / (1 << bits),
        limits=(0.0, (1 << bits) - 1.0),
    )


def measured(model, force, offset=0.0, seed=1):
    """Return counts of a specific force, shape (3,) or (n, 3), with noise; offset in volts."""
    random = np.random.default_rng(seed)
    force = np.broadcast_to(force, (CONVERSIONS, 3))
    volts = model.output(force) + offset + model.noise * random.standard_normal(force.shape)
    return model.counts(volts)


def calibrated(model, counts, deviation=0.5):
    calibration = ZeroGCalibration(model, CONVERSIONS, deviation)
    calibration.add(counts)
    return calibration.finish()


@pytest.mark.parametrize('bits', [8, 10, 12, 16])
@pytest.mark.parametrize('seed', range(5))
def test_offsets_within_the_tolerance_are_found(bits, seed):
    model = sensor(bits)
    offset = np.random.default_rng(seed).uniform(-0.16, 0.16, 3)
    found = calibrated(model, measured(model, UP, offset, seed)) - np.array(model.zero_g)
    noise = 5.0 * model.noise / math.sqrt(CONVERSIONS)
    assert found == pytest.approx(offset, abs=noise + (model.unit_per_count if bits < 12 else 0))


def test_gravity_stays_on_the_up_axis():
    model = sensor()
    counts = measured(model, UP, np.array([0.1, -0.1, 0.05]))
    force = model.force(counts.mean(axis=0), calibrated(model, counts))
    np.testing.assert_allclose(force, UP, atol=1e-9)


def test_conversions_come_in_pieces():
    model = sensor()
    counts = measured(model, UP, 0.1)
    calibration = ZeroGCalibration(model, CONVERSIONS, 0.5)
    for start in range(0, CONVERSIONS, 100):
        assert calibration.missing == CONVERSIONS - start
        calibration.add(counts[start : start + 100])
    assert calibration.missing == 0
    np.testing.assert_array_equal(calibration.finish(), calibrated(model, counts))


def test_slide_during_it_is_refused():
    time = np.linspace(0.0, 1.0, CONVERSIONS)
    force = np.outer(np.sin(2.0 * np.pi * time), [3.0, 0.0, 0.0]) + UP
    with pytest.raises(NotAtRestError, match='hold it still and ask again'):
        calibrated(sensor(), measured(sensor(), force))


@pytest.mark.parametrize('axis', [0, 1])
def test_slow_tilt_is_refused_though_no_moment_of_it_moves(axis):
    """Two degrees in all: far below the deviation allowed, far above what averaging leaves."""
    angle = np.radians(np.linspace(-1.0, 1.0, CONVERSIONS))
    force = np.zeros((CONVERSIONS, 3))
    force[:, axis], force[:, 2] = GRAVITY * np.sin(angle), GRAVITY * np.cos(angle)
    counts = measured(sensor(), force)
    assert (counts.std(axis=0) * sensor().force_per_count).max() < 0.5
    with pytest.raises(NotAtRestError, match=r'the device moved .* \(1[67] mg\) on an axis'):
        calibrated(sensor(), counts)


def test_vibration_over_the_deviation_is_refused():
    random = np.random.default_rng(2)
    force = UP + np.outer(random.normal(0.0, 0.6, CONVERSIONS), [0.0, 1.0, 0.0])
    with pytest.raises(NotAtRestError, match=r'0\.6\d* m/s²'):
        calibrated(sensor(), measured(sensor(), force), deviation=0.5)
    calibrated(sensor(), measured(sensor(), force), deviation=0.8)


@pytest.mark.parametrize('seed', range(20))
@pytest.mark.parametrize('bits', [8, 12])
def test_noise_alone_is_taken_for_rest(bits, seed):
    model = sensor(bits)
    calibrated(model, measured(model, UP, seed=seed), deviation=0.3)


@pytest.mark.parametrize(('axis', 'name'), [(0, 'x'), (1, 'y'), (2, 'z')])
@pytest.mark.parametrize('sign', [-1.0, 1.0])
def test_offset_that_no_good_part_has_is_refused(axis, name, sign):
    offset = np.zeros(3)
    offset[axis] = sign * 0.2
    with pytest.raises(CalibrationError) as caught:
        calibrated(sensor(), measured(sensor(), UP, offset))
    said = str(caught.value)
    assert f'axis {name} would be {sign * 0.25:+.3f} g' in said
    assert '±0.206 g' in said
    for cause in ('not level', 'does not point up', 'driver.range_g', 'driver.supply'):
        assert cause in said


@pytest.mark.parametrize('degrees', [13.0, 20.0, 45.0])
def test_tilt_is_named_with_its_angle(degrees):
    angle = math.radians(degrees)
    force = GRAVITY * np.array([-math.sin(angle), 0.0, math.cos(angle)])
    with pytest.raises(CalibrationError, match=f'{degrees:.0f}° would look like this'):
        calibrated(sensor(), measured(sensor(), force))


def test_sensor_upside_down_is_refused():
    with pytest.raises(CalibrationError, match='its z axis does not point up'):
        calibrated(sensor(), measured(sensor(), -UP))


def test_wrong_range_is_refused():
    """The pins say ±2 g, the settings ±1.5 g: z shows 0.75 g."""
    with pytest.raises(CalibrationError, match=r'driver\.range_g'):
        calibrated(sensor(), measured(sensor(), 0.75 * UP))
