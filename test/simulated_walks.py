"""Walks of a simulated foot through a simulated sensor, and navigators that take them."""

from benchmarks.accuracy.simulated_walks import (
    MOUNTED,
    START_NS,
    UP,
    Walk,
    joined,
    measured,
    walk,
)
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import NotLevelledError
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigator import InertialNavigator

__all__ = [
    'MOUNTED', 'START_NS', 'UP', 'Walk', 'joined', 'measured', 'navigator', 'streamed', 'walk',
]  # fmt: skip


def navigator(of_detector=None, **settings):
    return InertialNavigator(NavigatorSettings(**settings), CommonSettings(), of_detector)


def streamed(filtered, block):
    """Return the states that a navigator gives for a block, sample by sample, to the end."""
    states = []
    for index in range(len(block)):
        try:
            states += filtered.update(block.sample(index))
        except NotLevelledError:
            assert not filtered.aligned
    states += filtered.flush()
    return StateBlock.of(states)
