"""Drive the inertial navigator over recordings: as it is live, and smoothed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.configuration import Configuration, read_values
from dead_reckoning.core.blocks import ImuBlock, StateBlock
from dead_reckoning.core.chain import FAULT, Output
from dead_reckoning.core.errors import NotLevelledError, RecordingError, RepeatedStampError
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import NANOSECONDS, NOT_MEASURED, ImuSample, NavigationState
from dead_reckoning.core.smoother import Smoother
from dead_reckoning.core.stages import ODOMETRY
from dead_reckoning.core.stages import SMOOTHED as ODOMETRY_SMOOTHED
from dead_reckoning.core.strides import Strides

Array = NDArray[np.float64]
Values = Mapping[str, Any]
"""Parameters by their full names."""

START_NS = NANOSECONDS  # a stamp of 0 is none

PRESETS = Path(__file__).parents[2] / 'config'
FOOT = read_values(PRESETS / 'foot_mounted.yaml')
"""What all recordings of feet are taken with."""
HELD = read_values(PRESETS / 'inertial.yaml')
"""What a sensor in a hand is taken with."""
VEHICLE = read_values(PRESETS / 'vehicle.yaml')
"""What a vehicle is taken with."""

CAUSAL, STRIDES, SMOOTHED = 'causal', 'stride by stride', 'smoothed'
PROMPT = 'look-ahead 0'
"""Ways to navigate: `odom`, `odom_smoothed`, `smoothed.csv`, and `odom` without any delay."""

EXPECTED = (NotLevelledError, RepeatedStampError)
"""Samples refused: before it is aligned, and those that a recording has twice."""


@dataclass(frozen=True)
class Recording:
    """Samples of a sensor: ``time``, shape (n,) [s]; ``force_s`` [m/s²] and ``turn_s`` [rad/s],
    shapes (n, 3), in its frame.
    """  # fmt: skip

    name: str
    time: Array
    force_s: Array
    turn_s: Array

    @property
    def stamps_ns(self) -> NDArray[np.int64]:
        """Stamps, shape (n,)."""
        stamps: NDArray[np.int64] = START_NS + np.round(self.time * NANOSECONDS).astype(np.int64)
        return stamps

    def samples(self) -> Iterator[ImuSample]:
        """Give the samples one by one."""
        rows = (self.stamps_ns.tolist(), self.force_s.tolist(), self.turn_s.tolist())
        for stamp_ns, force, turn in zip(*rows, strict=True):
            yield ImuSample(stamp_ns, 'imu_link', tuple(force), angular_velocity=tuple(turn))

    def block(self) -> ImuBlock:
        """Give all samples."""
        n = len(self.time)
        unknown = np.zeros((n, 9))
        return ImuBlock(
            self.stamps_ns,
            'imu_link',
            self.force_s,
            unknown,
            self.turn_s,
            unknown,
            np.zeros((n, 4)),
            np.tile(NOT_MEASURED, (n, 1)),
        )


@dataclass(frozen=True)
class Way:
    """What the navigator made of a recording: states, strides [count] and ``length`` [m]."""

    states: StateBlock
    strides: int
    length: float

    @property
    def end(self) -> Array:
        """Where it ends, seen from where it began, shape (3,) [m]."""
        end: Array = self.states.position[-1] - self.states.position[0]
        return end

    @property
    def deviation(self) -> Array:
        """One sigma of the horizontal position as published, shape (n,) [m]."""
        sigma: Array = np.sqrt(self.states.position_covariance[:, [0, 4]].sum(axis=1))
        return sigma


def live(recording: Recording, values: Values) -> Way:
    """Give the samples to a pipeline, one by one; the states begin when it is aligned."""
    return _drive(Pipeline(Configuration(values)), recording)[0]


def in_blocks(recording: Recording, values: Values) -> Way:
    """Give the samples to a pipeline at once; the states are those of `live`."""
    pipeline = Pipeline(Configuration(values), blocks=True)
    navigator = pipeline.navigator
    assert navigator is not None
    outputs = pipeline.chain.push(navigator.settings.input, recording.block())
    outputs += pipeline.chain.end()
    found = []
    for name, value in outputs:
        if name == ODOMETRY:
            found.append(value)
        elif name == FAULT and not isinstance(value.value, EXPECTED):
            raise value.value
    if not found:
        raise RecordingError(f'{recording.name}: no rest to align at')
    return Way(StateBlock.join(found), navigator.strides.count, navigator.strides.distance)


def ways(recording: Recording, values: Values) -> dict[str, Way]:
    """Navigate in all ways; that smoothed at the end begins with the rest it is aligned at."""
    pipeline = Pipeline(Configuration({**values, 'navigator.smoothing': True}))
    assert pipeline.navigator is not None
    smoother = Smoother(pipeline.navigator)
    causal, strides = _drive(pipeline, recording)
    return {
        CAUSAL: causal,
        STRIDES: walked(StateBlock.of(strides)),
        SMOOTHED: walked(StateBlock.join(list(smoother.blocks())[::-1])),
        PROMPT: live(recording, {**values, 'navigator.look_ahead': 0.0}),
    }


def _drive(pipeline: Pipeline, recording: Recording) -> tuple[Way, list[NavigationState]]:
    """Return the way, and where it is smoothed stride by stride the states of that."""
    navigator = pipeline.navigator
    assert navigator is not None
    found: dict[str, list[NavigationState]] = {ODOMETRY: [], ODOMETRY_SMOOTHED: []}

    def take(outputs: list[Output]) -> None:
        for name, value in outputs:
            if name in found:
                found[name].append(value)
            elif name == FAULT and not isinstance(value, EXPECTED):
                raise value

    for imu in recording.samples():
        take(pipeline.chain.push(navigator.settings.input, imu))
    take(pipeline.chain.end())
    states, smoothed = found.values()
    if not states:
        raise RecordingError(f'{recording.name}: no rest to align at')
    strides = navigator.strides
    return Way(StateBlock.of(states), strides.count, strides.distance), smoothed


def walked(states: StateBlock) -> Way:
    """Count the strides of states."""
    strides = Strides()
    rows = zip(states.stationary.tolist(), states.position.tolist(), strict=True)
    for stationary, (x, y, z) in rows:
        strides.update(stationary, (x, y, z))
    return Way(states, strides.count, strides.distance)


def landings(states: StateBlock) -> NDArray[np.int64]:
    """Return the index of the first state, and that of the first of each stance after a stride."""
    strides = Strides()
    found = [0]
    rows = zip(states.stationary.tolist(), states.position.tolist(), strict=True)
    for index, (stationary, (x, y, z)) in enumerate(rows):
        strides.update(stationary, (x, y, z))
        if strides.count == len(found):
            found.append(index)
    return np.array(found)


def block_means(recording: Recording, rate: float) -> Recording:
    """Return a recording at a lower rate [Hz], each sample the mean of the time around it.

    The samples stand for the time half a step to each side; where a mean begins or ends within
    one, that part of it counts.
    """
    step = float(np.median(np.diff(recording.time)))
    edges = np.append(recording.time - 0.5 * step, recording.time[-1] + 0.5 * step)
    count = int((edges[-1] - edges[0]) * rate + 1e-6)
    cuts = edges[0] + np.arange(count + 1) / rate

    def means(signal: Array) -> Array:
        integral = np.vstack((np.zeros(3), np.cumsum(signal * np.diff(edges)[:, None], axis=0)))
        at_cuts = np.stack([np.interp(cuts, edges, column) for column in integral.T], axis=1)
        result: Array = np.diff(at_cuts, axis=0) * rate
        return result

    middles = 0.5 * (cuts[1:] + cuts[:-1])
    return Recording(recording.name, middles, means(recording.force_s), means(recording.turn_s))


def numbers(path: Path, data: Mapping[str, Any], keys: tuple[str, ...]) -> list[Any]:
    """Return arrays of an .npz; raises `RecordingError` where one is missing."""
    missing = [key for key in keys if key not in data]
    if missing:
        raise RecordingError(f'{path}: no {", ".join(missing)} in it; needed are {keys}')
    return [np.asarray(data[key], dtype=float) for key in keys]
