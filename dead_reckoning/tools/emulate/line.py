"""A serial line: bytes leave it one after the other, at its rate, with its faults."""

from __future__ import annotations

from collections import deque

import numpy as np

from dead_reckoning.tools.emulate.faults import Faults

PAUSE = 0.1
"""How long [s] a board pauses."""

STREAM = 2
"""Sets its random numbers apart from those of sensors with the same seed."""


class Line:
    """Give each byte its time on the wire; no clock is in it, times [s] are the caller's.

    A byte that is lost takes its time like any other, one that comes twice takes it twice.  The
    faults follow from the seed and the bytes alone, however those are cut into calls.
    """

    def __init__(self, byte_time: float, faults: Faults, seed: int) -> None:
        """``byte_time`` [s]."""
        self._byte_time = byte_time
        self._faults = faults
        self._random = np.random.default_rng((seed, STREAM))
        self._free_at = 0.0
        self._bytes: deque[tuple[float, int]] = deque()

    def waiting(self, time: float) -> float:
        """Return for how many bytes' time the line is busy still."""
        return max(0.0, self._free_at - time) / self._byte_time

    def send(self, data: bytes, time: float) -> None:
        """Put bytes behind those that wait."""
        faults = self._faults
        end = max(self._free_at, time)
        chances = self._random.random((len(data), 5)).tolist()
        for byte, (drop, flip, double, pause, bit) in zip(data, chances, strict=True):
            if flip < faults.flip:
                byte ^= 1 << int(8.0 * bit)
            for _ in range(2 if double < faults.double else 1):
                end += self._byte_time
                if drop >= faults.drop:
                    self._bytes.append((end, byte))
            if pause < faults.pause:
                end += PAUSE
        self._free_at = end

    def take(self, time: float) -> bytes:
        """Return the bytes that have arrived by a time, and were not taken yet."""
        arrived = bytearray()
        while self._bytes and self._bytes[0][0] <= time:
            arrived.append(self._bytes.popleft()[1])
        return bytes(arrived)

    @property
    def next(self) -> float:
        """When the next byte arrives; infinite where none is under way."""
        return self._bytes[0][0] if self._bytes else np.inf

    def clear(self) -> None:
        """Forget what is under way: the board was pulled out."""
        self._bytes.clear()
        self._free_at = 0.0
