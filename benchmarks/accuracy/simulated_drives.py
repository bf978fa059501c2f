"""Drives of a simulated vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.accuracy.simulated_walks import UP, Array, Walk, measured
from dead_reckoning.sources import motions

VEHICLE: dict[str, Any] = {
    'nonholonomic': True, 'floor': False, 'height': 0.0, 'pivot': 0.0, 'acceleration_bias': 0.1,
    'window': 0.3, 'minimum': 0.15, 'look_ahead': 0.3, 'patience': 1e6,
}  # fmt: skip
"""Settings of the navigator itself for a vehicle: docs/navigation.md."""


def driven(
    rate: float = 100.0, end: float = 3.0, arm: Sequence[float] = (0.0, 0.0, 0.0), **vehicle: Any
) -> Walk:
    """Return a drive as a perfect sensor measures it, at ``arm`` [m] from the axle.

    ``rate`` [Hz]; it ends with a rest of ``end`` [s]; ``vehicle`` are settings of the motion.
    Position and velocity are those of the sensor.
    """
    kind = motions.motion_class('vehicle')
    motion = kind(kind.Settings(**vehicle))
    time: Array = np.arange(round((motion.duration + end) * rate)) / rate
    truth, lever = motion.at(time), np.array(arm)
    rotation, turn = truth.rotation, truth.angular_velocity
    swing = np.cross(turn, lever)
    pull = np.cross(np.gradient(turn, time, axis=0), lever) + np.cross(turn, swing)
    force = np.einsum('nij,ni->nj', rotation, truth.acceleration + UP) + pull
    position = truth.position + rotation @ lever
    velocity = truth.velocity + np.einsum('nij,nj->ni', rotation, swing)
    return Walk(time, force, turn, position, velocity, rotation)


def from_its_start(drive: Walk) -> Walk:
    """Return a drive as a navigator sees it, whose first position and yaw are 0."""
    x, y, _ = drive.rotation[0, :, 0]
    turn = np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])
    return Walk(
        drive.time,
        drive.force,
        drive.rate,
        (drive.position - drive.position[0]) @ turn.T,
        drive.velocity @ turn.T,
        turn @ drive.rotation,
    )


def shaken(
    drive: Walk, seed: int, force: float = 0.5, rate: float = 0.02, **sensor: float
) -> Walk:
    """Return a drive as a sensor measures it that shakes at 2 m/s and above, [m/s²], [rad/s].

    ``sensor`` is as `measured` has it.
    """
    moved = measured(drive, seed, **{'force_bias': 0.05, 'rate_bias': 0.002, **sensor})
    random = np.random.default_rng(1000 + seed)
    size = np.minimum(0.5 * np.linalg.norm(drive.velocity, axis=1), 1.0)[:, None]
    return replace(
        moved,
        force=moved.force + size * random.normal(0.0, force, moved.force.shape),
        rate=moved.rate + size * random.normal(0.0, rate, moved.rate.shape),
    )
