"""Walks of a simulated foot through a simulated sensor, and navigators that take them."""

from contextlib import suppress

import numpy as np

from benchmarks.accuracy.simulated_walks import (
    GRAVITY,
    MOUNTED,
    START_NS,
    UP,
    Walk,
    joined,
    measured,
    walk,
)
from dead_reckoning.core.batch.navigator import navigator_run
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import NotLevelledError, SampleError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.kernels.navigation.filter import navigate
from dead_reckoning.core.navigation.aids import NO_AIDS
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.smoother import LARGEST_LOG

__all__ = [
    'GRAVITY', 'MOUNTED', 'START_NS', 'UP', 'Walk', 'blocks_of', 'filtered', 'joined',
    'measured', 'navigator', 'streamed', 'walk',
]  # fmt: skip


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
