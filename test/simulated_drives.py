"""Drives of a simulated vehicle, whose road shakes the sensor."""

import numpy as np
from simulated_walks import START_NS, Walk, blocks_of, measured, navigator

from benchmarks.accuracy.simulated_drives import driven, from_its_start
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.stationarity import detector_class

__all__ = ['VEHICLE', 'driven', 'length', 'navigated_drive', 'shaken', 'way']

VEHICLE = {
    'nonholonomic': True, 'floor': False, 'height': 0.0, 'pivot': 0.0, 'acceleration_bias': 0.1,
    'window': 0.2, 'minimum': 0.2, 'look_ahead': 0.3, 'patience': 1e6,
}  # fmt: skip
"""Settings of the navigator for a vehicle."""

SHOE = detector_class('shoe').Settings(least=0.1, most=0.1)


def length(drive):
    """Return the length of the way [m]."""
    return np.linalg.norm(np.diff(drive.position, axis=0), axis=1).sum()


def way(drive, states):
    """Return the true positions of states, seen as a navigator does."""
    stamps = START_NS + np.round(drive.time * 1e9).astype(np.int64)
    return from_its_start(drive).position[np.searchsorted(stamps, states.stamp_ns)]


def shaken(drive, seed, force=0.5, rate=0.02):
    """Return a drive as a sensor measures it that shakes at 2 m/s and above, [m/s²], [rad/s]."""
    moved = measured(drive, seed, force_bias=0.05, rate_bias=0.002)
    random = np.random.default_rng(1000 + seed)
    size = np.minimum(0.5 * np.linalg.norm(drive.velocity, axis=1), 1.0)[:, None]
    return Walk(
        drive.time, moved.force + size * random.normal(0.0, force, moved.force.shape),
        moved.rate + size * random.normal(0.0, rate, moved.rate.shape),
        drive.position, drive.velocity, drive.rotation,
    )  # fmt: skip


def navigated_drive(drive, seed, **settings):
    """Return navigator and states of a drive."""
    found = navigator(SHOE, **{**VEHICLE, **settings})
    blocks = blocks_of(found, shaken(drive, seed).block())
    return found, StateBlock.join([*blocks, StateBlock.of(found.flush())])
