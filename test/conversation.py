"""A decoder and a board talk, without a port and without a clock."""

from itertools import cycle

from dead_reckoning.core.errors import ReadingError
from dead_reckoning.sources.serial.protocols import Measurement, Reading

TICK = 0.01
"""Time [s] between two looks of the driver."""


def measured(counts, rate=(0.0, 0.0, 0.0), time=0.0):
    """Return a measurement at the origin."""
    return Measurement({'counts': counts}, time, rate, (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))


class Conversation:
    """Let a decoder and a board talk, the way from the board cut and damaged.

    ``told`` is what the board was told, in order, ``events`` what the decoder found.  Set
    ``board`` to another one to reset it.
    """

    def __init__(self, decoder, board, sizes=(1000,), damage=lambda data: data):
        self.decoder, self.board, self.damage = decoder, board, damage
        self.told, self.events = [], []
        self._sizes = cycle(sizes)
        self._waited = float('inf')

    def run(self, seconds, counts, rate=(0.0, 0.0, 0.0)):
        """Go on for a time, the board measuring each hundredth of a second; return new events.

        ``counts`` are constant, or a function of the number of the tick.
        """
        before = len(self.events)
        for tick in range(round(seconds / TICK)):
            values = counts(tick) if callable(counts) else counts
            self._hear(self.board.measure(measured(values, rate)))
            self._tell()
            self._waited += TICK
        return self.events[before:]

    def _hear(self, data):
        data = self.damage(data) if data else data
        while data:
            size = next(self._sizes)
            self.events += self.decoder.feed(data[:size])
            data = data[size:]
            self._tell()

    def _tell(self):
        if told := self.decoder.due(self._waited):
            self._waited = 0.0
            self.told.append(told)
            self._hear(self.board.hear(told))


def readings(events):
    """Return the values of the readings among events."""
    return [event.values for event in events if isinstance(event, Reading)]


def errors(events):
    """Return the errors among events."""
    return [event for event in events if isinstance(event, ReadingError)]
