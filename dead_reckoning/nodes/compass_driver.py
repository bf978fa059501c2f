"""Node `compass_driver`: a compass's headings as sensor_msgs/Imu."""

from __future__ import annotations

from importlib import import_module

from dead_reckoning.configuration import COMPASS as PARTS
from dead_reckoning.core.compass import CompassSettings
from dead_reckoning.nodes.chain_node import ChainNode


class CompassDriver(ChainNode):
    """Publish `compass/data`, as the ``COMPASS`` of the module named by `compass.source` does."""

    def __init__(self) -> None:
        super().__init__('compass_driver', PARTS)
        source = self.configuration[CompassSettings].source
        self.compass = import_module(f'dead_reckoning.nodes.{source}_compass').COMPASS(self)


NODE = CompassDriver
