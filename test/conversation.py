"""A decoder and a board talk, without a port and without a clock."""

from collections import deque

from dead_reckoning.core.errors import ReadingError
from dead_reckoning.sources.serial.protocols import Measurement, Reading

TICK = 0.01
"""Time [s] between two looks of the driver."""


def measured(counts, rate=(0.0, 0.0, 0.0), time=0.0):
    """Return a measurement at the origin; a hundred counts are 1 of the other units."""
    others = tuple(count / 100.0 for count in counts)
    values = {'counts': counts, 'volts': others, 'g': others, 'm/s2': others}
    return Measurement(values, time, rate, (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0))


class Conversation:
    """Let a decoder and a board talk, the way from the board cut and damaged.

    ``told`` is what the board was told, in order, ``events`` what the decoder found, ``sent`` each
    message of the board before it was damaged, and how many bytes were fed before it.  Set
    ``board`` to another one to reset it.
    """

    def __init__(self, decoder, board, sizes=(1000,), damage=lambda data: data):
        self.decoder, self.board, self.damage = decoder, board, damage
        self.told, self.events, self.sent = [], [], []
        self.sizes = deque(sizes)
        self._waited = float('inf')
        self._fed = self._ticks = 0

    def run(self, seconds, counts, rate=(0.0, 0.0, 0.0)):
        """Go on for a time, the board measuring each hundredth of a second; return new events.

        One that averages measures as often as it says.

        ``counts`` are constant, or a function of the number of the tick.
        """
        before = len(self.events)
        for tick in range(round(seconds / TICK)):
            values = counts(tick) if callable(counts) else counts
            for _ in range(round(getattr(self.board, 'RATE', 1.0 / TICK) * TICK)):
                self._hear(self.board.measure(measured(values, rate, self._ticks * TICK)))
            self._tell()
            self._waited += TICK
            self._ticks += 1
        return self.events[before:]

    def _hear(self, data):
        if not data:
            return
        self.sent.append((self._fed, data))
        data = self.damage(data)
        while data:
            self.sizes.rotate(-1)
            piece, data = data[: self.sizes[-1]], data[self.sizes[-1] :]
            self._fed += len(piece)
            self.events += self.decoder.feed(piece)
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
