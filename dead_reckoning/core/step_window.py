"""Tell by the time between landings which of them are steps of a walk."""

from __future__ import annotations

from dead_reckoning.core.samples import NANOSECONDS

LONGEST = 5.0
"""No window is longer [s]: so much of the past a detector has to keep."""


class StepWindow:
    """Admit a landing only within a window of time after the one before it.

    AN-900 names such a window, after AN-602, as what its own step finder lacks.  A landing sooner
    than ``shortest`` [s] after the one before is none.  When none comes for ``longest`` [s], the
    walk has ended.  The first landing of a walk shows a step only together with the second: it
    waits, and counts when that one comes in time.
    """

    def __init__(self, shortest: float, longest: float) -> None:
        self.configure(shortest, longest)
        self.reset()

    def configure(self, shortest: float, longest: float) -> None:
        """Take over changed times [s] without touching the walk."""
        self.shortest_ns = round(shortest * NANOSECONDS)
        self.longest_ns = round(longest * NANOSECONDS)

    def reset(self) -> None:
        """Forget the walk, and the landing that waits."""
        self.last_ns: int | None = None
        self.walking = False

    def expire(self, now_ns: int) -> None:
        """End the walk if the last landing lies too far back."""
        if self.last_ns is not None and now_ns - self.last_ns > self.longest_ns:
            self.reset()

    def too_soon(self, stamp_ns: int) -> bool:
        """Say whether a landing would follow the last one faster than anyone walks."""
        return self.last_ns is not None and stamp_ns - self.last_ns < self.shortest_ns

    def land(self, stamp_ns: int) -> list[int]:
        """Take a landing that is not too soon; return the stamps [ns] of the steps it proves.

        That is none at the first landing of a walk, the first and this one at the second, this one
        from then on.
        """
        self.expire(stamp_ns)
        before_ns, self.last_ns = self.last_ns, stamp_ns
        if before_ns is None:
            return []
        proven = [stamp_ns] if self.walking else [before_ns, stamp_ns]
        self.walking = True
        return proven
