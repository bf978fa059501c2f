"""Drives of a simulated vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.accuracy.simulated_walks import UP, Array, Walk
from dead_reckoning.sources import motions


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
