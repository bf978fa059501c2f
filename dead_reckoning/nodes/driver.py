"""What drivers share, wherever their samples come from, and the choice between them."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.errors import DeadReckoningError
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.samples import ImuSample
from dead_reckoning.core.stages import RAW
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.devices import DeviceReader, Taken
from dead_reckoning.sources.devices import Session
from dead_reckoning.sources.driver import front_end
from dead_reckoning.sources.driver_settings import DriverSettings


class Driver:
    """Feed a node with the samples that the front end makes of a source's conversions.

    A subclass finds the conversions and puts them through `deliver`.
    """

    def __init__(self, node: ChainNode, configuration: Configuration) -> None:
        self._node = node
        self._configuration = configuration
        self._output = self.outputs(configuration)[0]
        self.front_end = front_end(configuration)
        node.offer('calibrate', lambda: self.front_end.calibrate())
        node.show(self.figures)

    @classmethod
    def outputs(cls, configuration: Configuration) -> tuple[str, ...]:
        """Name the topics it feeds, that of its samples first."""
        return (RAW,)

    def figures(self) -> Mapping[str, object]:
        """Return what /diagnostics shows."""
        return {
            'clipped_conversions': self.front_end.clipped,
            'saturated_rates': self.front_end.saturated,
        }

    def deliver(self, conversions: Conversions) -> None:
        """Feed the samples that conversions complete; say it if the calibration has failed."""
        for sample in self.front_end.add(conversions):
            self.feed(sample)
        finding, self.front_end.finding = self.front_end.finding, None
        if finding is not None:
            self._node.diagnostics.fault(finding)

    def feed(self, sample: ImuSample) -> None:
        """Feed one sample."""
        self._node.feed(self._output, sample)


class DeviceDriver(Driver):
    """Feed a node with the samples of a device that a thread reads."""

    def read(self, name: str, session: Session, rate: float) -> None:
        """Begin to read, under a name for the user, so many readings a second [Hz]."""
        DeviceReader(self._node, name, session, self._take, self._lose, 1.0 / rate)

    def _take(self, taken: Taken) -> None:
        if isinstance(taken, Conversions):
            self.deliver(taken)

    def _lose(self, _: DeadReckoningError) -> None:
        self.front_end.interrupt()


def driver_of(configuration: Configuration) -> type[Driver]:
    """Return the driver for `driver.source`: the ``DRIVER`` of the module of its name."""
    source = configuration[DriverSettings].source
    found: type[Driver] = import_module(f'dead_reckoning.nodes.{source}_driver').DRIVER
    return found
