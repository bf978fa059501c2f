"""What one run of the demo recorded, as arrays."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import GROUND_TRUTH

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Series:
    """Numbers, shape (n, m), at n times [s] from the first truth on."""

    time: Array
    values: Array


@dataclass(frozen=True, eq=False)
class Track:
    """Position [m], velocity [m/s], deviation of position [m], shapes (n, 3), at n times [s]."""

    time: Array
    position: Array
    velocity: Array
    deviation: Array

    @property
    def length(self) -> float:
        """Length of the way [m]."""
        return float(np.linalg.norm(np.diff(self.position, axis=0), axis=1).sum())

    def at(self, time: Array) -> Track:
        """Return the track at other times, shape (m,) [s], by straight lines between its own."""
        position, velocity, deviation = (
            np.column_stack([np.interp(time, self.time, column) for column in part.T])
            for part in (self.position, self.velocity, self.deviation)
        )
        return Track(time, position, velocity, deviation)


class Recording:
    """All that came of one run, in the world frame."""

    def __init__(self, series: Mapping[str, Series]) -> None:
        """``series`` by topic."""
        self.series = series

    def track(self, topic: str) -> Track:
        """Return an Odometry topic, up to where the truth ends."""
        series, end = self.series[topic], self.series[GROUND_TRUTH].time[-1]
        within = (series.time >= 0.0) & (series.time <= end)
        if not within.any():
            raise RecordingError(f'nothing came on {topic} while there was truth')
        values = series.values[within]
        return Track(series.time[within], values[:, 0:3], values[:, 3:6], values[:, 6:9])

    @property
    def truth(self) -> Track:
        """The truth."""
        return self.track(GROUND_TRUTH)


def parse(lines: Iterable[str], topics: Collection[str]) -> Recording:
    """Read the lines of the node `recorder`.

    Lines that name no topic of these are left out, and what came before the first truth.

    Raises `RecordingError` where one of ``topics`` is missing.
    """
    rows: dict[str, dict[int, list[float]]] = {GROUND_TRUTH: {}, **{name: {} for name in topics}}
    for line in lines:
        topic, stamp_ns, *numbers = line.split()
        if topic in rows:
            rows[topic][int(stamp_ns)] = [float(number) for number in numbers]
    start_ns = min(rows[GROUND_TRUTH], default=0)
    for topic, samples in rows.items():
        if not samples or max(samples) < start_ns:
            raise RecordingError(f'nothing came on {topic}')

    def series(samples: dict[int, list[float]]) -> Series:
        order = sorted(ns for ns in samples if ns >= start_ns)
        time = (np.array(order, dtype=np.int64) - start_ns) / NANOSECONDS
        return Series(time, np.array([samples[ns] for ns in order]))

    return Recording({topic: series(samples) for topic, samples in rows.items()})
