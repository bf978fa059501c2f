"""Find steps by the rhythm that walking has, whatever the sensor is worn on."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor
from typing import Any, ClassVar

import numpy as np

from dead_reckoning.core.kernels import rhythm
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.step_detectors import Step
from dead_reckoning.core.step_window import StepWindow


@dataclass(frozen=True, kw_only=True)
class RhythmSettings(Settings, prefix='pedometer.rhythm'):
    """What is a rhythm, what is a peak."""

    memory: float = parameter(
        2.0,
        'Memory of the autocorrelation; desk work looks like walking where it is shorter, slow '
        'walks do not where it is longer',
        unit='s',
        minimum=0.2,
        maximum=20.0,
        mutable=True,
    )
    floor: float = parameter(
        0.1,
        'Accelerations saturate above this, so that a rhythm counts by its regularity, not its '
        'strength; what is well below counts for little',
        unit='m/s²',
        minimum=1e-3,
        maximum=100.0,
        mutable=True,
    )
    faint: float = parameter(
        0.07,
        'Added to what normalizes the autocorrelation, at most 1: no rhythm is found in silence',
        minimum=1e-6,
        maximum=1.0,
        mutable=True,
    )
    centre: float = parameter(
        0.22,
        'Autocorrelation that says nothing for or against walking',
        minimum=0.0,
        maximum=1.0,
        mutable=True,
    )
    strong: float = parameter(
        0.52,
        'What is above this counts gain times as much besides, so that a clear rhythm is believed '
        'at once',
        minimum=0.0,
        maximum=1.0,
        mutable=True,
    )
    gain: float = parameter(12.5, 'How much that is', minimum=0.0, maximum=1000.0, mutable=True)
    open: float = parameter(
        3.0,
        'Evidence that begins a walk: autocorrelation above centre, times the time it lasts',
        unit='s',
        minimum=0.01,
        maximum=100.0,
        mutable=True,
    )
    close: float = parameter(
        0.5,
        'Evidence below which it ends',
        unit='s',
        minimum=0.0,
        maximum=100.0,
        mutable=True,
    )
    likeness: float = parameter(
        0.32,
        'Correlation of the two steps up to a peak with those a cycle before, from which on the '
        'peak is a step; below it waits for one that is',
        minimum=-1.0,
        maximum=1.0,
        mutable=True,
    )
    rise: float = parameter(
        0.25,
        'Least height of a peak, and depth after it',
        unit='m/s²',
        minimum=0.0,
        maximum=100.0,
        mutable=True,
    )
    share: float = parameter(
        0.3,
        'The same, as a part of the median of the last five peaks',
        minimum=0.0,
        maximum=1.0,
        mutable=True,
    )


class RhythmDetector:
    """Count the peaks of a magnitude while it repeats itself as walking does.

    The autocorrelation of the magnitude, which is saturated so that strength does not matter, says
    how regular it is, and how long a step lasts.  What it says adds up to evidence, and enough of
    that opens a gate; the peaks since the evidence began are counted then.  As long as the gate is
    open a peak is a step where the signal before it is like that a cycle before.  A step is
    stamped with the phase of its fundamental over the two steps around it, so it comes a step
    late.  docs/pedometer.md has the equations, and what each part is good for.
    """

    Settings: ClassVar[type[Settings]] = RhythmSettings
    RATE: ClassVar[int] = rhythm.RATE
    KERNELS: ClassVar[Any] = (
        (rhythm.take, (0.0, 0.0, 0.0, np.r_[np.ones(rhythm.RULES), rhythm.new_state()])),
        (rhythm.finish, (rhythm.new_state(),)),
    )

    def __init__(self, settings: RhythmSettings, window: StepWindow) -> None:
        self._window = window
        self._memory = np.empty(rhythm.RULES + rhythm.LENGTH)
        self._rules, self._state = np.split(self._memory, [rhythm.RULES])
        self.configure(settings)
        self.reset()

    def configure(self, settings: RhythmSettings) -> None:
        """Take over changed settings without touching the walk."""
        self.settings = settings
        rules = (
            1.0 / (settings.memory * rhythm.RATE), settings.floor, settings.faint, settings.centre,
            settings.strong, settings.gain, settings.open, settings.close, settings.likeness,
            settings.rise, settings.share,
        )  # fmt: skip
        self._rules[:] = *rules, *rhythm.coefficients()

    def reset(self) -> None:
        """Forget the walk and all samples."""
        self._state[:] = rhythm.new_state()
        self._newest_ns = 0
        self._before: float | None = None  # moment of the step before [samples]
        self.walking = False

    def update(self, stamp_ns: int, magnitude: float) -> list[Step]:
        """Take the next magnitude [m/s²]; return the steps it proves, in order of time."""
        self._newest_ns = stamp_ns
        window = self._window
        said = rhythm.take(magnitude, window.shortest, window.longest, self._memory)
        self.walking = said & 1 > 0
        return self._steps(said >> 1) if said > 1 else []

    def finish(self) -> list[Step]:
        """Return the steps that wait for samples after them, where none come; forget the walk."""
        steps = self._steps(rhythm.finish(self._state) // 2) if self.walking else []
        self.reset()
        return steps

    def _steps(self, count: int) -> list[Step]:
        """Return the steps that were found."""
        newest = float(self._state[rhythm.COUNT]) - 1.0
        found = self._state[rhythm.FOUND_AT : rhythm.FOUND_AT + 2 * count].tolist()
        steps = []
        for at, period in zip(found[::2], found[1::2], strict=True):
            duration = period
            if self._before is not None:
                at = max(at, self._before + 0.5 * period)
                since = at - self._before
                if since <= self._window.longest * rhythm.RATE:
                    duration = since
            self._before = at
            steps.append(
                Step(
                    self._newest_ns - round((newest - at) / rhythm.RATE * NANOSECONDS),
                    duration / rhythm.RATE,
                    self._between(at - duration, at),
                    1.0 / rhythm.RATE,
                )
            )
        return steps

    def _between(self, begin: float, end: float) -> tuple[float, ...]:
        """Return the magnitudes after one moment, up to another [samples], as far as kept."""
        newest = int(self._state[rhythm.COUNT]) - 1
        first = max(floor(begin) + 1, newest - rhythm.KEPT + 1, 0)
        after = min(floor(end), newest) + 1
        kept = self._state[rhythm.MAGNITUDE_AT : rhythm.MAGNITUDE_AT + rhythm.KEPT]
        low, high = first % rhythm.KEPT, after % rhythm.KEPT
        if low <= high:
            return tuple(kept[low:high].tolist())
        return (*kept[low:].tolist(), *kept[:high].tolist())


DETECTOR = RhythmDetector
