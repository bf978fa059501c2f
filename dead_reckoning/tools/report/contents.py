"""What a report shows of one recording, and how it is gathered from a chain."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.blocks import AccelerationBlock, ImuBlock, Stamped, StateBlock
from dead_reckoning.core.chain import FAULT, NOTICE
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import ReadingError, SampleError, WireError
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.parameters import Derived, Parts, Settings
from dead_reckoning.core.pedometer import PedometerSettings, PedometerState
from dead_reckoning.core.pipeline import INTEGRATOR, NAVIGATOR, PEDOMETER, PipelineSettings
from dead_reckoning.core.stages import (
    ACCELERATION,
    ODOMETRY,
    STEP,
    STEP_ODOMETRY,
    STEPS,
)

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]

FORCE = 'specific force'
"""Name of what is gathered of the input."""

PLANE = (0, 1, 4, 8)
"""Where a covariance, shape (3, 3), has xx, xy, yy and zz."""


@dataclass(frozen=True, eq=False)
class Track:
    """States, world frame, a row each.

    Stamp [ns], position [m], velocity [m/s], xx, xy, yy and zz of the position's covariance [m²],
    and whether the sensor was taken to rest.
    """

    stamp_ns: Stamps
    position: Array
    velocity: Array
    covariance: Array
    stationary: NDArray[np.bool_]

    @property
    def sigma(self) -> Array:
        """The standard deviation of the position, shape (n, 3) [m]."""
        deviation: Array = np.sqrt(np.maximum(self.covariance[:, (0, 2, 3)], 0.0))
        return deviation


@dataclass(frozen=True, eq=False)
class Accelerations:
    """Linear acceleration, world frame, or specific force, the sensor's, for each stamp [ns].

    A row each [m/s²].
    """

    stamp_ns: Stamps
    acceleration: Array


@dataclass(frozen=True, eq=False)
class Steps:
    """Steps, a row each: stamp [ns], total, length [m], distance from the start [m]."""

    stamp_ns: Stamps
    step: NDArray[np.int64]
    step_length: Array
    distance: Array


@dataclass(frozen=True)
class Fault:
    """A class of errors: what the first said, whether each cost a sample, the samples' stamps."""

    kind: str
    words: str
    dropped: bool
    stamp_ns: list[int] = field(default_factory=list)


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
        of the integrator or navigator.
    ``force``
        specific force of the samples behind the states, where there is no linear acceleration.
    ``walked``, ``steps``
        of the pedometer.
    ``strides``, ``distance``
        of a navigator on a foot, from stance to stance [m].
    ``faults``, ``notices``
        what was dropped or found; what was said, with its stamp [ns].
    """

    name: str
    samples: int
    odometry: Track | None = None
    acceleration: Accelerations | None = None
    force: Accelerations | None = None
    walked: Track | None = None
    steps: Steps | None = None
    faults: Sequence[Fault] = ()
    notices: Sequence[tuple[int, str]] = ()
    settings: Sequence[Setting] = ()
    strides: int | None = None
    distance: float | None = None


class Collector:
    """Gather what comes out of a chain of block stages, no more of it than is shown.

    ``imu`` names the input whose specific force is shown, where no linear acceleration comes out.
    """

    def __init__(self, imu: str | None = None) -> None:
        self._imu = imu
        self._columns: dict[str, list[tuple[Any, ...]]] = {}
        self._steps: list[PedometerState] = []
        self._counts = False
        self._faults: dict[str, Fault] = {}
        self._notices: list[tuple[int, str]] = []

    def takers(self) -> Mapping[str, Callable[[Any], object]]:
        """Return what it takes, by name."""
        force = {} if self._imu is None else {self._imu: self._add_force}
        return {
            **force,
            ODOMETRY: lambda block: self._add(ODOMETRY, _track(block)),
            STEP_ODOMETRY: lambda block: self._add(STEP_ODOMETRY, _track(block)),
            ACCELERATION: lambda block: self._add(ACCELERATION, _acceleration(block)),
            STEPS: self._begin,
            STEP: lambda said: self._steps.append(said.value),
            FAULT: self._note,
            NOTICE: lambda said: self._notices.append((said.stamp_ns, said.value)),
        }

    def contents(self, name: str, samples: int, **more: Any) -> Contents:
        """Return all that came, with ``more`` that does not come out of a chain."""
        odometry, walked, acceleration, force = (
            [np.concatenate(parts) for parts in zip(*self._columns[topic], strict=True)]
            if topic in self._columns
            else None
            for topic in (ODOMETRY, STEP_ODOMETRY, ACCELERATION, FORCE)
        )
        if force:
            # Not those of samples that can't be used, whose stamps may be anything.
            used = np.isin(force[0], odometry[0]) if odometry else np.zeros(len(force[0]), bool)
            force = [column[used] for column in force]
        return Contents(
            name=name,
            samples=samples,
            odometry=Track(*odometry) if odometry else None,
            acceleration=Accelerations(*acceleration) if acceleration else None,
            force=Accelerations(*force) if force else None,
            walked=Track(*walked) if walked else None,
            steps=_steps(self._steps) if self._counts else None,
            faults=list(self._faults.values()),
            notices=self._notices,
            **more,
        )

    def _add(self, topic: str, columns: tuple[Any, ...]) -> None:
        self._columns.setdefault(topic, []).append(columns)

    def _add_force(self, block: ImuBlock) -> None:
        self._add(FORCE, (block.stamp_ns, block.specific_force))

    def _begin(self, _: Stamped) -> None:
        self._counts = True

    def _note(self, fault: Stamped) -> None:
        error = fault.value
        kind = type(error).__name__
        if kind not in self._faults:
            dropped = isinstance(error, (SampleError, WireError, ReadingError))
            self._faults[kind] = Fault(kind, str(error), dropped)
        self._faults[kind].stamp_ns.append(fault.stamp_ns)


def settings_of(settings: Parts) -> list[Setting]:
    """List the parameters of the parts that the estimators use."""
    listed = []
    for part in _used(settings):
        used, default = settings[part].values(), part().values()
        for p in part.parameters():
            words = p.default.words if isinstance(p.default, Derived) else said(default[p.key])
            differs = used[p.key] != default[p.key]
            listed.append(Setting(p.key, said(used[p.key]), words, differs, p.unit, p.description))
    return listed


def _used(settings: Parts) -> list[type[Settings]]:
    estimators, pedometer = settings[PipelineSettings].estimators, settings[PedometerSettings]
    parts: list[type[Settings]] = [PipelineSettings]
    if estimators != (NAVIGATOR,):
        parts.append(GravitySettings)
    if INTEGRATOR in estimators:
        parts.append(IntegratorSettings)
    if NAVIGATOR in estimators:
        parts += [NavigatorSettings, *settings[NavigatorSettings].detector_parts]
    if PEDOMETER in estimators:
        parts += [PedometerSettings, pedometer.method_part]
    return [*parts, CommonSettings, FrameSettings]


def said(value: Any) -> str:
    """Return a value as YAML has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f'[{", ".join(map(said, value))}]'
    return f'{value:g}' if isinstance(value, float) else str(value) or "''"


def _track(block: StateBlock) -> tuple[Any, ...]:
    covariance = block.position_covariance[:, PLANE]
    return block.stamp_ns, block.position, block.velocity, covariance, block.stationary


def _acceleration(block: AccelerationBlock) -> tuple[Any, ...]:
    return block.stamp_ns, block.acceleration


def _steps(states: Sequence[PedometerState]) -> Steps:
    rows = [(s.stamp_ns, s.steps, s.step_length, s.distance) for s in states]
    stamp_ns, step, step_length, distance = np.array(rows, dtype=object).reshape(-1, 4).T
    return Steps(
        stamp_ns.astype(np.int64),
        step.astype(np.int64),
        step_length.astype(float),
        distance.astype(float),
    )
