"""The navigator on messages: what kernels make of them is what the stream makes of them."""

import dataclasses
from contextlib import suppress
from itertools import pairwise

import numpy as np
import pytest
from driven import assert_same, driven, spoiled
from random_recordings import GAP_NS, LONG_GAP_NS, RESTART_NS, made_odd
from simulated_walks import START_NS, measured, walk

from dead_reckoning import wire
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.chain import FAULT, NOTICE
from dead_reckoning.core.errors import WireError
from dead_reckoning.core.kernels import columns, headings, live, messages, resampler
from dead_reckoning.core.kernels.navigation import filter as navigation
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.samples import PoseSample, VelocitySample
from dead_reckoning.core.smoother import Smoother
from dead_reckoning.core.stages import (
    AIDING_ODOMETRY,
    AIDING_POSE,
    AIDING_TWIST,
    COMPASS,
    IMU,
    ODOMETRY,
    RAW,
    SET_POSE,
    STATIONARY,
    STEPS,
)
from dead_reckoning.live import live_chain
from dead_reckoning.live import navigator as live_navigator
from dead_reckoning.live.chain import WAIT
from dead_reckoning.live.navigator import NavigatorChain

NAVIGATOR = {'pipeline.estimators': ['inertial_navigator']}
WITH_STEPS = {'pipeline.estimators': ['inertial_navigator', 'pedometer']}

CHAINS = {
    'late': NAVIGATOR,
    'at once': {**NAVIGATOR, 'navigator.look_ahead': 0.0},
    'vote': {
        **NAVIGATOR,
        'navigator.detector': ['shoe', 'angular_rate', 'movement_end'],
        'navigator.votes': 2,
    },
    'all it knows': {
        **NAVIGATOR,
        'navigator.gravity_direction': True,
        'navigator.nonholonomic': True,
        'navigator.axle': [0.1, 0.0, -0.1],
        'navigator.force_range': 30.0,
    },
    'pedometer': WITH_STEPS,
    'pedometer along the orientation': {
        **WITH_STEPS,
        'gravity.attitude': 'message',
        'navigator.input': IMU,
        'pedometer.input': IMU,
        'pedometer.heading': 'orientation',
        'pedometer.max_gap': 0.05,
        'navigator.look_ahead': 0.0,
    },
}

WIDE = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)

NOT_SUITED = {
    'turned sensor': {'frames.mounting_rotation': [0.0, 0.1, 1.0]},
    'sensor off the origin': {'frames.mounting_translation': [0.1, 0.2, 0.3]},
    'transforms': {'frames.publish_tf': True},
    'a source of its own': {'pipeline.source': 'simulated'},
    'steps along it': {**WITH_STEPS, 'pedometer.heading': 'navigator'},
    'two inputs': {**WITH_STEPS, 'pedometer.input': IMU},
}


@pytest.fixture(scope='module', autouse=True)
def _kernels():
    pytest.importorskip('numba')
    NavigatorChain.compile()


def reset(driven):
    driven.pipeline.navigator.reset()


def level(driven):
    driven.pipeline.navigator.level()


def roll(driven):
    """Change what may change while it runs."""
    navigator = driven.pipeline.navigator
    changed = {'navigator.zero_rate': not navigator.settings.zero_rate, 'navigator.floor': False}
    navigator.configure(driven.configuration[NavigatorSettings].changed(changed))


def poison(driven):
    """Let it diverge."""
    driven.pipeline.navigator._state[layout.X_VELOCITY : layout.X_VELOCITY + 1] = np.nan


def look(driven):
    """See what /diagnostics shows."""
    navigator = driven.pipeline.navigator
    shown = (
        navigator.aligned,
        navigator.stationary,
        navigator.strides.count,
        tuple(navigator.counts.values()),
        navigator.restarts,
    )
    driven.outputs.append(('shown', shown))
    for figure in (navigator.statistic, navigator.strides.distance, *navigator.biases[0]):
        driven.outputs.append(('figure', float(figure)))


