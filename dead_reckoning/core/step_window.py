"""The times between landings that are steps."""

from __future__ import annotations

from dead_reckoning.core.samples import NANOSECONDS

LONGEST = 5.0
"""No window is longer [s]: so much of the past a detector has to keep."""


class StepWindow:
    """Say how soon after one another steps may come, and how late: the same for every detector.

    AN-900 names such a window, after AN-602, as what its own step finder lacks.  What follows a
    landing sooner than ``shortest`` [s] is no landing; when none follows for ``longest`` [s], the
    walk has ended.
    """

    def __init__(self, shortest: float, longest: float) -> None:
        self.configure(shortest, longest)

    def configure(self, shortest: float, longest: float) -> None:
        """Take over changed times [s]."""
        self.shortest, self.longest = shortest, longest
        self.shortest_ns = round(shortest * NANOSECONDS)
        self.longest_ns = round(longest * NANOSECONDS)
