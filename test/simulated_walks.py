"""Walks of a simulated foot through a simulated sensor, and navigators that take them."""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from dead_reckoning.core.batch.navigator import navigator_run
from dead_reckoning.core.blocks import ImuBlock, StateBlock
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import NotLevelledError, SampleError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.kernels.navigation.filter import navigate
from dead_reckoning.core.navigation.aids import NO_AIDS
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.samples import NOT_MEASURED
from dead_reckoning.core.smoother import LARGEST_LOG
from dead_reckoning.sources import motions

START_NS = 1_700_000_000_000_000_000
GRAVITY = 9.81
UP = np.array([0.0, 0.0, GRAVITY])

MOUNTED = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
"""Rotation of a sensor that sits on the foot at random."""


@dataclass(frozen=True)
class Walk:
    """Columns of a walk: time [s], force and rate of the sensor, and the truth."""

    time: np.ndarray
    force: np.ndarray
    rate: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    rotation: np.ndarray

    def block(self, start_ns=START_NS):
        """Return the samples as a block."""
        n = len(self.time)
        unknown = np.zeros((n, 9))
        return ImuBlock(
            start_ns + np.round(self.time * 1e9).astype(np.int64), 'imu_link',
            self.force.copy(), unknown, self.rate.copy(), unknown,
            np.zeros((n, 4)), np.tile(NOT_MEASURED, (n, 1)),
        )  # fmt: skip


def walk(rate=200.0, end=3.0, mounted=MOUNTED, **gait):
    """Return a walk as a perfect sensor measures it, ``end`` [s] of rest after it."""
    kind = motions.motion_class('gait')
    motion = kind(kind.Settings(**gait))
    time = np.arange(round((motion.duration + end) * rate)) / rate
    truth = motion.at(time)
    rotation = truth.rotation @ mounted
    force = np.einsum('nij,ni->nj', rotation, truth.acceleration + UP)
    turn = truth.angular_velocity @ mounted
    return Walk(time, force, turn, truth.position, truth.velocity, rotation)


def joined(*walks):
    """Return walks, each of which begins as the one before ends, as one."""
    time, position = [walks[0].time], [walks[0].position]
    for each in walks[1:]:
        time.append(time[-1][-1] + each.time[1] + each.time)
        position.append(position[-1][-1] + each.position)
    columns = [
        np.concatenate([getattr(each, name) for each in walks])
        for name in ('force', 'rate', 'velocity', 'rotation')
    ]
    force, rate, velocity, rotation = columns
    return Walk(np.concatenate(time), force, rate, np.concatenate(position), velocity, rotation)


def measured(walk, seed, force_noise=0.01, rate_noise=3e-4, force_bias=0.1, rate_bias=0.0035):
    """Return a walk as a sensor with noise densities, biases and 0.3 % of scale measures it."""
    random = np.random.default_rng(seed)
    density = np.sqrt(len(walk.time) / walk.time[-1])
    force = walk.force * (1.0 + random.normal(0.0, 0.003)) + random.normal(0.0, force_bias, 3)
    rate = walk.rate * (1.0 + random.normal(0.0, 0.003)) + random.normal(0.0, rate_bias, 3)
    force += random.normal(0.0, force_noise * density, force.shape)
    rate += random.normal(0.0, rate_noise * density, rate.shape)
    return Walk(walk.time, force, rate, walk.position, walk.velocity, walk.rotation)


def navigator(*of_detectors, **settings):
    return InertialNavigator(NavigatorSettings(**settings), CommonSettings(), *of_detectors)


def filtered(rules, state, samples, verdicts, aids=NO_AIDS):
    """Let the filter take samples, shape (n, ROW); return its rows, trace and log."""
    n = len(samples)
    out, trace = np.zeros((n, layout.STATE_ROW)), np.zeros((n, layout.TRACE_ROW))
    log = np.zeros((LARGEST_LOG * n, layout.LOG_ROW))
    done = navigate(samples, verdicts, aids, rules, state, out, trace, log)
    return out[:done], trace[:done], log


def streamed(found, block):
    """Return the states that a navigator gives for a block, sample by sample, to the end."""
    states = []
    for index in range(len(block)):
        try:
            states += found.update(block.sample(index))
        except NotLevelledError:
            assert not found.aligned
    states += found.flush()
    return StateBlock.of(states)


def blocks_of(found, block):
    """Return what a navigator gives for a block, in blocks; faults and odd samples one by one."""
    run, blocks, begin = navigator_run(found), [], 0
    while begin < len(block):
        count, outputs = run(block, begin)
        blocks += [states for _, states in outputs]
        begin += count
        if not count:
            with suppress(SampleError):
                states = found.update(block.sample(begin))
                blocks += [StateBlock.of(states)] if states else []
            begin += 1
    return blocks
