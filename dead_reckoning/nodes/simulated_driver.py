"""Run a simulated accelerometer in the time of a node's clock."""

from __future__ import annotations

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.samples import NANOSECONDS, ImuSample
from dead_reckoning.core.stages import GROUND_TRUTH, RAW
from dead_reckoning.nodes.chain_node import STEADY, ChainNode
from dead_reckoning.nodes.driver import Driver
from dead_reckoning.nodes.watch import ClockWatch
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.simulated import SimulatedAccelerometer

CATCH_UP = 1.0
"""Longest stretch [s] that is made up for at once when the clock leaps."""


class SimulatedDriver(Driver):
    """Feed a node with the samples of a simulated sensor, and with the truth behind each.

    Stamps are exact: start plus conversion number over rate; a timer that comes late only delivers
    late.  Under use_sim_time it waits for a clock, and starts over when the clock goes back.
    """

    def __init__(self, node: ChainNode, configuration: Configuration) -> None:
        super().__init__(node, configuration)
        self._settings = configuration[DriverSettings]
        self._source: SimulatedAccelerometer | None = None
        self._last_ns = 0
        period = self._settings.samples_per_message / self._settings.sample_rate
        # Not by /clock, whose leaps it makes up for bit by bit, also where the clock stands then.
        node.create_timer(max(period, 0.001), self._tick, clock=STEADY)
        node.watch(ClockWatch(node, node.common.input_timeout).findings)

    @classmethod
    def outputs(cls, configuration: Configuration) -> tuple[str, ...]:
        """Name the topics of the samples and of the truth."""
        return (RAW, GROUND_TRUTH)

    def _tick(self) -> None:
        now_ns = self._node.get_clock().now().nanoseconds
        if now_ns == 0:
            return  # use_sim_time, and no clock yet
        if self._source is None or now_ns < self._last_ns - NANOSECONDS:
            listeners = sum(map(self._node.count_subscribers_of, (RAW, GROUND_TRUTH)))
            if listeners < self._settings.wait_for_subscribers:
                return
            if self._source is not None:
                self.front_end = front_end(self._configuration)
            self._source = simulated_sensor(self._configuration, now_ns)
        self._last_ns = now_ns
        per_message = self._settings.samples_per_message
        limit = max(per_message, int(CATCH_UP * self._settings.sample_rate))
        waiting = min(self._source.available(now_ns), limit)
        if waiting >= per_message:
            self.deliver(self._source.read(waiting - waiting % per_message))

    def feed(self, sample: ImuSample) -> None:
        """Feed one sample, and the truth of the same stamp."""
        super().feed(sample)
        if self._source is not None:
            self._node.feed(GROUND_TRUTH, self._source.truth(sample.stamp_ns))


DRIVER = SimulatedDriver
