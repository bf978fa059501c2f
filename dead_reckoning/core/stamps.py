"""Turn the stamps of samples into time steps, and refuse the stamps that are no time."""

from __future__ import annotations

from dead_reckoning.core.errors import LateSampleError, RepeatedStampError, ZeroStampError
from dead_reckoning.core.samples import NANOSECONDS

RESTART_NS = NANOSECONDS
"""A stamp that goes back by more than this is a new start (a looped bag), not a late sample."""


class Timeline:
    """Give the time since the last sample, from stamps alone.

    The first sample and the first one after a restart have no step.  ``restarts`` counts the
    latter.
    """

    def __init__(self) -> None:
        self.restarts = 0
        self._last_ns: int | None = None

    @property
    def last_ns(self) -> int | None:
        """The last stamp [ns]; None before the first."""
        return self._last_ns

    def advance(self, stamp_ns: int) -> int | None:
        """Take the next stamp [ns] and return the step [ns] since the last one, or None.

        None is the answer at the first sample and when the stamp goes back by more than 1 s, which
        is a restart.  Raises `ZeroStampError`, `RepeatedStampError` or `LateSampleError` (back by
        less), and then forgets the stamp.
        """
        last_ns = self._last_ns
        if last_ns is not None and stamp_ns > last_ns:
            self._last_ns = stamp_ns
            return stamp_ns - last_ns
        if stamp_ns == 0:
            raise ZeroStampError('the stamp is 0: let the driver stamp its messages')
        if last_ns is None:
            self._last_ns = stamp_ns
            return None
        if stamp_ns == last_ns:
            raise RepeatedStampError(
                f'the stamp {stamp_ns} ns came twice: the driver repeats itself'
            )
        if not self.goes_back(stamp_ns):
            back_ns = last_ns - stamp_ns
            raise LateSampleError(
                f'the stamp {stamp_ns} ns is {back_ns / NANOSECONDS:.6f} s older than the last '
                'one: publish samples in the order of their stamps'
            )
        self.restarts += 1
        self._last_ns = stamp_ns
        return None

    def goes_back(self, stamp_ns: int) -> bool:
        """Say whether the next stamp [ns] would be a restart."""
        last_ns = self._last_ns
        return last_ns is not None and stamp_ns != 0 and last_ns - stamp_ns >= RESTART_NS

    def reset(self) -> None:
        """Forget the last stamp; the count of restarts stays."""
        self._last_ns = None
