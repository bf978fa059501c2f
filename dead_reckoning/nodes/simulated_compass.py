"""A compass on the body of the simulator."""

from __future__ import annotations

from dead_reckoning.core.chain import Chain
from dead_reckoning.core.compass import CompassSettings
from dead_reckoning.core.stages import COMPASS as HEADINGS
from dead_reckoning.core.stages import GROUND_TRUTH
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.sources.simulated_compass import (
    SimulatedCompass,
    SimulatedCompassSettings,
    compass_stage,
)


def connect(node: ChainNode) -> None:
    """Sit on the body that `ground_truth/odom` tells of.

    So it turns with the simulated accelerometer, whatever that does and whenever it starts.
    """
    settings = node.configuration[CompassSettings]
    compass = SimulatedCompass(node.configuration[SimulatedCompassSettings], settings)
    node.connect(
        Chain([compass_stage(compass, settings, node.frames.sensor)]),
        inputs=(GROUND_TRUTH,),
        outputs=(HEADINGS,),
    )
    node.offer('calibrate', compass.calibrate)
    node.show(lambda: {'offset': compass.offset})


COMPASS = connect
