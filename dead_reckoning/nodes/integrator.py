"""Node `integrator`: Odometry from linear acceleration."""

from __future__ import annotations

from dead_reckoning.core.chain import Chain
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.stages import (
    ACCELERATION,
    IMU,
    ODOMETRY,
    STATIONARY,
    integrator_stage,
    pairing_stage,
)
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.transforms import mountings


class IntegratorNode(ChainNode):
    """Take `imu/linear_acceleration` and `imu/data`, publish `odom` and `stationary`."""

    def __init__(self) -> None:
        super().__init__('integrator', (IntegratorSettings,))
        integrator = Integrator(self.configuration[IntegratorSettings], self.common)
        self.connect(
            Chain([pairing_stage(), integrator_stage(integrator, mountings(self, self.frames))]),
            inputs=(ACCELERATION, IMU),
            outputs=(ODOMETRY, STATIONARY),
        )
        serve(self, integrator)


def serve(node: ChainNode, integrator: Integrator) -> None:
    """Give a node the services and the changeable parameters of an integrator."""

    def reset() -> str:
        integrator.reset()
        return 'position and velocity are zero'

    node.offer('reset', reset)
    node.offer('calibrate', integrator.calibrate)
    node.follow(integrator.settings, integrator.configure)


NODE = IntegratorNode
