"""Make conversions of the bytes that a serial port brings."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.errors import OutOfRangeError, ReadingError
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.samples import (
    NANOSECONDS,
    UNMEASURED_VARIANCE,
    ZERO,
    Matrix,
    NavigationState,
)
from dead_reckoning.core.stamps import RESTART_NS
from dead_reckoning.sources.serial.board_clock import BoardClock
from dead_reckoning.sources.serial.protocols import Decoder, Position, Reading
from dead_reckoning.sources.serial.settings import SerialSettings

RHYTHM = 256
"""Stamps that rate and jitter are taken from."""


class Taken(NamedTuple):
    """What was in some bytes; ``errors`` say why something is missing."""

    conversions: Conversions
    errors: list[ReadingError]
    positions: list[NavigationState]


class Receiver:
    """Turn what a decoder finds into counts and positions, each with its stamp.

    ``first bit = arrival − bytes since · time of a byte``: the bytes of a call are taken to have
    followed one another without a pause, the last just before the arrival.  Then

    * ``stamp = first bit − latency``,
    * with a clock of the board the first bit by that (`BoardClock`),
    * of a board that is polled the middle between the end of what it was told and the first bit.

    Stamps rise: one that does not follow the last becomes the last plus 1 ns, except after a clock
    that went back by 1 s or more, which starts anew.

    ``readings`` counts those that were good, ``bad`` those that were damaged, ``resynchronised``
    how often a good one came after those, and ``duplicates`` those that a board sent twice: by its
    clock, or, where it is polled, as the answer equals the one before.  They are handed on.
    """

    def __init__(self, decoder: Decoder, model: Accelerometer, settings: SerialSettings) -> None:
        self.readings = 0
        self.bad = 0
        self.resynchronised = 0
        self.duplicates = 0
        self.last_error: ReadingError | None = None
        self._decoder = decoder
        self._model = model
        self._byte_ns = settings.byte_time * NANOSECONDS
        self._latency_ns = round(settings.latency * NANOSECONDS)
        variance, huge = settings.position_deviation**2, UNMEASURED_VARIANCE
        self._position_covariance: Matrix = (
            *(variance, 0.0, 0.0),
            *(0.0, variance, 0.0),
            *(0.0, 0.0, huge),
        )
        self._clock = BoardClock()
        self._told_ns: int | None = None
        self._fed = 0
        self._last_ns = 0
        self._in_step = True
        self._before: Reading | None = None
        self._stamps: deque[int] = deque(maxlen=RHYTHM)

    def take(self, data: bytes, arrival_ns: int) -> Taken:
        """Take bytes, the last of which arrived at a stamp; return what was in them.

        Errors change nothing else.
        """
        self._fed += len(data)
        readings: list[Reading] = []
        places: list[Position] = []
        errors: list[ReadingError] = []
        for event in self._decoder.feed(data):
            if isinstance(event, ReadingError):
                errors.append(event)
                self._in_step &= event.severity == 'none'
                continue
            self.resynchronised += not self._in_step
            self._in_step = True
            if isinstance(event, Reading):
                readings.append(event)
            else:
                places.append(event)
        counts = self._model.counts_of(
            np.array([reading.values for reading in readings]).reshape(-1, 3), self._decoder.unit
        )
        possible = self._model.possible(counts)
        errors += [self._impossible(readings[index]) for index in np.flatnonzero(~possible)]
        good = [readings[index] for index in np.flatnonzero(possible)]
        stamps = [self._stamp_of(reading, arrival_ns) for reading in good]
        positions = [self._state(place, arrival_ns) for place in places]
        self._note(good, errors)
        self.readings += len(good) + len(positions)
        conversions = Conversions(
            np.array(stamps, dtype=np.int64),
            counts[possible],
            _rows([reading.rate for reading in good], 3),
            _rows([reading.orientation for reading in good], 4),
        )
        return Taken(conversions, errors, positions)

    def due(self, waited: float) -> bytes:
        """Return what the board is to be told now, as `Decoder.due`."""
        return self._decoder.due(waited)

    def told(self, data: bytes, stamp_ns: int) -> None:
        """Note that the board is told something, from a stamp on."""
        if self._decoder.POLLED:
            self._told_ns = stamp_ns + round(len(data) * self._byte_ns)

    def goodbye(self) -> bytes:
        """Return what the board is told at the end."""
        return self._decoder.goodbye()

    def restart(self) -> list[ReadingError]:
        """Forget what is incomplete: the port was opened anew; stamps go on rising."""
        self._clock.restart()
        self._told_ns = None
        self._before = None
        self._in_step = True
        self._stamps.clear()
        return [event for event in self._decoder.restart() if isinstance(event, ReadingError)]

    def figures(self) -> Mapping[str, object]:
        """Return what /diagnostics shows; rate [Hz] and jitter [s] of the stamps of late."""
        intervals = np.diff(np.array(self._stamps, dtype=np.int64)) / NANOSECONDS
        length = float(intervals.sum())
        return {
            'readings': self.readings,
            'bad_readings': self.bad,
            'resynchronised': self.resynchronised,
            'duplicates': self.duplicates,
            'rate': f'{len(intervals) / length if length else 0.0:.2f}',
            'jitter': f'{float(intervals.std()) if length else 0.0:.6f}',
            'last_error': '' if self.last_error is None else str(self.last_error),
        }

    def _impossible(self, reading: Reading) -> OutOfRangeError:
        low, high = self._model.limits
        values = ', '.join(f'{value:g}' for value in reading.values)
        return OutOfRangeError(
            f'{values} {self._decoder.unit} can be no reading of a converter from {low:.0f} to '
            f'{high:.0f} counts: driver.adc_bits, driver.adc_reference, driver.sensor or the unit '
            'does not fit, or the line is disturbed'
        )

    def _note(self, good: list[Reading], errors: list[ReadingError]) -> None:
        for reading in good:
            before, self._before = self._before, reading
            if before is None:
                continue
            if reading.clock is not None:
                self.duplicates += reading.clock == before.clock
            elif self._decoder.POLLED:
                self.duplicates += reading.values == before.values
        for error in errors:
            if error.severity != 'none':
                self.bad += 1
                self.last_error = error

    def _state(self, place: Position, arrival_ns: int) -> NavigationState:
        """Return a position as a state of which nothing else is known."""
        huge = UNMEASURED_VARIANCE
        unknown: Matrix = (huge, 0.0, 0.0, 0.0, huge, 0.0, 0.0, 0.0, huge)
        return NavigationState(
            self._stamp_of(place, arrival_ns),
            (place.x, place.y, 0.0),
            ZERO,
            position_covariance=self._position_covariance,
            velocity_covariance=unknown,
            attitude_covariance=unknown,
        )

    def _stamp_of(self, event: Reading | Position, arrival_ns: int) -> int:
        stamp_ns = arrival_ns - round((self._fed - event.start) * self._byte_ns)
        if isinstance(event, Reading) and event.clock is not None:
            stamp_ns = self._clock.stamp(event.clock, stamp_ns)
        elif self._told_ns is not None and self._told_ns <= stamp_ns:  # else it answers another
            stamp_ns = (self._told_ns + stamp_ns) // 2
            self._told_ns = None
        stamp_ns -= self._latency_ns
        if 0 <= self._last_ns - stamp_ns < RESTART_NS:
            stamp_ns = self._last_ns + 1
        self._last_ns = stamp_ns
        self._stamps.append(stamp_ns)
        return stamp_ns


def _rows(values: list[tuple[float, ...] | None], width: int) -> NDArray[np.float64] | None:
    """Return values as rows, NaN for None; None where there are none."""
    if all(value is None for value in values):
        return None
    missing = (np.nan,) * width
    return np.array([missing if value is None else value for value in values])
