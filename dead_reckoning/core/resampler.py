"""Bring samples of any rate to a uniform one, causally."""

from __future__ import annotations

from dead_reckoning.core.samples import NANOSECONDS, Vector


class Resampler:
    """Average a vector over equal stretches of time, whatever the rate it comes at.

    Time is cut into cells of ``1/rate`` from the first sample on.  A sample of the output is the
    mean over its cell of the straight lines between the samples of the input, stamped at the
    middle: at a higher input rate that is an average, which keeps what is faster than the output
    from folding down; at a lower one it interpolates.  It comes out with the first sample at or
    after the end of its cell.

    Stamps must rise; gaps are bridged by a straight line, so whoever knows better calls `reset`.
    """

    def __init__(self, rate: int) -> None:
        """``rate`` [Hz]."""
        self._rate = rate
        self.reset()

    def reset(self) -> None:
        """Forget everything: the next sample begins the first cell."""
        self._start_ns = 0
        self._cell = 0
        self._end_ns = 0
        self._last_ns: int | None = None
        self._last: Vector = (0.0, 0.0, 0.0)
        self._area = (0.0, 0.0, 0.0)

    def _bound_ns(self, cell: int) -> int:
        """Return where a cell begins [ns]: rounded each time anew, so that nothing drifts."""
        return self._start_ns + (2 * cell * NANOSECONDS + self._rate) // (2 * self._rate)

    def add(self, stamp_ns: int, vector: Vector) -> list[tuple[int, Vector]]:
        """Take one sample, shape (3,); return the samples it completes, with their stamps [ns]."""
        last_ns = self._last_ns
        if last_ns is None:
            self._start_ns = self._last_ns = stamp_ns
            self._end_ns = self._bound_ns(1)
            self._last = vector
            return []
        made: list[tuple[int, Vector]] = []
        x, y, z = self._last
        ax, ay, az = self._area
        to_x, to_y, to_z = vector
        while stamp_ns >= self._end_ns:
            part = (self._end_ns - last_ns) / (stamp_ns - last_ns)
            end_x, end_y, end_z = (
                x + part * (to_x - x),
                y + part * (to_y - y),
                z + part * (to_z - z),
            )
            half = 0.5 * (self._end_ns - last_ns)
            start_ns = self._bound_ns(self._cell)
            width = self._end_ns - start_ns
            made.append(
                (
                    (start_ns + self._end_ns) // 2,
                    (
                        (ax + half * (x + end_x)) / width,
                        (ay + half * (y + end_y)) / width,
                        (az + half * (z + end_z)) / width,
                    ),
                )
            )
            ax = ay = az = 0.0
            x, y, z = end_x, end_y, end_z
            last_ns = self._end_ns
            self._cell += 1
            self._end_ns = self._bound_ns(self._cell + 1)
        half = 0.5 * (stamp_ns - last_ns)
        self._area = (ax + half * (x + to_x), ay + half * (y + to_y), az + half * (z + to_z))
        self._last_ns = stamp_ns
        self._last = vector
        return made
