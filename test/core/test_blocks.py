"""Blocks: from samples and back, and stages that take them."""

import numpy as np

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.block_stages import blockwise
from dead_reckoning.core.blocks import ImuBlock, StateBlock
from dead_reckoning.core.chain import FAULT, Chain
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.samples import ImuSample, NavigationState
from dead_reckoning.core.stages import ODOMETRY, RAW, gravity_stage, integrator_stage

START_NS = 1_700_000_000_000_000_000


def imu(index, force=(0.1, -0.2, 9.8), **values):
    return ImuSample(START_NS + index * 10_000_000, 'imu_link', force, **values)


def test_block_gives_its_samples_back():
    measured = imu(
        1,
        angular_velocity=(0.1, 0.2, 0.3),
        angular_velocity_covariance=tuple(np.eye(3).ravel().tolist()),
        orientation=(0.0, 0.0, 0.6, 0.8),
    )
    samples = [imu(0), measured, imu(2)]
    block = ImuBlock.of(samples)
    assert repr([block.sample(k) for k in range(3)]) == repr(samples)
    assert repr(block.part(1, 3).sample(0)) == repr(measured)
    states = [NavigationState(START_NS, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3), stationary=True)]
    assert repr(StateBlock.of(states).sample(0)) == repr(states[0])


def stages():
    parts = Configuration({})
    removal = GravityRemoval(parts[GravitySettings], parts[CommonSettings], parts[FrameSettings])
    integrator = Integrator(parts[IntegratorSettings], parts[CommonSettings])
    return [gravity_stage(removal), integrator_stage(integrator)]


def test_chain_over_blocks_gives_what_it_gives_sample_by_sample():
    random = np.random.default_rng(3)
    samples = [imu(k, tuple(random.normal((0.1, 0.0, 9.8), 0.1).tolist())) for k in range(300)]
    samples[100] = imu(100, (float('nan'), 0.0, 9.8))
    samples[200] = imu(150)
    alone = Chain(stages())
    outputs = [output for sample in samples for output in alone.push(RAW, sample)]
    together = Chain([blockwise(stage) for stage in stages()])
    blocks = together.push(RAW, ImuBlock.of(samples))
    found = [block for name, block in blocks if name == ODOMETRY]
    assert [repr(b.sample(k)) for b in found for k in range(len(b))] == [
        repr(state) for name, state in outputs if name == ODOMETRY
    ]
    faults = [value for name, value in blocks if name == FAULT]
    expected = [value for name, value in outputs if name == FAULT]
    assert [repr(fault.value) for fault in faults] == [repr(fault) for fault in expected]
    assert START_NS + 100 * 10_000_000 in [fault.stamp_ns for fault in faults]
