"""AN-900's step finder: a moving sum that crosses its own mean after a maximum and a minimum."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from itertools import islice
from math import floor
from typing import ClassVar, TypeGuard

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.step_detectors import Step
from dead_reckoning.core.step_window import LONGEST, StepWindow

SUMMED = 8
LAG = (SUMMED - 1) / 2
"""So many samples before the newest lies the moment that their sum stands for."""


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
class _Extreme:
    """A maximum or minimum of the moving sum, and the count of samples by then."""

    value: float
    at: int


class An900Detector:
    """Find a step where a moving sum rises through the middle of its last maximum and minimum.

    Analog Devices AN-900 (J. Scarlett, 2006), ``IsStep`` and what calls it; docs/pedometer.md
    derives the thresholds and says what its listing does wrong and what this does instead.

    The sum of the last eight samples stands for the middle of them, 3½ samples back.  So the
    crossing, found by a straight line between two sums, lies that far back too; it is the stamp of
    the step, and the samples up to it are the step's own.  Extremes older than the longest step
    are forgotten, so that no jolt hides the steps after it; where a walk begins from rest, rest is
    the maximum before its first minimum.  The first samples only fill the sum.
    """

    Settings: ClassVar[type[Settings]] = An900Settings
    RATE: ClassVar[int] = 30

    def __init__(self, settings: An900Settings, window: StepWindow) -> None:
        self.settings = settings
        self._window = window
        self._kept = round(LONGEST * self.RATE) + 2 * SUMMED
        self.reset()

    def reset(self) -> None:
        """Forget the walk and all samples."""
        self._window.reset()
        self._history: deque[float] = deque(maxlen=self._kept)
        self._summands: deque[float] = deque(maxlen=SUMMED)
        self._sum: float | None = None
        self._count = 0
        self._boundary = 0
        self._forget_slope()

    def _forget_slope(self) -> None:
        self._slope = 0
        self._moved_at = self._count
        self._high: _Extreme | None = None
        self._low: _Extreme | None = None

    @property
    def walking(self) -> bool:
        """Whether a walk goes on."""
        return self._window.walking

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
        before = now if self._sum is None else self._sum
        if abs(now - before) < self.settings.dead_band:
            now = before
        self._sum = now
        self._follow_slope(before, now)
        self._window.expire(self._stamp_of(stamp_ns, self._count - 1 - LAG))
        high, low = self._high, self._low
        if self._slope < 1 or not (self._fresh(high) and self._fresh(low)):
            return []
        middle = 0.5 * (high.value + low.value)
        if not (low.value < high.value and before <= middle < now):
            return []
        return self._land(stamp_ns, self._count - 1 - LAG - (now - middle) / (now - before))

    def _follow_slope(self, before: float, now: float) -> None:
        threshold = self.settings.slope_threshold
        if now < before - threshold:
            if self._slope != -1:
                self._slope = -1
                if not self._fresh(self._high) or before > self._high.value:
                    self._high = _Extreme(before, self._count)
            self._moved_at = self._count
        elif now > before + threshold:
            if self._slope != 1:
                self._slope = 1
                if not self._fresh(self._low) or before < self._low.value:
                    self._low = _Extreme(before, self._count)
            self._moved_at = self._count
        elif self._stale(self._moved_at):
            self._forget_slope()

    def _stale(self, at: int) -> bool:
        return (self._count - at) * NANOSECONDS > self._window.longest_ns * self.RATE

    def _fresh(self, extreme: _Extreme | None) -> TypeGuard[_Extreme]:
        return extreme is not None and not self._stale(extreme.at)

    def _stamp_of(self, newest_ns: int, index: float) -> int:
        """Return the stamp [ns] of a sample by its index, which may lie between two."""
        back = (self._count - 1 - index) / self.RATE
        return newest_ns - round(back * NANOSECONDS)

    def _land(self, newest_ns: int, index: float) -> list[Step]:
        """Take a crossing, by the index of the sample there, for a landing."""
        stamp_ns = self._stamp_of(newest_ns, index)
        if self._window.too_soon(stamp_ns):
            return []
        last_ns, begin, end = self._window.last_ns, self._boundary, floor(index) + 1
        self._boundary = end
        self._high = self._low = None
        proven = self._window.land(stamp_ns)
        if last_ns is None or not proven:
            return []
        gone = self._count - len(self._history)
        samples = tuple(islice(self._history, begin - gone, end - gone))
        duration = (stamp_ns - last_ns) / NANOSECONDS
        return [Step(at_ns, duration, samples, 1.0 / self.RATE) for at_ns in proven]


DETECTOR = An900Detector