def imus(values, seed):
    """Return the samples of a foot that walks, rests, walks and rests."""
    random = np.random.default_rng(seed)
    block = measured(walk(strides=6), seed).block(START_NS)
    samples = [block.sample(k) for k in range(len(block))]
    if values.get('navigator.input') == IMU:
        turn = quaternion_from_euler(0.1, 0.0, random.uniform(-3.0, 3.0))
        samples = [
            dataclasses.replace(sample, orientation=turn, orientation_covariance=(1e-4,) * 9)
            for sample in samples
        ]
    length_ns = samples[-1].stamp_ns - samples[0].stamp_ns + 5_000_000
    return samples + [
        dataclasses.replace(sample, stamp_ns=sample.stamp_ns + length_ns) for sample in samples
    ]


def traffic(values, seed, odd=0.004, services=(reset, level, roll, look, look, look)):
    """Return what happens to a node: calls of `Driven`, in order."""
    random = np.random.default_rng(seed)
    name = values.get('navigator.input', RAW)
    late_ns, happens = 0, []
    samples = imus(values, seed)
    for index, sample in enumerate(samples):
        chance = random.random()
        if index == len(samples) // 2:
            late_ns -= RESTART_NS  # it goes back, and starts anew
        sample = dataclasses.replace(sample, stamp_ns=sample.stamp_ns + late_ns)
        if chance < 0.002 and index % 800 > 300:
            happens.append(('service', random.choice(services)))
        elif chance < 0.004:
            sample = dataclasses.replace(sample, frame_id=random.choice(['imu', 'other_imu']))
        elif chance < 0.004 + odd:
            made = made_odd(random, sample, True, sample.orientation is not None)
            shift_ns = made.stamp_ns - sample.stamp_ns
            if shift_ns != -RESTART_NS:
                sample = made
            if shift_ns in (GAP_NS, LONG_GAP_NS):
                late_ns += shift_ns
        data = wire.encode_imu(sample)
        if chance > 0.998:
            data = spoiled(random, data)
        happens.append(('message', name, data))
        if values.get('heard') and index % 10 == 0 and index % 1000 > 300:
            yaw = 0.3 + random.normal(0.0, 0.05)
            heard = dataclasses.replace(
                sample,
                stamp_ns=sample.stamp_ns + int(random.integers(-20_000_000, 20_000_000)),
                orientation=quaternion_from_euler(0.0, 0.0, yaw),
                orientation_covariance=(0.0025,) * 9,
            )
            happens.append(('message', COMPASS, wire.encode_imu(heard)))
    return happens


@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize('values', CHAINS.values(), ids=CHAINS)
def test_kernels_make_of_messages_what_the_stream_makes(values, seed):
    happens = traffic(values, seed)
    found, expected = driven(values, happens), driven(values, happens, ready=False)
    assert found.chain.taken > 0.15 * len(happens)
    assert expected.chain.taken == 0
    assert_same(found.outputs, expected.outputs)


@pytest.mark.parametrize('kind', ['late', 'at once', 'pedometer'])
def test_where_it_diverges_it_begins_anew(kind):
    happens = traffic(CHAINS[kind], 8, services=(poison,))
    found, expected = driven(CHAINS[kind], happens), driven(CHAINS[kind], happens, ready=False)
    assert found.chain.taken > 0.1 * len(happens)
    faults = [type(value).__name__ for name, value in found.outputs if name == FAULT]
    assert 'DivergedError' in faults
    assert_same(found.outputs, expected.outputs)


@pytest.mark.parametrize('kind', ['late', 'pedometer'])
def test_a_compass_comes_in_between(kind):
    """Its yaw is taken where it is, and its silence said; the Imu still go through kernels."""
    values = {**CHAINS[kind], 'heard': True, 'navigator.compass_timeout': 0.5}
    happens = traffic(values, 4, odd=0.0, services=(look,))
    found, expected = driven(values, happens), driven(values, happens, ready=False)
    assert found.chain.taken > 0.5 * len(happens)
    faults = {type(value).__name__ for name, value in found.outputs if name == FAULT}
    assert 'StaleCompassError' in faults
    assert found.pipeline.navigator.counts['compass'] > 50
    assert_same(found.outputs, expected.outputs)


