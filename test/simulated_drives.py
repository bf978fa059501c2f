"""Drives of a simulated vehicle, whose road shakes the sensor."""

from dataclasses import dataclass

import numpy as np
from simulated_walks import START_NS, UP, Walk, blocks_of, measured, navigator

from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.stationarity import detector_class
from dead_reckoning.sources import motions

VEHICLE = {
    'nonholonomic': True, 'floor': False, 'height': 0.0, 'pivot': 0.0, 'acceleration_bias': 0.1,
    'window': 0.2, 'minimum': 0.2, 'look_ahead': 0.3, 'patience': 1e6,
}  # fmt: skip
"""Settings of the navigator for a vehicle."""

SHOE = detector_class('shoe').Settings(least=0.1, most=0.1)


@dataclass(frozen=True)
class Drive(Walk):
    """Columns of a drive, as those of a walk; position and velocity are those of the sensor."""

    @property
    def length(self):
        """Length of the way [m]."""
        return np.linalg.norm(np.diff(self.position, axis=0), axis=1).sum()

    def way(self, states):
        """Return the true positions of states, seen as a navigator does, with the first yaw 0."""
        stamps = START_NS + np.round(self.time * 1e9).astype(np.int64)
        forward = self.rotation[0, :2, 0]
        turn = np.array([forward, [-forward[1], forward[0]]])
        way = (self.position - self.position[0])[np.searchsorted(stamps, states.stamp_ns)]
        return np.column_stack([way[:, :2] @ turn.T, way[:, 2]])


def driven(rate=100.0, end=3.0, arm=(0.0, 0.0, 0.0), **settings):
    """Return a drive as a perfect sensor measures it, at ``arm`` [m] from the axle."""
    kind = motions.motion_class('vehicle')
    motion = kind(kind.Settings(**settings))
    time = np.arange(round((motion.duration + end) * rate)) / rate
    truth, arm = motion.at(time), np.array(arm)
    rotation, turn = truth.rotation, truth.angular_velocity
    swing = np.cross(turn, arm)
    pull = np.cross(np.gradient(turn, time, axis=0), arm) + np.cross(turn, swing)
    force = np.einsum('nij,ni->nj', rotation, truth.acceleration + UP) + pull
    position = truth.position + rotation @ arm
    velocity = truth.velocity + np.einsum('nij,nj->ni', rotation, swing)
    return Drive(time, force, turn, position, velocity, rotation)


def shaken(drive, seed, force=0.5, rate=0.02):
    """Return a drive as a sensor measures it that shakes at 2 m/s and above, [m/s²], [rad/s]."""
    moved = measured(drive, seed, force_bias=0.05, rate_bias=0.002)
    random = np.random.default_rng(1000 + seed)
    size = np.minimum(0.5 * np.linalg.norm(drive.velocity, axis=1), 1.0)[:, None]
    return Drive(
        drive.time, moved.force + size * random.normal(0.0, force, moved.force.shape),
        moved.rate + size * random.normal(0.0, rate, moved.rate.shape),
        drive.position, drive.velocity, drive.rotation,
    )  # fmt: skip


def navigated_drive(drive, seed, **settings):
    """Return navigator and states of a drive."""
    found = navigator(SHOE, **{**VEHICLE, **settings})
    blocks = blocks_of(found, shaken(drive, seed).block())
    return found, StateBlock.join([*blocks, StateBlock.of(found.flush())])
