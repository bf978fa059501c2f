"""Make conversions of the bytes that a serial port brings."""

from __future__ import annotations

import numpy as np

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.errors import OutOfRangeError, ReadingError
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stamps import RESTART_NS
from dead_reckoning.sources.serial.protocols import Decoder, Reading
from dead_reckoning.sources.serial.settings import SerialSettings


class Receiver:
    """Turn the readings of a decoder into counts, each with the stamp of its first bit.

    ``stamp = arrival − bytes since its first · time of a byte − latency``: the bytes of a call are
    taken to have followed one another without a pause, the last just before the arrival.  Stamps
    rise: one that does not follow the last becomes the last plus 1 ns, except after a clock that
    went back by 1 s or more, which starts anew.

    ``readings`` counts those that were good.
    """

    def __init__(self, decoder: Decoder, model: Accelerometer, settings: SerialSettings) -> None:
        self.readings = 0
        self._decoder = decoder
        self._model = model
        self._byte_ns = settings.byte_time * NANOSECONDS
        self._latency_ns = settings.latency * NANOSECONDS
        self._fed = 0
        self._last_ns = 0

    def take(self, data: bytes, arrival_ns: int) -> tuple[Conversions, list[ReadingError]]:
        """Take bytes, the last of which arrived at a stamp; return what was in them.

        Errors say why readings are missing; they change nothing else.
        """
        self._fed += len(data)
        good: list[Reading] = []
        errors: list[ReadingError] = []
        for event in self._decoder.feed(data):
            if isinstance(event, Reading):
                good.append(event)
            elif isinstance(event, ReadingError):
                errors.append(event)
        counts = self._model.counts_of(
            np.array([reading.values for reading in good]).reshape(-1, 3), self._decoder.unit
        )
        possible = self._model.possible(counts)
        for index in np.flatnonzero(~possible):
            errors.append(self._impossible(good[index]))
        stamps = [self._stamp(good[i].start, arrival_ns) for i in np.flatnonzero(possible)]
        self.readings += len(stamps)
        return Conversions(np.array(stamps, dtype=np.int64), counts[possible]), errors

    def restart(self) -> list[ReadingError]:
        """Forget what is incomplete: the port was opened anew; stamps go on rising."""
        return [event for event in self._decoder.restart() if isinstance(event, ReadingError)]

    def _impossible(self, reading: Reading) -> OutOfRangeError:
        low, high = self._model.limits
        values = ', '.join(f'{value:g}' for value in reading.values)
        return OutOfRangeError(
            f'{values} {self._decoder.unit} can be no reading of a converter from {low:.0f} to '
            f'{high:.0f} counts: driver.adc_bits, driver.adc_reference, driver.sensor or the unit '
            'does not fit, or the line is disturbed'
        )

    def _stamp(self, start: int, arrival_ns: int) -> int:
        on_the_way_ns = (self._fed - start) * self._byte_ns + self._latency_ns
        stamp_ns = arrival_ns - round(on_the_way_ns)
        if 0 <= self._last_ns - stamp_ns < RESTART_NS:
            stamp_ns = self._last_ns + 1
        self._last_ns = stamp_ns
        return stamp_ns
