"""Node `compass_driver`: a compass's headings as sensor_msgs/Imu."""

from __future__ import annotations

from dead_reckoning.configuration import COMPASS as PARTS
from dead_reckoning.core.chain import Chain
from dead_reckoning.core.compass import CompassSettings
from dead_reckoning.core.stages import COMPASS, GROUND_TRUTH
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.sources.simulated_compass import (
    SimulatedCompass,
    SimulatedCompassSettings,
    compass_stage,
)


class CompassDriver(ChainNode):
    """Publish `compass/data`.

    A simulated compass sits on the body that `ground_truth/odom` tells of, so it turns with the
    simulated accelerometer, whatever that does and whenever it starts.
    """

    def __init__(self) -> None:
        super().__init__('compass_driver', PARTS)
        settings = self.configuration[CompassSettings]
        compass = SimulatedCompass(self.configuration[SimulatedCompassSettings], settings)
        self.connect(
            Chain([compass_stage(compass, settings, self.frames.sensor)]),
            inputs=(GROUND_TRUTH,),
            outputs=(COMPASS,),
        )
        self.offer('calibrate', compass.calibrate)
        self.show(lambda: {'offset': compass.offset})


NODE = CompassDriver
