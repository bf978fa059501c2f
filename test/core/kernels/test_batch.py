"""Whole recordings in blocks: the numbers, faults and notices of the stream."""

import numpy as np
import pytest
from random_recordings import EAGER, assert_same, in_blocks, recording, streamed

from dead_reckoning.core.batch import gravity, integrator, pedometer
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.pedometer import Pedometer
from dead_reckoning.core.stages import IMU, ODOMETRY, RAW, STATIONARY, STEPS

ALL = ['integrator', 'pedometer']
MESSAGE = {'gravity.attitude': 'message'}
ESTIMATE = {'gravity.attitude': 'estimate'}

CHAINS = {
    'default': {},
    'euler, each': {'integrator.method': 'euler', 'integrator.movement_end': 'each'},
    'no movement end': {'integrator.movement_end': 'off', 'gravity.measure': False},
    'two axes': {'integrator.axes': ['x', 'y'], 'integrator.movement_end': 'each'},
    'message, two axes, each': {
        **MESSAGE,
        'integrator.axes': ['x', 'z'],
        'integrator.movement_end': 'each',
        'integrator.movement_end_samples': 3,
    },
    'estimate': ESTIMATE,
    'estimate, often at rest': {
        **ESTIMATE,
        'gravity.rest_duration': 0.1,
        'gravity.rest_rate': 1.0,
        'gravity.rest_deviation': 5.0,
        'gravity.rest_rate_deviation': 1.0,
        'gravity.rate_offset': 10.0,
    },
    'with a pedometer': {'pipeline.estimators': ALL, **EAGER},
    'with a pedometer by AN-900': {'pipeline.estimators': ALL, 'pedometer.method': 'an900'},
    'pedometer': {
        'pipeline.estimators': ['pedometer'],
        'pedometer.reorder_time': 0.0,
        'pedometer.axes': ['x', 'y'],
        **EAGER,
    },
    'message, pedometer': {
        **MESSAGE,
        **EAGER,
        'pipeline.estimators': ALL,
        'pedometer.input': 'imu/data',
    },
    'message, pedometer along the orientation': {
        **MESSAGE,
        **EAGER,
        'pipeline.estimators': ['pedometer'],
        'pedometer.input': 'imu/data',
        'pedometer.heading': 'orientation',
    },
}

LEFT_TO_THE_STREAM = {
    'one axis': {'integrator.axes': ['y']},
    'kalman': {'integrator.method': 'kalman'},
    'turned sensor': {'frames.mounting_rotation': [0.0, 0.1, 1.0], 'pipeline.estimators': ALL},
    'sensor off the origin': {'frames.mounting_translation': [0.1, 0.2, 0.3]},
}


def recorded(values, seed, **more):
    """Return the topic that a chain takes and a recording of it."""
    attitude = values.get('gravity.attitude')
    with_gyro = attitude == 'estimate' or seed == 1
    samples = recording(seed, gyro=with_gyro, orientation=attitude == 'message', **more)
    return IMU if attitude == 'message' else RAW, samples


def random_cuts(seed, count):
    random = np.random.default_rng(seed)
    return sorted(random.integers(0, count, random.integers(1, 9)).tolist())


@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize('values', CHAINS.values(), ids=CHAINS)
def test_blocks_give_what_the_stream_gives(values, seed):
    name, samples = recorded(values, seed)
    stream = streamed(values, name, samples)
    assert_same(in_blocks(values, name, samples, random_cuts(seed, len(samples))), stream)


@pytest.mark.parametrize('values', LEFT_TO_THE_STREAM.values(), ids=LEFT_TO_THE_STREAM)
def test_what_is_left_to_the_stream_comes_out_all_the_same(values):
    name, samples = recorded(values, 0, seconds=4.0)
    stream = streamed(values, name, samples)
    assert_same(in_blocks(values, name, samples, [150]), stream, tolerance=1e-12)


def test_dense_faults_are_only_slow():
    name, samples = recorded(CHAINS['with a pedometer'], 5, odd=0.3)
    stream = streamed(CHAINS['with a pedometer'], name, samples)
    assert_same(in_blocks(CHAINS['with a pedometer'], name, samples, []), stream)


def test_the_recordings_hold_movements_rests_and_steps():
    name, samples = recorded(CHAINS['with a pedometer'], 0, odd=0.02)
    stream = streamed(CHAINS['with a pedometer'], name, samples)
    assert len(stream[ODOMETRY]) > 0.5 * len(samples)
    assert len(stream[STATIONARY]) > 4
    assert len({type(fault) for _, fault in stream['fault']}) > 5
    recordings = (recorded(CHAINS['with a pedometer'], seed) for seed in range(3))
    streams = [streamed(CHAINS['with a pedometer'], *each) for each in recordings]
    assert min(stream[STEPS][-1][1] for stream in streams) > 2


@pytest.mark.parametrize('attitude', ['rest', 'message', 'estimate'])
def test_only_what_is_odd_goes_through_the_stream(monkeypatch, attitude):
    pytest.importorskip('numba')
    values = {'gravity.attitude': attitude, 'pipeline.estimators': ALL}
    name, samples = recorded(values, 0, odd=0.0)
    if attitude == 'message':
        values['pedometer.input'] = IMU
    calls = dict.fromkeys((GravityRemoval, Integrator, Pedometer), 0)
    for estimator in calls:

        def counted(self, *given, update=estimator.update, estimator=estimator):
            calls[estimator] += 1
            return update(self, *given)

        monkeypatch.setattr(estimator, 'update', counted)
    in_blocks(values, name, samples, [400, 401])
    assert calls[Integrator] == 1
    # The first rest takes half a second; with a gyro each half a second's last sample is odd.
    assert calls[GravityRemoval] <= 51 + (24 if attitude == 'estimate' else 0)
    assert calls[Pedometer] <= 15


@pytest.mark.parametrize(
    'values',
    [
        CHAINS['two axes'],
        CHAINS['with a pedometer'],
        CHAINS['message, two axes, each'],
        CHAINS['message, pedometer along the orientation'],
        ESTIMATE,
    ],
    ids=str,
)
def test_compiled_and_uncompiled_kernels_agree(monkeypatch, values):
    pytest.importorskip('numba')
    name, samples = recorded(values, 2, seconds=4.0)
    compiled = in_blocks(values, name, samples, [150])
    for module in (gravity, integrator, pedometer):
        for key, value in vars(module).items():
            if getattr(value, '__wrapped__', None) and value.__module__ != module.__name__:
                monkeypatch.setattr(module, key, value.__wrapped__)
    assert_same(in_blocks(values, name, samples, [150]), compiled)
