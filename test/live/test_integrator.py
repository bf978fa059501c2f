"""A chain on messages: what the kernel makes of them is what the stream makes of them."""

import dataclasses

import numpy as np
import pytest
from driven import assert_same, driven, spoiled
from random_recordings import EAGER, LONG_GAP_NS, recording

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.chain import FAULT
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.kernels import (
    bias_growth,
    columns,
    gravity,
    headings,
    integrator,
    messages,
    resampler,
)
from dead_reckoning.core.kernels import live as kernel
from dead_reckoning.core.pedometer import PedometerSettings
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.stages import (
    COMPASS,
    IMU,
    ODOMETRY,
    RAW,
    STATIONARY,
    STEPS,
    TOTALS,
)
from dead_reckoning.live import integrator as live_integrator
from dead_reckoning.live import live_chain
from dead_reckoning.live.chain import WAIT
from dead_reckoning.live.integrator import IntegratorChain

ALL = ['integrator', 'pedometer']
MESSAGE = {'gravity.attitude': 'message'}
WALK = {'pipeline.estimators': ALL, **EAGER}

CHAINS = {
    'integrator': {},
    'euler, each': {'integrator.method': 'euler', 'integrator.movement_end': 'each'},
    'no movement end': {'integrator.movement_end': 'off', 'gravity.measure': False},
    'message, two axes, each': {
        **MESSAGE,
        'integrator.axes': ['x', 'z'],
        'integrator.movement_end': 'each',
        'integrator.movement_end_samples': 3,
    },
    'pedometer': WALK,
    'pedometer, no order': {**WALK, 'pedometer.reorder_time': 0.0, 'pedometer.axes': ['x', 'y']},
    'pedometer on what was levelled': {**WALK, 'pedometer.input': IMU},
    'pedometer and message': {**MESSAGE, **WALK, 'pedometer.input': IMU},
    'along the orientation': {
        **MESSAGE,
        **WALK,
        'pedometer.input': IMU,
        'pedometer.heading': 'orientation',
        'pedometer.reorder_time': 0.9,
    },
    'short gaps': {**WALK, 'pedometer.max_gap': 0.05, 'integrator.max_gap': 0.9},
}

NOT_SUITED = {
    'one axis': {'integrator.axes': ['y']},
    'kalman': {'integrator.method': 'kalman'},
    'estimate': {'gravity.attitude': 'estimate'},
    'turned sensor': {'frames.mounting_rotation': [0.0, 0.1, 1.0]},
    'sensor off the origin': {'frames.mounting_translation': [0.1, 0.2, 0.3]},
    'mounting from TF': {'frames.mounting': 'tf'},
    'transforms': {'frames.publish_tf': True},
    'a source of its own': {'pipeline.source': 'simulated'},
    'no integrator': {'pipeline.estimators': ['pedometer']},
    'two inputs': {**MESSAGE, **WALK},
}


def reset(driven):
    driven.pipeline.integrator.reset()


def calibrate(driven):
    driven.pipeline.integrator.calibrate()


def level(driven):
    driven.pipeline.gravity.level()


def narrow(driven):
    settings = driven.configuration[IntegratorSettings]
    driven.pipeline.integrator.configure(
        settings.changed({'integrator.window_maximum': 0.1, 'integrator.window_minimum': -0.05})
    )


def look(driven):
    """See what /diagnostics shows."""
    walked = driven.pipeline.pedometer
    shown = (walked.steps, walked.walking, walked.cadence) if walked else ()
    driven.outputs.append(('shown', (driven.pipeline.gravity.levelled, *shown)))


def restart_steps(driven):
    driven.pipeline.pedometer.start()
    driven.pipeline.step_odometry.reset()
    return TOTALS


def stop_steps(driven):
    driven.pipeline.pedometer.stop()
    return TOTALS


def lengthen_steps(driven):
    settings = driven.configuration[PedometerSettings].changed({'pedometer.k': 2.0})
    driven.pipeline.pedometer.configure(settings)
    driven.pipeline.step_odometry.configure(settings)


SERVICES = [reset, calibrate, level, narrow, look, look, look]
STEP_SERVICES = [restart_steps, stop_steps, lengthen_steps]


def traffic(values, seed, **more):
    """Return what happens to a node: calls of `Driven`, in order."""
    random = np.random.default_rng(seed)
    name = IMU if values.get('gravity.attitude') == 'message' else RAW
    with_attitude = name == IMU or 'pedometer.heading' in values or seed == 2
    samples = recording(seed, gyro=seed > 0, orientation=with_attitude, **more)
    services = SERVICES + (STEP_SERVICES if 'pipeline.estimators' in values else [])
    happens = []
    for sample in samples:
        chance = random.random()
        if chance < 0.003:
            happens.append(('service', random.choice(services)))
        elif chance < 0.006:
            sample = dataclasses.replace(sample, frame_id=random.choice(['imu', 'other_imu_link']))
        data = wire.encode_imu(sample)
        if 0.006 < chance < 0.012:
            data = spoiled(random, data)
        happens.append(('message', name, data))
        if values.get('heard') and chance > 0.999:
            turn = quaternion_from_euler(0.0, 0.0, random.uniform(-3.0, 3.0))
            heard = dataclasses.replace(sample, orientation=turn)
            happens.append(('message', COMPASS, wire.encode_imu(heard)))
    return happens


