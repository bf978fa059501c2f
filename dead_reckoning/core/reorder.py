"""Hand samples on in the order of their stamps."""

from __future__ import annotations

from bisect import bisect_left
from typing import Generic, TypeVar

from dead_reckoning.core.errors import LateSampleError, RepeatedStampError, ZeroStampError
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stamps import RESTART_NS

Sample = TypeVar('Sample')


class StampOrder(Generic[Sample]):
    """Hold samples back for a while, so that those which come late still find their place.

    A sample is handed on once the newest stamp is ``hold`` [s] ahead of it, or when more than
    ``limit`` wait.  One that is older than what was handed on already is refused.  One that is
    older than the newest by 1 s or more is a restart: what waits is forgotten, and the sample is
    the first of a new order.  ``restarts`` counts these.
    """

    def __init__(self, hold: float, limit: int = 1000) -> None:
        self.restarts = 0
        self._hold_ns = round(hold * NANOSECONDS)
        self._limit = limit
        self.reset()

    def reset(self) -> None:
        """Forget all samples and stamps; the count of restarts stays."""
        self._stamps: list[int] = []
        self._samples: list[Sample] = []
        self._newest_ns: int | None = None
        self._handed_ns = 0

    @property
    def newest_ns(self) -> int | None:
        """The newest stamp [ns]; None before the first sample."""
        return self._newest_ns

    def add(self, stamp_ns: int, sample: Sample) -> list[tuple[int, Sample]]:
        """Take one sample; return those whose turn has come, in order, with their stamps [ns].

        Raises `ZeroStampError`, `RepeatedStampError` or `LateSampleError`, and then forgets the
        sample.
        """
        newest_ns = self._newest_ns
        if stamp_ns == 0:
            raise ZeroStampError('the stamp is 0: let the driver stamp its messages')
        if newest_ns is not None and newest_ns - stamp_ns >= RESTART_NS:
            self.reset()
            self.restarts += 1
        elif newest_ns is not None and stamp_ns <= newest_ns:
            self._insert(stamp_ns, sample)
            return self._release(newest_ns)
        self._newest_ns = stamp_ns
        stamps = self._stamps
        stamps.append(stamp_ns)
        self._samples.append(sample)
        until_ns = stamp_ns - self._hold_ns
        if 1 < len(stamps) <= self._limit and stamps[0] <= until_ns < stamps[1]:  # as a rule
            self._handed_ns = handed_ns = stamps.pop(0)
            return [(handed_ns, self._samples.pop(0))]
        return self._release(stamp_ns)

    def flush(self) -> list[tuple[int, Sample]]:
        """Return those that wait, in order, as no more come."""
        return self._hand_on(len(self._stamps))

    def _insert(self, stamp_ns: int, sample: Sample) -> None:
        at = bisect_left(self._stamps, stamp_ns)
        waits_already = at < len(self._stamps) and self._stamps[at] == stamp_ns
        if waits_already or stamp_ns == self._handed_ns:
            raise RepeatedStampError(
                f'the stamp {stamp_ns} ns came twice: the driver repeats itself'
            )
        if stamp_ns < self._handed_ns:
            late = (self._handed_ns - stamp_ns) / NANOSECONDS
            raise LateSampleError(
                f'the stamp {stamp_ns} ns is {late:.6f} s older than a sample that was used '
                'already: publish samples in the order of their stamps, or hold them back longer'
            )
        self._stamps.insert(at, stamp_ns)
        self._samples.insert(at, sample)

    def _release(self, newest_ns: int) -> list[tuple[int, Sample]]:
        count = bisect_left(self._stamps, newest_ns - self._hold_ns + 1)
        count = max(count, len(self._stamps) - self._limit)
        return self._hand_on(count)

    def _hand_on(self, count: int) -> list[tuple[int, Sample]]:
        if not count:
            return []
        released = list(zip(self._stamps[:count], self._samples[:count], strict=True))
        self._handed_ns = self._stamps[count - 1]
        del self._stamps[:count], self._samples[:count]
        return released
