"""Read an accelerometer that a driver of the Linux kernel reads."""

from __future__ import annotations

from dead_reckoning.configuration import Configuration
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.driver import DeviceDriver
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.iio.device import Iio
from dead_reckoning.sources.iio.settings import IioSettings


class IioDriver(DeviceDriver):
    """Feed a node with the samples of an industrial-I/O accelerometer, whatever happens to it."""

    def __init__(self, node: ChainNode, configuration: Configuration) -> None:
        super().__init__(node, configuration)
        settings = configuration[IioSettings]
        device = Iio(
            settings,
            configuration[DriverSettings].model(),
            lambda: node.get_clock().now().nanoseconds,
        )
        self.read(f'iio device {settings.device}', device.session, settings.rate)


DRIVER = IioDriver
