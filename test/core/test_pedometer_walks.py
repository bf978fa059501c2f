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
from dead_reckoning.core import step_detectors
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.sources import motions

METHODS = step_detectors.names()
CADENCES = (0.8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5)
RUNS = (2.8, 3.0, 3.3)
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


def pedometer(method, sensor, **settings):
    axes = SENSORS[sensor].get('pedometer.axes', ('x', 'y', 'z'))
    chosen = PedometerSettings(method=method, axes=axes, **settings)
    return Pedometer(chosen, chosen.method_part())


def count(method, sensor, cadence, seed=1, **settings):
    counter = pedometer(method, sensor, **settings)
    for imu in walk(sensor, cadence, seed):
        counter.update(imu)
    return counter


@pytest.mark.parametrize('method', METHODS)
@pytest.mark.parametrize('cadence', CADENCES)
@pytest.mark.parametrize('sensor', SENSORS)
def test_steps_are_exact(method, sensor, cadence):
    assert [count(method, sensor, cadence, seed).steps for seed in (1, 2)] == [STEPS] * 2


@pytest.mark.parametrize('cadence', RUNS)
@pytest.mark.parametrize('sensor', SENSORS)
def test_steps_of_runs_are_exact(sensor, cadence):
    assert [count('rhythm', sensor, cadence, seed).steps for seed in (1, 2)] == [STEPS] * 2


@pytest.mark.parametrize('sensor', SENSORS)
@pytest.mark.parametrize('calibrated_at', [1.75, 2.0])
def test_an900_is_within_six_percent_at_any_other_pace(sensor, calibrated_at):
    method, equation = 'an900', {'length_model': 'an900_equation2'}
    k = LENGTH * STEPS / count(method, sensor, calibrated_at, k=1.0, **equation).distance
    for cadence in CADENCES:
        distance = count(method, sensor, cadence, k=k, **equation).distance
        assert distance == pytest.approx(LENGTH * STEPS, rel=0.06), cadence


@pytest.mark.parametrize(
    # AN-900's is where the force rises before the foot lands, the other one about where it lands.
    ('method', 'earliest', 'latest'),
    [('an900', -0.5 / 1.8, 0.0), ('rhythm', -0.1, 0.1)],
)
@pytest.mark.parametrize('sensor', SENSORS)
def test_step_times_are_those_of_the_landings(method, sensor, earliest, latest):
    """Each step is stamped at the same part of the step."""
    driver = Configuration(SENSORS[sensor])
    kind = motions.motion_class('walk')
    landings = kind(driver[kind.Settings]).steps.times
    counter = pedometer(method, sensor)
    stamps = [s.stamp_ns for imu in walk(sensor, 1.8) for s in counter.update(imu) if s.duration]
    since = [(stamp - START_NS) * 1e-9 for stamp in stamps]
    lags = [time - landing for time, landing in zip(since, landings, strict=True)][2:-2]
    assert max(lags) - min(lags) < 0.1
    assert earliest < sum(lags) / len(lags) < latest


@pytest.mark.parametrize('method', METHODS)
@pytest.mark.parametrize('sensor', SENSORS)
def test_rest_gives_no_steps(method, sensor):
    counter = pedometer(method, sensor)
    imus = walk(sensor, 2.5, after=120.0)
    for imu in imus[len(imus) // 4 :]:
        assert counter.update(imu) == []


def test_an900_device_stands_upright():
    first = walk('adxl330, x and y', 1.5)[0]
    assert first.specific_force[1] == pytest.approx(9.8, abs=0.5)
    assert math.hypot(first.specific_force[0], first.specific_force[2]) < 0.6
