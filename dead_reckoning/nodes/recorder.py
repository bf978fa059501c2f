"""Node `recorder`: what the chain publishes, as lines of text on the standard output.

A line is ``topic stamp_ns`` and the numbers: position, velocity and deviation of position of an
Odometry; acceleration and its deviation of a linear acceleration; world frame, x, y, z each.  The
line ``ready`` says that the estimators are there and see each other's topics, so that a source may
start.
`dead_reckoning.tools` reads them, which knows nothing of ROS.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

from dead_reckoning.core.chain import Chain
from dead_reckoning.core.samples import LinearAcceleration, Matrix, NavigationState, Vector
from dead_reckoning.core.stages import ACCELERATION, GROUND_TRUTH, ODOMETRY
from dead_reckoning.nodes.chain_node import STEADY, ChainNode

READY = 'ready'
READY_PERIOD = 0.1


class Recorder(ChainNode):
    """Write a line for each linear acceleration, Odometry and ground truth."""

    def __init__(self) -> None:
        super().__init__('recorder', ())
        stage = {
            GROUND_TRUTH: _state_writer(GROUND_TRUTH),
            ODOMETRY: _state_writer(ODOMETRY),
            ACCELERATION: _write_acceleration,
        }
        self.connect(Chain([stage]), inputs=stage, outputs=())
        self._looking = self.create_timer(READY_PERIOD, self._look, clock=STEADY)

    def _look(self) -> None:
        """Say once that the estimators are there: they and this node listen to each other."""
        if self.count_subscribers_of(ACCELERATION) > 1 and self.count_publishers_of(ODOMETRY):
            self._looking.cancel()
            print(READY, flush=True)


def _state_writer(topic: str) -> Callable[[NavigationState], tuple[()]]:
    def write(state: NavigationState) -> tuple[()]:
        deviation = _deviation(state.position_covariance)
        _write(topic, state.stamp_ns, (*state.position, *state.velocity, *deviation))
        return ()

    return write


def _write_acceleration(sample: LinearAcceleration) -> tuple[()]:
    deviation = _deviation(sample.covariance)
    _write(ACCELERATION, sample.stamp_ns, (*sample.acceleration, *deviation))
    return ()


def _deviation(covariance: Matrix) -> Vector:
    return (sqrt(covariance[0]), sqrt(covariance[4]), sqrt(covariance[8]))


def _write(topic: str, stamp_ns: int, numbers: tuple[float, ...]) -> None:
    print(topic, stamp_ns, *numbers, flush=True)


NODE = Recorder
