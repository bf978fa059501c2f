"""One trial of BROAD, read from an .npz; docs/accuracy.md says how to make it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.samples import NANOSECONDS, ImuSample

Array = NDArray[np.float64]

KEYS = ('acc', 'gyr', 'quat_wxyz_enu', 'pos', 'movement', 'fs')

START_NS = NANOSECONDS  # a stamp of 0 is none


@dataclass(frozen=True)
class Trial:
    """Samples at ``rate`` [Hz]; what the optical system did not see is NaN.

    ``force_s`` [m/s²] and ``turn_s`` [rad/s], shapes (n, 3), frame of the sensor; ``attitude``
    (x, y, z, w), shape (n, 4), sensor to ENU; ``position_w`` [m], shape (n, 3), of the markers;
    ``moving``, shape (n,), as the authors marked it.
    """

    rate: float
    force_s: Array
    turn_s: Array
    attitude: Array
    position_w: Array
    moving: NDArray[np.bool_]

    def samples(self) -> list[ImuSample]:
        """Return the samples; unseen ones carry no orientation."""
        seconds = np.arange(len(self.force_s)) / self.rate
        stamps_ns = START_NS + np.round(seconds * NANOSECONDS).astype(np.int64)
        seen = ~np.isnan(self.attitude).any(axis=1)
        rows = zip(
            stamps_ns.tolist(),
            self.force_s.tolist(),
            self.turn_s.tolist(),
            self.attitude.tolist(),
            seen.tolist(),
            strict=True,
        )
        return [
            ImuSample(
                stamp_ns,
                'imu_link',
                tuple(force),
                angular_velocity=tuple(turn),
                orientation=tuple(attitude) if oriented else None,
            )
            for stamp_ns, force, turn, attitude, oriented in rows
        ]


def load(path: Path) -> Trial:
    """Read one trial; raises `RecordingError` where something is missing."""
    with np.load(path) as data:
        missing = [key for key in KEYS if key not in data]
        if missing:
            raise RecordingError(f'{path}: no {", ".join(missing)} in it; needed are {KEYS}')
        values = {key: np.asarray(data[key], dtype=float) for key in KEYS}
    w, x, y, z = values['quat_wxyz_enu'].T
    return Trial(
        float(values['fs']),
        values['acc'],
        values['gyr'],
        np.stack((x, y, z, w), axis=1),
        values['pos'],
        values['movement'].astype(bool),
    )
