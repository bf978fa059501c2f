"""Read an ADXL345 on an I²C bus."""

from __future__ import annotations

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.driver import DeviceDriver
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.i2c.adxl345 import Adxl345, I2cSettings
from dead_reckoning.sources.i2c.bus import LinuxBus


class I2CDriver(DeviceDriver):
    """Feed a node with the samples of an ADXL345, whatever happens to its bus."""

    def __init__(self, node: ChainNode, configuration: Configuration) -> None:
        super().__init__(node, configuration)
        driver, settings = configuration[DriverSettings], configuration[I2cSettings]
        if driver.sensor != 'adxl345':
            raise SettingsError(
                f'driver.sensor: {driver.sensor} is none that driver.source i2c reads; set it to '
                'adxl345'
            )
        sensor = Adxl345(
            settings, driver.range_g, LinuxBus, lambda: node.get_clock().now().nanoseconds
        )
        self.read(f'adxl345 on /dev/i2c-{settings.bus}', sensor.session, settings.rate)


DRIVER = I2CDriver
