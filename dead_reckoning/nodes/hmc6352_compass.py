"""An HMC6352 compass, on an I²C bus or in sysfs."""

from __future__ import annotations

from concurrent.futures import Future

from dead_reckoning.core.chain import Chain
from dead_reckoning.core.compass import Compass, CompassSettings
from dead_reckoning.core.errors import DeadReckoningError, DeviceError, SettingsError
from dead_reckoning.core.stages import COMPASS as HEADINGS
from dead_reckoning.core.work import Work
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.devices import DeviceReader, Taken
from dead_reckoning.sources.devices import Calibration, Heading
from dead_reckoning.sources.i2c.hmc6352 import Hmc6352, Hmc6352Settings


class Hmc6352Compass:
    """Publish the headings of an HMC6352, and let it calibrate itself."""

    def __init__(self, node: ChainNode) -> None:
        settings = node.configuration[Hmc6352Settings]
        compass = node.configuration[CompassSettings]
        if compass.calibration_time >= node.common.service_timeout:
            raise SettingsError(
                f'compass.calibration_time: {compass.calibration_time:g} s is not allowed, as no '
                'heading comes meanwhile, and common.service_timeout is '
                f'{node.common.service_timeout:g} s; raise that one, or lower this one'
            )
        self._node = node
        self._model = Compass(compass, node.frames.sensor)
        self._work = Work()
        open_bus = None
        if not settings.folder:
            from dead_reckoning.sources.i2c.bus import LinuxBus

            open_bus = LinuxBus
        self._source = Hmc6352(
            settings, compass, open_bus, lambda: node.get_clock().now().nanoseconds
        )
        node.connect(Chain([]), inputs=(), outputs=(HEADINGS,))
        node.offer('calibrate', self._calibrate)
        DeviceReader(
            node,
            f'hmc6352 at {settings.folder or f"/dev/i2c-{settings.bus}"}',
            self._source.session,
            self._take,
            self._lose,
            period=1.0 / compass.rate,
        )

    def _calibrate(self) -> Future[str]:
        self._source.calibrate()
        return self._work.begin()

    def _take(self, taken: Taken) -> None:
        if isinstance(taken, Heading):
            self._node.feed(HEADINGS, self._model.sample(taken.stamp_ns, taken.heading))
        elif isinstance(taken, Calibration) and taken.said:
            self._work.succeed(taken.said)

    def _lose(self, error: DeadReckoningError) -> None:
        if isinstance(error, DeviceError):
            self._source.abandon()
            self._work.fail(error)


COMPASS = Hmc6352Compass
