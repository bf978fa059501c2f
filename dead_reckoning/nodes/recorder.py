"""Node `recorder`: what the nodes publish, as lines of text on the standard output.

A line is ``topic stamp_ns`` and the numbers: position, velocity and deviation of position of an
Odometry; acceleration and its deviation of a linear acceleration; world frame, x, y, z each; steps
and distance walked, which carry no stamp, with that of the latest truth.  A line ``ends topic n``
says how many publishers and subscribers a topic has now, so that a source may start when all have
found each other.
`dead_reckoning.tools` reads them, which knows nothing of ROS.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

from dead_reckoning.core.chain import Chain
from dead_reckoning.core.samples import LinearAcceleration, Matrix, NavigationState, Vector
from dead_reckoning.core.stages import (
    ACCELERATION,
    COMPASS,
    DISTANCE,
    GROUND_TRUTH,
    ODOMETRY,
    STEP_ODOMETRY,
    STEPS,
)
from dead_reckoning.nodes.chain_node import STEADY, ChainNode

ENDS = 'ends'
LOOK_PERIOD = 0.1


class Recorder(ChainNode):
    """Write a line for each message of the truth and of the estimates."""

    def __init__(self) -> None:
        super().__init__('recorder', ())
        self._latest_ns = 0
        stage = {
            GROUND_TRUTH: self._write_truth,
            ODOMETRY: _state_writer(ODOMETRY),
            STEP_ODOMETRY: _state_writer(STEP_ODOMETRY),
            ACCELERATION: _write_acceleration,
            STEPS: self._total_writer(STEPS),
            DISTANCE: self._total_writer(DISTANCE),
        }
        self.connect(Chain([stage]), inputs=stage, outputs=(), optional=stage)
        self._ends = dict.fromkeys((*stage, COMPASS), 0)
        self.create_timer(LOOK_PERIOD, self._look, clock=STEADY)

    def _look(self) -> None:
        for topic, before in self._ends.items():
            now = self.count_publishers_of(topic) + self.count_subscribers_of(topic)
            if now != before:
                self._ends[topic] = now
                print(ENDS, topic, now, flush=True)

    def _write_truth(self, state: NavigationState) -> tuple[()]:
        self._latest_ns = max(self._latest_ns, state.stamp_ns)
        return _write_state(GROUND_TRUTH, state)

    def _total_writer(self, topic: str) -> Callable[[float], tuple[()]]:
        def write(total: float) -> tuple[()]:
            _write(topic, self._latest_ns, (total,))
            return ()

        return write


def _state_writer(topic: str) -> Callable[[NavigationState], tuple[()]]:
    return lambda state: _write_state(topic, state)


def _write_state(topic: str, state: NavigationState) -> tuple[()]:
    deviation = _deviation(state.position_covariance)
    _write(topic, state.stamp_ns, (*state.position, *state.velocity, *deviation))
    return ()


def _write_acceleration(sample: LinearAcceleration) -> tuple[()]:
    deviation = _deviation(sample.covariance)
    _write(ACCELERATION, sample.stamp_ns, (*sample.acceleration, *deviation))
    return ()


def _deviation(covariance: Matrix) -> Vector:
    return (sqrt(covariance[0]), sqrt(covariance[4]), sqrt(covariance[8]))


def _write(topic: str, stamp_ns: int, numbers: tuple[float, ...]) -> None:
    print(topic, stamp_ns, *numbers, flush=True)


NODE = Recorder
