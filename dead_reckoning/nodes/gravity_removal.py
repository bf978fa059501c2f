"""Node `gravity_removal`: linear acceleration in the world from an Imu and its attitude."""

from __future__ import annotations

from dead_reckoning.core.chain import Chain
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.stages import ACCELERATION, COMPASS, IMU, gravity_inputs, gravity_stage
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.transforms import mountings


class GravityRemovalNode(ChainNode):
    """Publish `imu/linear_acceleration`, and `imu/data` with the attitude where it lacks one.

    Takes `imu/data`, or `imu/data_raw` and `compass/data`.
    """

    def __init__(self) -> None:
        super().__init__('gravity_removal', (GravitySettings,))
        settings = self.configuration[GravitySettings]
        removal = GravityRemoval(settings, self.common, self.frames)
        self.connect(
            Chain([gravity_stage(removal, mountings(self, self.frames))]),
            inputs=gravity_inputs(settings.attitude),
            outputs=(ACCELERATION,) if settings.attitude == 'message' else (IMU, ACCELERATION),
            optional=(COMPASS,),
        )
        serve(self, removal)


def serve(node: ChainNode, removal: GravityRemoval) -> None:
    """Give a node the service and the figures of a gravity removal."""
    node.offer('level', removal.level)
    node.show(lambda: {'levelled': removal.levelled or 'not yet'})


NODE = GravityRemovalNode
