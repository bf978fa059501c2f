"""When a board measured, by its own clock: the jitter of the way to here does not count."""

from __future__ import annotations

from collections import deque
from typing import TypeAlias

from dead_reckoning.core.samples import NANOSECONDS

Point: TypeAlias = tuple[float, float]
"""Clock of the board and time of arrival [ns], both since the first reading."""

Line: TypeAlias = tuple[float, float]
"""Offset [ns] and rate [ns per unit of the clock]."""

WINDOW = 300.0 * NANOSECONDS
"""How far back the fit looks [ns]: the longer, the more even, and the later it follows a crystal
that warms up."""

SEGMENTS = 10
"""The window moves on by a tenth of it."""

CORNERS = 256
"""Most points of a hull; of random delays it has about ten."""

SETTLED = 0.25 * NANOSECONDS
"""From when on the fit counts [ns]."""

FEWEST = 10
"""Readings that a fit takes."""

REFIT = 1.0 * NANOSECONDS
"""Longest time between two fits [ns]."""

GAP = 0.5 * NANOSECONDS
"""Pause of the arrivals [ns] after which it starts anew: a counter may have wrapped unseen."""

GAP_INTERVALS = 5.0
"""The same in intervals; the longer of the two counts."""

JUMP = 0.05 * NANOSECONDS
"""What comes this much later [ns] for a second is not delayed: the clock of the board, or of the
host, was set.  What comes as much earlier shows that at once."""


class BoardClock:
    """Fit ``arrival = offset + rate · clock + delay`` and stamp readings without their delay.

    No reading arrives before it was measured, so the delay is positive, and no model of it is
    needed: the line is the highest that lies below all arrivals of a window, with the least sum of
    delays, which is the edge of their lower convex hull below the middle of the window (Moon,
    Skelly and Towsley, INFOCOM 1999, doi:10.1109/INFCOM.1999.749287; by the hull: Zhang, Liu and
    Xia, INFOCOM 2002).  The smallest delay there is can't be seen, and stays in the stamps.

    The unit of the clock does not matter, nor do readings that got lost.  Until the fit stands
    stamps are arrivals, as where those are before the line.  Where it changes, two stamps keep at
    least half of their distance by the clock.  A reading is fitted once the next one follows on
    it: one whose clock was disturbed on the wire is stamped when it arrived, and changes nothing.
    It starts anew where two readings go back by the clock or do not fit, where the arrivals go
    back, and after a gap.  It keeps a bounded number of points.
    """

    def __init__(self) -> None:
        self.restarts = -1
        """How often it started anew."""
        self.doubted = False
        """Whether the clock of the last reading does not fit."""
        self.restart()

    def restart(self) -> None:
        """Forget all: what comes does not follow on."""
        self.restarts += 1
        self._origin: tuple[float, int] | None = None
        self._segments: deque[list[Point]] = deque(maxlen=SEGMENTS)
        self._count = 0
        self._last: Point = (0.0, 0.0)
        self._last_stamp = 0.0
        self._newest: Point = (0.0, 0.0)
        self._newest_stamp = 0.0
        self.doubted = False
        self._line: Line | None = None
        self._next_fit = SETTLED
        self._lowest = JUMP
        self._watched_until = 0.0

    @property
    def rate(self) -> float | None:
        """Length of a unit of the clock [ns]; None until the fit stands."""
        return None if self._line is None else self._line[1]

    def stamp(self, clock: float, arrival_ns: int) -> int:
        """Return when a reading was measured [ns] that was so late by the clock of the board.

        ``arrival_ns`` is that of its first bit.
        """
        if self._origin is not None and not self._follows(*self._since_origin(clock, arrival_ns)):
            self.restart()
        if self._origin is None:
            self._origin = (clock, arrival_ns)
        at, arrival = self._since_origin(clock, arrival_ns)
        newest = self._newest
        if newest[0] < at and (self._count == 0 or newest[0] > self._last[0]):
            self._take(newest)
            self._last, self._last_stamp = newest, self._newest_stamp
        stamp = arrival
        if self._line is not None and not self.doubted:
            offset, rate = self._line
            least = self._last_stamp + 0.5 * rate * (at - self._last[0])
            stamp = max(min(offset + rate * at, arrival), least)
        self._newest, self._newest_stamp = (at, arrival), stamp
        return self._origin[1] + round(stamp)

    def _since_origin(self, clock: float, arrival_ns: int) -> Point:
        assert self._origin is not None
        return clock - self._origin[0], float(arrival_ns - self._origin[1])

    def _follows(self, at: float, arrival: float) -> bool:
        """Say whether a reading belongs to the fit, or is the first one that does not."""
        interval = self._newest[1] / max(1, self._count)
        pause = arrival - self._newest[1]
        if not -JUMP <= pause <= max(GAP, GAP_INTERVALS * interval):
            return False
        delay = 0.0
        if self._line is not None:
            offset, rate = self._line
            delay = arrival - offset - rate * at
        doubted, self.doubted = self.doubted, at < self._last[0] or delay < -JUMP
        if self.doubted:
            return not doubted
        if self._line is not None:
            if arrival >= self._watched_until:
                if self._lowest > JUMP and self._watched_until > 0.0:
                    return False
                self._watched_until, self._lowest = arrival + NANOSECONDS, delay
            self._lowest = min(self._lowest, delay)
        return True

    def _take(self, point: Point) -> None:
        """Add a point, and fit anew where that is due."""
        at, arrival = point
        self._count += 1
        if not self._segments or arrival - self._segments[-1][0][1] > WINDOW / SEGMENTS:
            self._segments.append([])
        _extend(self._segments[-1], point)
        if self._line is not None and arrival < self._line[0] + self._line[1] * at:
            self._next_fit = arrival
        if arrival >= self._next_fit and self._count >= FEWEST:
            self._line = self._fit()
            span = arrival - self._segments[0][0][1]
            self._next_fit = arrival + min(REFIT, span / 16.0)

    def _fit(self) -> Line:
        hull: list[Point] = []
        for segment in self._segments:
            for point in segment:
                _extend(hull, point)
        middle = 0.5 * (hull[0][0] + hull[-1][0])
        right = next(k for k in range(1, len(hull)) if hull[k][0] >= middle)
        (x0, y0), (x1, y1) = hull[right - 1], hull[right]
        rate = max(0.0, (y1 - y0) / (x1 - x0))
        return y1 - rate * x1, rate


def _extend(hull: list[Point], point: Point) -> None:
    """Add a point to the right of a lower convex hull."""
    x, y = point
    while len(hull) > 1:
        (x0, y0), (x1, y1) = hull[-2:]
        if (x1 - x0) * (y - y0) > (y1 - y0) * (x - x0):
            break
        del hull[-1]
    hull.append(point)
    if len(hull) > CORNERS:
        del hull[1:-1:2]
