"""What one run of the demo recorded, as arrays."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import ACCELERATION, GROUND_TRUTH, ODOMETRY

Array = NDArray[np.float64]


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


@dataclass(frozen=True, eq=False)
class Recording:
    """Truth, estimate and linear acceleration, shape (m, 3) [m/s²], of one run, world frame."""

    truth: Track
    estimate: Track
    acceleration_time: Array
    acceleration: Array

    @property
    def truth_at_estimate(self) -> Track:
        """The truth at the stamps of the estimate."""
        index = np.searchsorted(self.truth.time, self.estimate.time)
        t = self.truth
        return Track(t.time[index], t.position[index], t.velocity[index], t.deviation[index])

    @property
    def error_at_end(self) -> Array:
        """Where the estimate ends, less where the truth is then, shape (3,) [m]."""
        error: Array = self.estimate.position[-1] - self.truth_at_estimate.position[-1]
        return error


def parse(lines: Iterable[str]) -> Recording:
    """Read the lines of the node `recorder`.

    Raises `RecordingError` where a topic is missing, or an Odometry has no truth of its stamp.
    """
    rows: dict[str, dict[int, list[float]]] = {GROUND_TRUTH: {}, ODOMETRY: {}, ACCELERATION: {}}
    for line in lines:
        topic, stamp_ns, *numbers = line.split()
        rows[topic][int(stamp_ns)] = [float(number) for number in numbers]
    for topic, samples in rows.items():
        if not samples:
            raise RecordingError(f'nothing came on {topic}')
    start_ns = min(rows[GROUND_TRUTH])
    # A truth that is still on its way when the recording ends is no fault; one lost within is.
    last_ns = max(rows[GROUND_TRUTH])
    estimates = {ns: row for ns, row in rows[ODOMETRY].items() if start_ns <= ns <= last_ns}
    lost = [ns for ns in estimates if ns not in rows[GROUND_TRUTH]]
    if lost or not estimates:
        raise RecordingError(
            f'{len(lost)} of {len(estimates)} estimates have no truth beside them'
        )

    def table(samples: dict[int, list[float]]) -> tuple[Array, Array]:
        order = sorted(samples)
        time = (np.array(order, dtype=np.int64) - start_ns) / NANOSECONDS
        return time, np.array([samples[ns] for ns in order])

    def track(samples: dict[int, list[float]]) -> Track:
        time, values = table(samples)
        return Track(time, values[:, 0:3], values[:, 3:6], values[:, 6:9])

    acceleration_time, acceleration = table(rows[ACCELERATION])
    return Recording(
        track(rows[GROUND_TRUTH]), track(estimates), acceleration_time, acceleration[:, 0:3]
    )