@pytest.fixture(scope='module', autouse=True)
def _kernels():
    pytest.importorskip('numba')
    IntegratorChain.compile()


@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize('values', CHAINS.values(), ids=CHAINS)
def test_the_kernel_makes_of_messages_what_the_stream_makes(values, seed):
    happens = traffic(values, seed, seconds=20.0, odd=0.005)
    found, expected = driven(values, happens), driven(values, happens, ready=False)
    assert found.chain.taken > 0.1 * len(happens)
    assert expected.chain.taken == 0
    assert_same(found.outputs, expected.outputs)


def test_a_compass_beside_it():
    values = {**CHAINS['pedometer and message'], 'heard': True}
    happens = traffic(values, 4, seconds=20.0, odd=0.0)
    found, expected = driven(values, happens), driven(values, happens, ready=False)
    assert found.chain.taken > 0.1 * len(happens)
    assert_same(found.outputs, expected.outputs)
    happens = traffic({**WALK, 'heard': True}, 4, seconds=20.0, odd=0.0)
    assert_same(driven(WALK, happens).outputs, driven(WALK, happens, ready=False).outputs)


def test_a_gap_may_wait_in_line():
    values = CHAINS['along the orientation']
    samples = recording(3, seconds=10.0, orientation=True, odd=0.0)
    samples[500:] = [
        dataclasses.replace(sample, stamp_ns=sample.stamp_ns + LONG_GAP_NS)
        for sample in samples[500:]
    ]
    happens = [('message', IMU, wire.encode_imu(sample)) for sample in samples]
    found, expected = driven(values, happens), driven(values, happens, ready=False)
    faults = [type(value).__name__ for name, value in found.outputs if name == FAULT]
    assert faults == ['GapError', 'GapError']  # of the integrator at once, of the walk later
    assert_same(found.outputs, expected.outputs)


@pytest.mark.parametrize('kind', ['pedometer', 'pedometer and message'])
def test_of_regular_messages_the_kernel_takes_all_once_levelled(kind):
    values = CHAINS[kind]
    name = IMU if 'gravity.attitude' in values else RAW
    samples = recording(0, seconds=20.0, gyro=True, orientation=name == IMU, odd=0.0)
    happens = [('message', name, wire.encode_imu(sample)) for sample in samples]
    found = driven(values, happens)
    names = [name for name, _ in found.outputs]
    assert names.count(ODOMETRY) > 0.9 * len(samples)
    assert found.chain.taken > len(samples) - 2 * WAIT - 60
    # The attitude of these messages swings, the force does not: so there is no rest.
    assert names.count(STATIONARY) > (4 if name == RAW else 0)
    assert STEPS in names
    assert not [value for name, value in found.outputs[100:] if name == FAULT]


def test_compiled_and_not_it_gives_the_same(monkeypatch):
    values = {**CHAINS['pedometer and message'], **CHAINS['euler, each']}
    happens = traffic(values, 5, seconds=10.0)
    compiled = driven(values, happens)
    for module in (
        live_integrator,
        kernel,
        messages,
        gravity,
        headings,
        integrator,
        resampler,
        bias_growth,
        columns,
    ):
        for key, value in vars(module).items():
            if hasattr(value, '__wrapped__'):
                monkeypatch.setattr(module, key, value.__wrapped__)
    plain = driven(values, happens)
    assert compiled.chain.taken == plain.chain.taken > 100
    assert_same(compiled.outputs, plain.outputs)


@pytest.mark.parametrize('values', NOT_SUITED.values(), ids=NOT_SUITED)
def test_what_there_is_no_kernel_for_goes_without(values):
    configuration = Configuration(values)
    mountings = (lambda _: None) if values.get('frames.mounting') == 'tf' else None
    assert live_chain(Pipeline(configuration, mountings=mountings), configuration) is None


def test_a_chain_with_more_stages_goes_without():
    configuration = Configuration({})
    assert live_chain(Pipeline(configuration), configuration)
    more = [{ODOMETRY: lambda _: []}]
    assert not live_chain(Pipeline(configuration, more), configuration)


def test_frames_of_the_odometry_are_those_of_the_settings():
    values = {**MESSAGE, 'frames.world': 'map', 'frames.body': 'a_longer_name'}
    samples = recording(1, seconds=2.0, orientation=True, odd=0.0)
    happens = [('message', IMU, wire.encode_imu(sample)) for sample in samples]
    found, expected = driven(values, happens), driven(values, happens, ready=False)
    assert found.chain.taken > 50
    assert_same(found.outputs, expected.outputs)