@pytest.mark.parametrize('kind', ['late', 'at once', 'pedometer'])
def test_what_aids_comes_in_between(kind):
    """Early, late, too late or far ahead: it is taken or refused by the stamp of the last Imu."""
    random = np.random.default_rng(7)
    happens = []
    for call, *given in traffic(CHAINS[kind], 7, odd=0.0, services=(reset, level)):
        happens.append((call, *given))
        if call == 'message' and given[0] == RAW and random.random() < 0.1:
            with suppress(WireError):
                late = random.choice([-1.5, -0.02, 0.0, 0.003, 0.05, 0.4, 0.7])
                stamp_ns = wire.decode_imu(given[1]).stamp_ns - round(late * 1e9)
                velocity = VelocitySample(stamp_ns, 'odom', (1.0, 0.1, 0.0), WIDE)
                pose = PoseSample(stamp_ns, '', (1.0, 2.0, 0.0), WIDE, (0.0, 0.0, 0.0, 1.0), WIDE)
                name = random.choice([AIDING_TWIST, AIDING_ODOMETRY, AIDING_POSE, SET_POSE])
                sample = velocity if name in (AIDING_TWIST, AIDING_ODOMETRY) else pose
                if name == SET_POSE and random.random() < 0.5:
                    sample = dataclasses.replace(pose, stamp_ns=0)
                happens.append(('push', str(name), sample))
    found, expected = driven(CHAINS[kind], happens), driven(CHAINS[kind], happens, ready=False)
    assert found.chain.taken > 0.3 * len(happens)
    counts = found.pipeline.navigator.counts
    assert min(counts['placed'], counts['aiding_twist'], counts['aiding_odom']) > 3
    assert_same(found.outputs, expected.outputs)


def test_what_is_recorded_can_be_smoothed():
    happens = traffic(NAVIGATOR, 5, services=(look,))
    ways = []
    for ready in (True, False):
        smoothers = []
        begin = (
            'service',
            lambda driven, s=smoothers: s.append(Smoother(driven.pipeline.navigator)),
        )
        driven(NAVIGATOR, [begin, *happens], ready)
        ways.append(list(smoothers[0].blocks()))
    found, expected = (np.concatenate([block.position for block in way]) for way in ways)
    assert len(found) > 0.8 * len(happens)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize('kind', ['late', 'pedometer'])
def test_of_regular_messages_kernels_take_all_once_aligned(kind):
    values = CHAINS[kind]
    samples = imus(values, 1)
    happens = [('message', RAW, wire.encode_imu(sample)) for sample in samples]
    found = driven(values, happens)
    names = [name for name, _ in found.outputs]
    assert found.chain.taken > len(samples) - 2 * WAIT - 150
    assert names.count(STATIONARY) > 12
    assert names.count(NOTICE) == 1
    assert kind == 'late' or STEPS in names
    assert names.count(ODOMETRY) > len(samples) - 150
    stamps = [
        wire.decode_odometry(data).stamp_ns for name, data in found.outputs if name == ODOMETRY
    ]
    steps = {after - before for before, after in pairwise(stamps)}
    assert max(steps) - min(steps) <= 1, 'one Odometry for each Imu, with its stamp'


def test_compiled_and_not_it_gives_the_same(monkeypatch):
    values = CHAINS['pedometer along the orientation']
    happens = traffic(values, 6)[:900]
    compiled = driven(values, happens)
    for module in (live_navigator, live, messages, navigation, headings, resampler, columns):
        for key, value in vars(module).items():
            if hasattr(value, '__wrapped__') and value.__name__ != 'navigate':
                monkeypatch.setattr(module, key, value.__wrapped__)
    plain = driven(values, happens)
    assert compiled.chain.taken == plain.chain.taken > 100
    assert_same(compiled.outputs, plain.outputs)


@pytest.mark.parametrize('values', NOT_SUITED.values(), ids=NOT_SUITED)
def test_what_there_is_no_kernel_for_goes_without(values):
    configuration = Configuration({**NAVIGATOR, **values})
    assert live_chain(Pipeline(configuration), configuration) is None
