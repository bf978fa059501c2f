"""Whole recordings in blocks: the numbers, faults and notices of the stream."""

import numpy as np
import pytest
from random_recordings import assert_same, in_blocks, recording, streamed

from dead_reckoning.core.stages import IMU, RAW

CHAINS = {
    'default': {},
    'rest, euler, each': {'integrator.method': 'euler', 'integrator.movement_end': 'each'},
    'rest, no movement end': {'integrator.movement_end': 'off', 'gravity.measure': False},
    'rest, two axes': {'integrator.axes': ['x', 'y'], 'integrator.movement_end': 'each'},
    'rest, one axis': {'integrator.axes': ['y']},
    'rest, kalman': {'integrator.method': 'kalman'},
    'rest, turned sensor': {'frames.mounting_rotation': [0.0, 0.1, 1.0]},
    'rest, sensor off the origin': {'frames.mounting_translation': [0.1, 0.2, 0.3]},
    'message': {'gravity.attitude': 'message'},
    'message, two axes, each': {
        'gravity.attitude': 'message',
        'integrator.axes': ['x', 'z'],
        'integrator.movement_end': 'each',
        'integrator.movement_end_samples': 3,
    },
    'estimate': {'gravity.attitude': 'estimate'},
    'with a pedometer': {'pipeline.estimators': ['integrator', 'pedometer']},
    'pedometer': {
        'pipeline.estimators': ['pedometer'],
        'pedometer.reorder_time': 0.0,
        'pedometer.axes': ['x', 'y'],
    },
    'message, pedometer': {
        'gravity.attitude': 'message',
        'pipeline.estimators': ['integrator', 'pedometer'],
        'pedometer.input': 'imu/data',
    },
    'message, pedometer along the orientation': {
        'gravity.attitude': 'message',
        'pipeline.estimators': ['pedometer'],
        'pedometer.input': 'imu/data',
        'pedometer.heading': 'orientation',
    },
}


@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize('values', CHAINS.values(), ids=CHAINS)
def test_blocks_give_what_the_stream_gives(values, seed):
    attitude = values.get('gravity.attitude')
    samples = recording(
        seed, gyro=attitude == 'estimate' or seed == 1, orientation=attitude == 'message'
    )
    name = IMU if attitude == 'message' else RAW
    random = np.random.default_rng(seed)
    cuts = sorted(random.integers(0, len(samples), random.integers(1, 9)).tolist())
    stream = streamed(values, name, samples)
    assert_same(in_blocks(values, name, samples, cuts), stream)
