"""Drives of a simulated vehicle, whose road shakes the sensor."""

import numpy as np
from simulated_walks import START_NS, blocks_of, navigator

from benchmarks.accuracy.simulated_drives import VEHICLE, driven, from_its_start, shaken
from dead_reckoning.core.blocks import StateBlock

__all__ = ['VEHICLE', 'driven', 'length', 'navigated_drive', 'shaken', 'way']


def length(drive):
    """Return the length of the way [m]."""
    return np.linalg.norm(np.diff(drive.position, axis=0), axis=1).sum()


def way(drive, states):
    """Return the true positions of states, seen as a navigator does."""
    stamps = START_NS + np.round(drive.time * 1e9).astype(np.int64)
    return from_its_start(drive).position[np.searchsorted(stamps, states.stamp_ns)]


def navigated_drive(drive, seed, shaking=1.0, **settings):
    """Return navigator and states of a drive, with so many times the shaking."""
    found = navigator(**{**VEHICLE, **settings})
    blocks = blocks_of(found, shaken(drive, seed, 0.5 * shaking, 0.02 * shaking).block())
    return found, StateBlock.join([*blocks, StateBlock.of(found.flush())])
