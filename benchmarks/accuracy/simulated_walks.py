"""Walks of a simulated foot, through a simulated sensor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.blocks import ImuBlock
from dead_reckoning.core.samples import NANOSECONDS, NOT_MEASURED
from dead_reckoning.sources import motions

Array = NDArray[np.float64]

START_NS = 1_700_000_000_000_000_000
GRAVITY = 9.81
UP = np.array([0.0, 0.0, GRAVITY])
"""Specific force at rest [m/s²]."""

MOUNTED = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
"""Rotation of a sensor that sits on the foot at random."""


@dataclass(frozen=True)
class Walk:
    """Columns of a walk, (n, …): time [s], force and rate of the sensor; the truth in the world.

    ``rotation`` takes the sensor into the world.
    """

    time: Array
    force: Array
    rate: Array
    position: Array
    velocity: Array
    rotation: Array

    def block(self, start_ns: int = START_NS) -> ImuBlock:
        """Return the samples as a block."""
        n = len(self.time)
        unknown = np.zeros((n, 9))
        return ImuBlock(
            start_ns + np.round(self.time * NANOSECONDS).astype(np.int64),
            'imu_link',
            self.force.copy(),
            unknown,
            self.rate.copy(),
            unknown,
            np.zeros((n, 4)),
            np.tile(NOT_MEASURED, (n, 1)),
        )


def walk(rate: float = 200.0, end: float = 3.0, mounted: Array = MOUNTED, **gait: Any) -> Walk:
    """Return a walk as a perfect sensor measures it, ``end`` [s] of rest after it.

    ``gait`` are settings of the motion.
    """
    kind: Any = motions.motion_class('gait')
    motion = kind(kind.Settings(**gait))
    time = np.arange(round((motion.duration + end) * rate)) / rate
    truth = motion.at(time)
    rotation = truth.rotation @ mounted
    force = np.einsum('nij,ni->nj', rotation, truth.acceleration + UP)
    turn = truth.angular_velocity @ mounted
    return Walk(time, force, turn, truth.position, truth.velocity, rotation)


def joined(*walks: Walk) -> Walk:
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


def measured(
    walk: Walk,
    seed: int,
    force_noise: float = 0.01,
    rate_noise: float = 3e-4,
    force_bias: float | Sequence[float] = 0.1,
    rate_bias: float = 0.0035,
    scale: float = 0.003,
) -> Walk:
    """Return a walk as a sensor with noise densities, biases and errors of scale measures it.

    All are one sigma: [m/s²/√Hz], [rad/s/√Hz], [m/s²] of all axes or each, [rad/s], of 1.
    """
    random = np.random.default_rng(seed)
    density = np.sqrt(len(walk.time) / walk.time[-1])
    force = walk.force * (1.0 + random.normal(0.0, scale)) + random.normal(0.0, force_bias, 3)
    rate = walk.rate * (1.0 + random.normal(0.0, scale)) + random.normal(0.0, rate_bias, 3)
    force += random.normal(0.0, force_noise * density, force.shape)
    rate += random.normal(0.0, rate_noise * density, rate.shape)
    return replace(walk, force=force, rate=rate)
