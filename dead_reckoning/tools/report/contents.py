"""What a report shows of one recording."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.blocks import AccelerationBlock, StateBlock
from dead_reckoning.core.chain import FAULT, NOTICE, Output
from dead_reckoning.core.errors import ReadingError, SampleError
from dead_reckoning.core.parameters import Derived, Parts, Settings
from dead_reckoning.core.stages import (
    ACCELERATION,
    DISTANCE,
    ODOMETRY,
    STEP_LENGTH,
    STEP_ODOMETRY,
    STEPS,
)

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class StepColumns:
    """Steps, a row each: stamp [ns], total, length [m], distance from the start [m]."""

    stamp_ns: Stamps
    step: NDArray[np.int64]
    step_length: Array
    distance: Array


@dataclass(frozen=True)
class Event:
    """Something that was said about a sample; ``dropped`` if that sample was not used."""

    stamp_ns: int
    kind: str
    words: str
    dropped: bool


@dataclass(frozen=True)
class Setting:
    """A parameter as it was used; ``default`` in words."""

    key: str
    value: str
    default: str
    changed: bool
    unit: str
    description: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Contents:
    """All that a report shows; what is not there is None or empty.

    ``name``
        of the recording.
    ``samples``
        how many it has, those that were dropped included.
    ``odometry``, ``acceleration``
        states and linear acceleration, world frame.
    ``steps``, ``walked``
        steps, and the states at them.
    ``events``, ``notices``
        what was dropped or found, and what was said: stamps [ns] and words.
    """

    name: str
    samples: int
    odometry: StateBlock | None = None
    acceleration: AccelerationBlock | None = None
    walked: StateBlock | None = None
    steps: StepColumns | None = None
    events: Sequence[Event] = ()
    notices: Sequence[tuple[int, str]] = ()
    settings: Sequence[Setting] = ()

    @classmethod
    def of(
        cls, name: str, samples: int, outputs: Iterable[Output], settings: Sequence[Setting] = ()
    ) -> Contents:
        """Sort the outputs of a chain of block stages."""
        by_name: dict[str, list[Any]] = {}
        for topic, value in outputs:
            by_name.setdefault(topic, []).append(value)
        return cls(
            name=name,
            samples=samples,
            odometry=_joined(by_name.get(ODOMETRY, ())),
            acceleration=_joined(by_name.get(ACCELERATION, ())),
            walked=_joined(by_name.get(STEP_ODOMETRY, ())),
            steps=_steps(by_name) if STEPS in by_name else None,
            events=[event(fault.stamp_ns, fault.value) for fault in by_name.get(FAULT, ())],
            notices=[(said.stamp_ns, said.value) for said in by_name.get(NOTICE, ())],
            settings=settings,
        )


def event(stamp_ns: int, error: Exception) -> Event:
    """Return what an error says about the sample with that stamp."""
    dropped = isinstance(error, (SampleError, ReadingError))
    return Event(stamp_ns, type(error).__name__, str(error), dropped)


def settings_of(settings: Parts, parts: Iterable[type[Settings]]) -> list[Setting]:
    """List the parameters of some parts, in their order."""
    listed = []
    for part in parts:
        used, default = settings[part].values(), part().values()
        for p in part.parameters():
            words = p.default.words if isinstance(p.default, Derived) else said(default[p.key])
            differs = used[p.key] != default[p.key]
            listed.append(Setting(p.key, said(used[p.key]), words, differs, p.unit, p.description))
    return listed


def said(value: Any) -> str:
    """Return a value as YAML has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f'[{", ".join(map(said, value))}]'
    return f'{value:g}' if isinstance(value, float) else str(value) or "''"


def _joined(blocks: Sequence[Any]) -> Any:
    """Return blocks as one, or None if there are none."""
    if len(blocks) < 2:
        return blocks[0] if blocks else None
    columns = {}
    for field in fields(blocks[0]):
        parts = [getattr(block, field.name) for block in blocks]
        columns[field.name] = parts[0] if isinstance(parts[0], str) else np.concatenate(parts)
    return type(blocks[0])(**columns)


def _steps(outputs: dict[str, list[Any]]) -> StepColumns:
    """Return the steps; length and distance, which come on change, are the last that came."""
    counted = [total for total in outputs[STEPS] if total.value > 0]
    stamp_ns = np.array([total.stamp_ns for total in counted], dtype=np.int64)

    def latest(name: str) -> Array:
        stamps = np.array([value.stamp_ns for value in outputs[name]])
        values = np.array([value.value for value in outputs[name]], dtype=float)
        found: Array = values[np.searchsorted(stamps, stamp_ns, side='right') - 1]
        return found

    step = np.array([total.value for total in counted], dtype=np.int64)
    return StepColumns(stamp_ns, step, latest(STEP_LENGTH), latest(DISTANCE))
