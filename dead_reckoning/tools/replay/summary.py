"""What a replay comes to in a few figures, whatever its length."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from dead_reckoning.core.blocks import ImuBlock, Stamped, Stamps, StateBlock
from dead_reckoning.core.chain import FAULT
from dead_reckoning.core.errors import DeadReckoningError, ReadingError, SampleError, WireError
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import DISTANCE, ODOMETRY, STEP_ODOMETRY, STEPS
from dead_reckoning.core.stamps import RESTART_NS
from dead_reckoning.core.strides import Strides, count_strides


@dataclass
class Fault:
    """How often a class of errors came, and what the first of them said."""

    first: DeadReckoningError
    count: int = 0

    @property
    def drops(self) -> bool:
        """Whether each of them cost a sample."""
        return isinstance(self.first, (SampleError, WireError, ReadingError))


class Summary:
    """Count and add up what goes into a chain and comes out of it, block by block.

    What the chain does not estimate is None.  A stamp that goes back by more than 1 s begins anew:
    duration and path go on from there, without the jump.
    """

    def __init__(self, pipeline: Pipeline) -> None:
        self.samples = 0
        self.faults: dict[str, Fault] = {}
        """By the name of the class."""
        self._input = pipeline.inputs[0]
        self._way = ODOMETRY if ODOMETRY in pipeline.outputs else STEP_ODOMETRY
        self._totals: dict[str, float] = {}
        if STEPS in pipeline.outputs:
            self._totals = {STEPS: 0, DISTANCE: 0.0}
        self._time = Extent()
        self._states = self._stationary = 0
        self._path = 0.0
        self._last: StateBlock | None = None
        self._walks: list[Strides] = []
        """Strides from each start on, where a navigator goes by stances."""
        navigator = pipeline.navigator
        settings = None if navigator is None else navigator.settings
        self._strides = bool(settings and settings.zero_velocity and not settings.nonholonomic)

    def takers(self) -> Mapping[str, Callable[[Any], object]]:
        """Return what it takes, by name."""
        return {
            self._input: self._count,
            self._way: self._follow,
            STEPS: lambda said: self._totals.update({STEPS: said.value}),
            DISTANCE: lambda said: self._totals.update({DISTANCE: said.value}),
            FAULT: self._note,
        }

    @property
    def dropped(self) -> dict[str, int]:
        """How many samples were lost to an estimator, by the cause."""
        return {name: fault.count for name, fault in self.faults.items() if fault.drops}

    def values(self) -> dict[str, Any]:
        """Return all figures by their names in summary.json."""
        duration = self._time.duration_ns / NANOSECONDS
        steps, distance = self._totals.get(STEPS), self._totals.get(DISTANCE)
        last, integrated = self._last, self._way == ODOMETRY
        way = self.way()
        return {
            'samples': self.samples,
            'duration_s': duration,
            'rate_hz': (self.samples - 1) / duration if duration > 0.0 else None,
            'steps': steps,
            'strides': way.get('strides', None if steps is None else steps // 2),
            'distance_m': way.get('distance') if distance is None else distance,
            'path_length_m': None if last is None else self._path,
            'end_position_m': None if last is None else last.position[-1].tolist(),
            'stationary_fraction': (
                self._stationary / self._states if integrated and self._states else None
            ),
            'dropped': self.dropped,
        }

    def way(self) -> dict[str, Any]:
        """Return strides and distance [m] from stance to stance; empty where no foot is."""
        if not self._strides:
            return {}
        return {
            'strides': sum(walk.count for walk in self._walks),
            'distance': sum(walk.distance for walk in self._walks),
        }

    def _count(self, block: ImuBlock) -> None:
        self.samples += len(block)
        self._time.add(block.stamp_ns)

    def _follow(self, block: StateBlock) -> None:
        stamps, position = block.stamp_ns, block.position
        if self._last is not None:
            stamps = np.append(self._last.stamp_ns, stamps)
            position = np.append(self._last.position, position, axis=0)
        moved = np.linalg.norm(np.diff(position, axis=0), axis=1)
        onward = np.diff(stamps) > 0
        self._path += float(moved[onward].sum())
        if self._strides:
            self._count_strides(block, np.flatnonzero(~onward) + 1 - len(stamps) + len(block))
        self._states += len(block)
        self._stationary += int(block.stationary.sum())
        self._last = block.part(len(block) - 1, len(block))

    def _count_strides(self, block: StateBlock, restarts: Stamps) -> None:
        """Count the strides of a block; before these of its states the stamps went back."""
        if not self._walks:
            self._walks.append(Strides())
        for begin, end in pairwise([0, *restarts.tolist(), len(block)]):
            if begin in restarts:
                self._walks.append(Strides())
            if end > begin:
                count_strides(self._walks[-1], block.part(begin, end))

    def _note(self, fault: Stamped) -> None:
        name = type(fault.value).__name__
        self.faults.setdefault(name, Fault(fault.value)).count += 1


class Extent:
    """The time that stamps cover: from the first to the latest, and anew after a restart."""

    def __init__(self) -> None:
        self._before_ns = 0
        self._first_ns = self._latest_ns = 0

    @property
    def duration_ns(self) -> int:
        """Time covered so far [ns]."""
        return self._before_ns + self._latest_ns - self._first_ns

    def add(self, stamps: Stamps) -> None:
        """Take stamps in the order they came; zero is none."""
        stamps = stamps[stamps != 0]
        if len(stamps) and not self._first_ns:
            self._first_ns = self._latest_ns = int(stamps[0])
        while len(stamps):
            latest = np.maximum.accumulate(np.append(self._latest_ns, stamps))[:-1]
            back = latest - stamps >= RESTART_NS
            end = int(back.argmax()) if back.any() else len(stamps)
            self._latest_ns = int(stamps[:end].max(initial=self._latest_ns))
            stamps = stamps[end:]
            if len(stamps):
                self._before_ns = self.duration_ns
                self._first_ns = self._latest_ns = int(stamps[0])
