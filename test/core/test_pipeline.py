"""The whole chain on the simulated sensor with every effect on: AN3397's slide."""

import dataclasses

import numpy as np
import pytest

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.chain import FAULT
from dead_reckoning.core.errors import NotLevelledError, SettingsError
from dead_reckoning.core.pipeline import Pipeline, PipelineSettings
from dead_reckoning.core.stages import ODOMETRY, RAW
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings

START_NS = 1_700_000_000_000_000_000
SEEDS = range(20)


def slide(seed, **values):
    """Run 5 s of a slide with random faults of the sensor; return states, end truth, faults."""
    random = np.random.default_rng(seed)
    configuration = Configuration(
        {
            'driver.simulated.seed': seed,
            'driver.simulated.offset': random.uniform(-0.5, 0.5, 3),
            'driver.simulated.sensitivity_error': random.uniform(-0.01, 0.01, 3),
            **values,
        }
    )
    source = simulated_sensor(configuration, START_NS)
    chain = Pipeline(configuration).chain
    conversions = source.read(round(5.0 * configuration[DriverSettings].sample_rate))
    samples = front_end(configuration).add(conversions)
    outputs = [output for sample in samples for output in chain.push(RAW, sample)]
    states = [value for name, value in outputs if name == ODOMETRY]
    faults = [value for name, value in outputs if name == FAULT]
    return states, source.truth(states[-1].stamp_ns), faults


@pytest.fixture(scope='module')
def slides():
    return [slide(seed) for seed in SEEDS]


def test_displacement_is_within_five_percent(slides):
    errors = [
        np.linalg.norm(np.subtract(states[-1].position, truth.position))
        for states, truth, _ in slides
    ]
    assert {truth.position[0] for _, truth, _ in slides} == {0.5}
    assert np.median(errors) / 0.5 <= 0.05
    assert max(errors) / 0.5 <= 0.10


def test_error_is_within_three_sigma_of_what_is_published(slides):
    for states, truth, _ in slides:
        error = np.abs(np.subtract(states[-1].position, truth.position))
        assert (error <= 3.0 * np.sqrt(states[-1].position_covariance[::4])).all()


def test_it_ends_at_rest(slides):
    for states, _, _ in slides:
        assert states[-1].stationary
        assert states[-1].velocity == (0.0, 0.0, 0.0)
        assert not all(state.stationary for state in states)


def test_it_only_waits_for_rest(slides):
    for states, _, faults in slides:
        assert {type(fault) for fault in faults} == {NotLevelledError}
        assert len(faults) == 50
        assert len(states) == 500 - 16 - 50


@pytest.mark.parametrize(
    'values',
    [
        {'driver.adc_bits': 8},
        {'driver.adc_bits': 16},
        {'driver.range_g': 2.0, 'driver.adc_bits': 10},
        {'driver.slide.distance': -0.5},
        {'driver.slide.axis': 'y'},
        {'integrator.method': 'euler'},
        {'integrator.movement_end': 'each'},
    ],
    ids=str,
)
def test_displacement_in_other_set_ups(values):
    errors = []
    for seed in range(5):
        states, truth, _ = slide(seed, **values)
        errors.append(np.linalg.norm(np.subtract(states[-1].position, truth.position)))
    assert np.median(errors) / 0.5 <= 0.05


def test_same_seed_gives_the_same_bits():
    first, second = ([dataclasses.astuple(state) for state in slide(3)[0]] for _ in range(2))
    assert first == second
    assert first != [dataclasses.astuple(state) for state in slide(4)[0]]


@pytest.mark.parametrize('asked', [{'log_csv': 'log.csv'}, {'duration': 15.0}], ids=str)
def test_states_can_not_be_logged_or_timed_without_an_integrator(asked):
    """A log that stays empty and an end that never comes are said at the start."""
    PipelineSettings(**asked, estimators=('integrator', 'pedometer'))
    PipelineSettings(**asked, estimators=('inertial_navigator',))
    (key,) = asked
    with pytest.raises(SettingsError, match=rf'pipeline\.{key}: .*integrator'):
        PipelineSettings(**asked, estimators=('pedometer',))


def test_only_one_gives_odom():
    PipelineSettings(estimators=('inertial_navigator', 'pedometer'))
    with pytest.raises(SettingsError, match='integrator and inertial_navigator exclude'):
        PipelineSettings(estimators=('inertial_navigator', 'pedometer', 'integrator'))
