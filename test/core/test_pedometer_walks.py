"""Simulated walks through simulated sensors: steps exact, distance within AN-900's 6 %."""

import math
from functools import cache

import pytest

from benchmarks.accuracy.trunk_walks import (
    ADXL330,
    MMA7260QT,
    MMA7260QT_8_BIT,
    START_NS,
    walked,
)
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.core.step_detectors.an900 import An900Settings
from dead_reckoning.sources import motions

CADENCES = (0.8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5)
LENGTH, STEPS = 0.7, 60
SENSORS = {
    'adxl330, x and y': ADXL330,
    'adxl330, all axes': {**ADXL330, 'pedometer.axes': ('x', 'y', 'z')},
    'mma7260qt': MMA7260QT,
    'mma7260qt, 8 bit': MMA7260QT_8_BIT,
}


@cache
def walk(sensor, cadence, seed=1, after=4.0):
    """Return the samples of a walk of 60 steps of 0.7 m."""
    gait = {'cadence': cadence, 'step_length': LENGTH, 'steps': STEPS}
    return walked(SENSORS[sensor], seed, after, **gait)


def count(sensor, cadence, seed=1, **settings):
    axes = SENSORS[sensor].get('pedometer.axes', ('x', 'y', 'z'))
    counter = Pedometer(PedometerSettings(axes=axes, **settings), An900Settings())
    for imu in walk(sensor, cadence, seed):
        counter.update(imu)
    return counter


@pytest.mark.parametrize('cadence', CADENCES)
@pytest.mark.parametrize('sensor', SENSORS)
def test_steps_are_exact(sensor, cadence):
    assert [count(sensor, cadence, seed).steps for seed in (1, 2)] == [STEPS] * 2


@pytest.mark.parametrize('sensor', SENSORS)
@pytest.mark.parametrize('calibrated_at', [1.75, 2.0])
def test_equation_2_is_within_six_percent_at_any_other_pace(sensor, calibrated_at):
    k = LENGTH * STEPS / count(sensor, calibrated_at, k=1.0).distance
    for cadence in CADENCES:
        distance = count(sensor, cadence, k=k).distance
        assert distance == pytest.approx(LENGTH * STEPS, rel=0.06), cadence


@pytest.mark.parametrize('sensor', SENSORS)
def test_step_times_are_those_of_the_landings(sensor):
    """Each step is stamped at the same part of the step before the foot lands."""
    driver = Configuration(SENSORS[sensor])
    kind = motions.motion_class('walk')
    landings = kind(driver[kind.Settings]).steps.times
    axes = SENSORS[sensor].get('pedometer.axes', ('x', 'y', 'z'))
    counter = Pedometer(PedometerSettings(axes=axes), An900Settings())
    stamps = [s.stamp_ns for imu in walk(sensor, 1.8) for s in counter.update(imu) if s.duration]
    since = [(stamp - START_NS) * 1e-9 for stamp in stamps]
    lags = [time - landing for time, landing in zip(since, landings, strict=True)][2:-2]
    assert max(lags) - min(lags) < 0.1
    assert -0.5 / 1.8 < sum(lags) / len(lags) < 0.0


@pytest.mark.parametrize('sensor', SENSORS)
def test_rest_gives_no_steps(sensor):
    counter = Pedometer(PedometerSettings(), An900Settings())
    imus = walk(sensor, 2.5, after=120.0)
    for imu in imus[len(imus) // 4 :]:
        assert counter.update(imu) == []


def test_an900_device_stands_upright():
    first = walk('adxl330, x and y', 1.5)[0]
    assert first.specific_force[1] == pytest.approx(9.8, abs=0.5)
    assert math.hypot(first.specific_force[0], first.specific_force[2]) < 0.6
