"""A board, the simulated sensor on it and its line, without a port and without a clock."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.accelerometer import UNITS
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS, Vector
from dead_reckoning.sources.driver import serial_receiver, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.serial.protocols import (
    Board,
    Measurement,
    board_class,
    decoder_class,
)
from dead_reckoning.sources.serial.settings import SerialSettings
from dead_reckoning.sources.simulated import SimulatedSettings
from dead_reckoning.tools.emulate.faults import Faults
from dead_reckoning.tools.emulate.line import Line

BUFFER = 64
"""Bytes that may wait in the UART of a board; it does not send a measurement behind more."""

ANSWERS = 4096
"""Bytes that may wait where a board answers; it does not hear what comes beyond them."""

BLOCK = 64
"""Measurements that are computed at once."""


class Sensor:
    """Measure with the simulated sensor of a configuration, again and again.

    Its rate is `driver.sample_rate`.  Rates of turn are those of the simulated gyroscope, the true
    ones where there is none; orientation and position are true.
    """

    def __init__(self, configuration: Configuration) -> None:
        driver = configuration[DriverSettings]
        self._rate = driver.sample_rate
        self._model = driver.model()
        self._source = simulated_sensor(configuration, 0)
        self._taken = 0
        self._ready: Iterator[Measurement] = iter(())

    @property
    def next(self) -> float:
        """When it measures next, since the motion began [s]."""
        return self._taken / self._rate

    def measure(self, since: float) -> Measurement:
        """Return the next measurement of a board that was switched on at a time [s]."""
        measurement = next(self._ready, None)
        if measurement is None:
            self._ready = self._block()
            measurement = next(self._ready)
        self._taken += 1
        return replace(measurement, time=measurement.time - since)

    def _block(self) -> Iterator[Measurement]:
        """Measure a few times at once, which takes hardly longer than once."""
        conversions = self._source.read(BLOCK)
        counts = conversions.counts
        force = self._model.force(counts, np.array(self._model.zero_g))
        values = np.stack(
            (counts, counts * self._model.unit_per_count, force / GRAVITY, force), axis=1
        )
        stamps = conversions.stamps_ns.tolist()
        truths = self._source.truths(stamps)
        rates = [truth.angular_velocity for truth in truths]
        if conversions.rates is not None:
            rates = list(map(_vector, conversions.rates))
        for stamp_ns, rows, rate, truth in zip(stamps, values, rates, truths, strict=True):
            vectors = dict(zip(UNITS, map(_vector, rows), strict=True))
            yield Measurement(
                vectors, stamp_ns / NANOSECONDS, rate, truth.attitude, truth.position
            )


class Emulator:
    """Let a board measure and answer; bytes and times [s] since the motion began go in and out.

    The sensor moves on while the board is off.  Each time it is switched on the board begins anew.
    ``measured`` counts measurements of the board, ``unsent`` those that it did not send since its
    line was too slow.
    """

    def __init__(self, configuration: Configuration, faults: Faults) -> None:
        """Raise `SettingsError` where the driver could not read what would be sent."""
        serial_receiver(configuration)
        port = configuration[SerialSettings]
        seed = configuration[SimulatedSettings].seed
        self.measured = 0
        self.unsent = 0
        self._configuration = configuration
        self._protocol = port.protocol
        self._sensor = Sensor(configuration)
        self._line = Line(port.byte_time, faults, seed)
        self._board: Board | None = None
        self._since = 0.0

    def switch_on(self, time: float) -> None:
        """Begin anew with a board."""
        settings = self._configuration[decoder_class(self._protocol).Settings]
        self._board = board_class(self._protocol)(settings)
        self._since = time

    def switch_off(self) -> None:
        """Lose what the board knows, and what is on its line."""
        self._board = None
        self._line.clear()

    @property
    def next(self) -> float:
        """When something is to be done next."""
        return min(self._sensor.next, self._line.next)

    def advance(self, time: float) -> bytes:
        """Measure until a time; return the bytes that have arrived by then since the last call."""
        while self._sensor.next <= time:
            now = self._sensor.next
            measurement = self._sensor.measure(self._since)
            if self._board is None:
                continue
            self.measured += 1
            sent = self._board.measure(measurement)
            if self._line.waiting(now) > BUFFER:
                self.unsent += bool(sent)
            else:
                self._line.send(sent, now)
        return self._line.take(time)

    def hear(self, data: bytes, time: float) -> None:
        """Take what the board is told at a time, and answer."""
        if self._board is not None and self._line.waiting(time) <= ANSWERS:
            self._line.send(self._board.hear(data), time)


def _vector(array: NDArray[np.float64]) -> Vector:
    x, y, z = array.tolist()
    return (x, y, z)
