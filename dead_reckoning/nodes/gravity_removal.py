"""Node `gravity_removal`: linear acceleration in the world from an Imu and its attitude."""

from __future__ import annotations

from dead_reckoning.core.chain import Chain
from dead_reckoning.core.gravity import GravityRemoval, GravitySettings
from dead_reckoning.core.stages import ACCELERATION, IMU, RAW, gravity_input, gravity_stage
from dead_reckoning.nodes.chain_node import ChainNode


class GravityRemovalNode(ChainNode):
    """Take `imu/data` or `imu/data_raw`, publish `imu/linear_acceleration` and the attitude."""

    def __init__(self) -> None:
        super().__init__('gravity_removal', (GravitySettings,))
        settings = self.configuration[GravitySettings]
        removal = GravityRemoval(settings, self.common, self.frames)
        taken = gravity_input(settings.attitude)
        self.connect(
            Chain([gravity_stage(removal)]),
            inputs=(taken,),
            outputs=(IMU, ACCELERATION) if taken == RAW else (ACCELERATION,),
        )
        serve(self, removal)


def serve(node: ChainNode, removal: GravityRemoval) -> None:
    """Give a node the service and the figures of a gravity removal."""
    node.offer('level', removal.level)
    node.show(lambda: {'levelled': removal.levelled or 'not yet'})


NODE = GravityRemovalNode
