"""Node `accelerometer_driver`: an accelerometer's samples as sensor_msgs/Imu."""

from __future__ import annotations

from dead_reckoning.configuration import DRIVER
from dead_reckoning.core.chain import Chain
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.driver import driver_of


class AccelerometerDriver(ChainNode):
    """Publish `imu/data_raw`, and of a simulated sensor `ground_truth/odom`.

    A board that measures its attitude publishes `imu/data` instead, one that sends positions
    `an3397/odom`.
    """

    def __init__(self) -> None:
        super().__init__('accelerometer_driver', DRIVER)
        driver = driver_of(self.configuration)
        self.connect(Chain([]), inputs=(), outputs=driver.outputs(self.configuration))
        self.driver = driver(self, self.configuration)


NODE = AccelerometerDriver
