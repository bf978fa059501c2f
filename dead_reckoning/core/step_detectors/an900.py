"""AN-900's step finder: a moving sum that crosses its own mean after a maximum and a minimum."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from itertools import islice
from math import floor, inf
from typing import ClassVar

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.step_detectors import Step
from dead_reckoning.core.step_window import LONGEST, StepWindow

SUMMED = 8
LAG = (SUMMED - 1) / 2
"""So many samples before the newest lies the moment that their sum stands for."""

LIKENESS = 0.25
"""Of the two rises that begin a walk the lower one has at least this part of the height."""


@dataclass(frozen=True, kw_only=True)
class An900Settings(Settings, prefix='pedometer.an900'):
    """Thresholds of AN-900's step finder, turned from counts of its ADC into SI."""

    slope_threshold: float = parameter(
        0.12,
        'The moving sum of eight turns when it changes by more than this from one sample to the '
        'next, that is when the force does so within eight samples; AN-900: 5 counts of 2.44 mg',
        unit='m/s²',
        minimum=0.0,
        maximum=100.0,
        mutable=True,
    )
    dead_band: float = parameter(
        0.024,
        'Smaller changes of the moving sum are taken for none; AN-900: 1 count of 2.44 mg',
        unit='m/s²',
        minimum=0.0,
        maximum=100.0,
        mutable=True,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Landing:
    """A rise of the moving sum through its middle: when, at which sample, and how high.

    ``index`` counts the samples, and lies between two.
    """

    stamp_ns: int
    index: float
    height: float


class An900Detector:
    """Find a step where a moving sum rises through the middle of its last maximum and minimum.

    Analog Devices AN-900 (J. Scarlett, 2006), ``IsStep`` and what calls it; docs/pedometer.md
    derives the thresholds and says what its listing does wrong and what this does instead.

    The sum of the last eight samples stands for the middle of them, 3½ samples back.  So the
    crossing, found by a straight line between two sums, lies that far back too; it is the stamp of
    the step, and the samples up to it are the step's own.

    A walk begins with two rises of like height a step's time apart, each through the middle of its
    own ends, which is known when it turns down.  It ends when no crossing comes in a step's time;
    then all extremes are forgotten, so that no jolt hides the steps after it.  The first samples
    only fill the sum.
    """

    Settings: ClassVar[type[Settings]] = An900Settings
    RATE: ClassVar[int] = 30
    KERNELS: ClassVar[tuple[()]] = ()

    def __init__(self, settings: An900Settings, window: StepWindow) -> None:
        self.settings = settings
        self._window = window
        self._kept = round(LONGEST * self.RATE) + 2 * SUMMED
        self.reset()

    def reset(self) -> None:
        """Forget the walk and all samples."""
        self._history: deque[float] = deque(maxlen=self._kept)
        self._summands: deque[float] = deque(maxlen=SUMMED)
        self._sums: deque[float] = deque(maxlen=self._kept)
        self._count = 0
        self._slope = 0
        self._high = -inf
        self._low = inf
        self._last: _Landing | None = None
        self.walking = False

    def configure(self, settings: An900Settings) -> None:
        """Take over changed thresholds without touching the walk."""
        self.settings = settings

    def update(self, stamp_ns: int, magnitude: float) -> list[Step]:
        """Take the next magnitude [m/s²]; return the steps it proves, in order of time."""
        self._history.append(magnitude)
        self._summands.append(magnitude)
        self._count += 1
        if self._count < SUMMED:
            return []
        # Added up anew each time: no rounding gathers, and what the dead band hides is not lost.
        now = sum(self._summands)
        before = self._sums[-1] if self._sums else now
        if abs(now - before) < self.settings.dead_band:
            now = before
        self._sums.append(now)
        middle_ns = self._stamp_of(stamp_ns, self._count - 1 - LAG)
        if self._last is not None and middle_ns - self._last.stamp_ns > self._window.longest_ns:
            self._last = None
            self.walking = False
        rise = self._follow_slope(before, now)
        if rise:
            return self._begin(stamp_ns)
        if self.walking and self._slope == 1 and self._high > self._low:
            return self._go_on(stamp_ns)
        return []

    def finish(self) -> list[Step]:
        """Forget the walk: no step of it waits."""
        self.reset()
        return []

    def _follow_slope(self, before: float, now: float) -> bool:
        """Take note of maxima and minima; return whether a rise has ended before a walk."""
        threshold = self.settings.slope_threshold
        turned_down = False
        if now < before - threshold:
            turned_down = self._slope == 1
            if turned_down:
                self._high = max(self._high, before) if self.walking else before
            self._slope = -1
        elif now > before + threshold:
            if self._slope != 1:
                self._low = min(self._low, before) if self.walking else before
            self._slope = 1
        return turned_down and not self.walking

    def _stamp_of(self, newest_ns: int, index: float) -> int:
        """Return the stamp [ns] of a sample by its index."""
        back = (self._count - 1 - index) / self.RATE
        return newest_ns - round(back * NANOSECONDS)

    def _crossing(self, newest_ns: int, within: int) -> _Landing | None:
        """Return where the last sums, so many, rise through the middle of the extremes."""
        middle = 0.5 * (self._low + self._high)
        for back in range(min(within, len(self._sums) - 1)):
            before, now = self._sums[-2 - back], self._sums[-1 - back]
            if before <= middle < now:
                index = self._count - 1 - back - LAG - (now - middle) / (now - before)
                return _Landing(self._stamp_of(newest_ns, index), index, self._high - self._low)
        return None

    def _begin(self, newest_ns: int) -> list[Step]:
        """Take a rise while nobody walks: it may be the first step of a walk, or the second."""
        landing = self._crossing(newest_ns, round(LONGEST * self.RATE))
        if landing is None:
            return []
        first = self._last
        if first is None or first.height < LIKENESS * landing.height:
            self._last = landing
            return []
        if landing.stamp_ns - first.stamp_ns < self._window.shortest_ns:
            self._last = max(first, landing, key=lambda either: either.height)
            return []
        if landing.height < LIKENESS * first.height:
            return []
        self.walking = True
        self._low = inf
        second = self._step(first, landing)
        return [replace(second, stamp_ns=first.stamp_ns), second]

    def _go_on(self, newest_ns: int) -> list[Step]:
        """Look for the next step of a walk between the last two sums."""
        last, landing = self._last, self._crossing(newest_ns, 1)
        if last is None or landing is None:
            return []
        if landing.stamp_ns - last.stamp_ns < self._window.shortest_ns:
            return []
        self._high, self._low = -inf, inf
        return [self._step(last, landing)]

    def _step(self, last: _Landing, landing: _Landing) -> Step:
        self._last = landing
        gone = self._count - len(self._history)
        begin, end = (floor(each.index) + 1 - gone for each in (last, landing))
        return Step(
            landing.stamp_ns,
            (landing.stamp_ns - last.stamp_ns) / NANOSECONDS,
            tuple(islice(self._history, begin, end)),
            1.0 / self.RATE,
        )


DETECTOR = An900Detector
