"""Walks, and what counts their steps: the pedometer, and what stands beside it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, find_peaks, sosfiltfilt

from dead_reckoning.core.errors import RecordingError, SampleError
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.core.reference import an900
from dead_reckoning.core.resampler import Resampler
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS, ImuSample

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]

BAND = (0.7, 3.0)
"""Band of `find_peaks` [Hz]."""

PROMINENCE = 1.0
"""Smallest prominence of its peaks [m/s²], the best of those tried."""

PEAKS_RATE = 50.0
"""Rate it works at [Hz]; a recording that is slower keeps its own."""

SHORTEST = 3.0
"""What is shorter is no walk [s]."""

AN900_RATE = 30
"""Samples per second of AN-900 [Hz]."""

AN900_COUNTS = 4 * 409.6
"""What the four conversions of AN-900's ADXL330 add up to per g [counts]."""


@dataclass(frozen=True)
class Walk:
    """One recording: ``stamps_ns``, shape (n,), as they came; ``force_s``, shape (n, 3) [m/s²].

    ``landings_ns`` are the stamps of the ``true`` steps, where they are known.
    """

    name: str
    true: int
    stamps_ns: Stamps
    force_s: Array
    landings_ns: Stamps | None = None

    @property
    def seconds(self) -> float:
        """Time from the first stamp to the last [s]."""
        return float(np.ptp(self.stamps_ns)) / NANOSECONDS

    def varied(self, amplitude: float, duration: float) -> Walk:
        """Return a walk whose norm swings more about its median, and that takes longer."""
        norm = np.linalg.norm(self.force_s, axis=1, keepdims=True)
        middle = np.median(norm)
        swung = middle + amplitude * (norm - middle)
        scale = np.divide(swung, norm, out=np.zeros_like(norm), where=norm > 0.0)
        stamps_ns = self.stretched(self.stamps_ns, duration)
        return replace(self, stamps_ns=stamps_ns, force_s=self.force_s * scale, landings_ns=None)

    def stretched(self, stamps_ns: Stamps, duration: float) -> Stamps:
        """Return stamps so many times as far from the first."""
        first = self.stamps_ns[0]
        since: Stamps = np.round((stamps_ns - first) * duration).astype(np.int64)
        return first + since


@dataclass(frozen=True)
class Published:
    """What a pedometer gave, sample by sample; arrays of shape (steps,).

    ``stamps_ns`` of the steps; ``published_ns``, the newest stamp when each came out;
    ``going``, whether the walk was going on before; ``refused`` samples came too late or twice.
    """

    stamps_ns: Stamps
    published_ns: Stamps
    going: NDArray[np.bool_]
    refused: int

    @property
    def latency(self) -> Array:
        """How long after its stamp each step came out [s]."""
        late: Array = (self.published_ns - self.stamps_ns) / NANOSECONDS
        return late

    @property
    def steps_late(self) -> NDArray[np.int64]:
        """How many later steps had been made when each came out; of walks going on only."""
        stamps = np.sort(self.stamps_ns)
        made = np.searchsorted(stamps, self.published_ns, 'right')
        late: NDArray[np.int64] = made - np.searchsorted(stamps, self.stamps_ns, 'right')
        return late[self.going]


def published(walk: Walk, **settings: Any) -> Published:
    """Count by the pedometer with its defaults but for ``settings``, and those of its method."""
    chosen = PedometerSettings(**settings)
    pedometer = Pedometer(chosen, chosen.method_part())
    refused = newest_ns = 0
    steps: list[tuple[int, int, bool]] = []
    for stamp_ns, (x, y, z) in zip(walk.stamps_ns.tolist(), walk.force_s.tolist(), strict=True):
        going = pedometer.walking
        try:
            states = pedometer.update(ImuSample(stamp_ns, 'imu_link', (x, y, z)))
        except SampleError:
            refused += 1
            continue
        newest_ns = max(newest_ns, stamp_ns)
        steps += [(state.stamp_ns, newest_ns, going) for state in states if state.duration]
    # As a replay does at its end.
    steps += [(s.stamp_ns, newest_ns, True) for s in pedometer.flush() if s.duration]
    stamps, newest, went = np.array(steps, np.int64).reshape(-1, 3).T
    return Published(stamps, newest, went.astype(bool), refused)


def corrected(walk: Walk) -> Stamps:
    """Return the steps that AN-900 finds, corrected."""
    return published(walk, method='an900').stamps_ns


def as_printed(walk: Walk) -> Stamps:
    """Return the steps that AN-900's listing finds.

    Its x is the norm in counts of its sensor and ADC, its y zero: so it does not matter how the
    device was worn.
    """
    stamps_ns, norm = _cells(walk, AN900_RATE)
    x = np.rint(an900.ZERO_G + norm * (AN900_COUNTS / GRAVITY)).astype(np.int64)
    x = np.clip(x, an900.LOWEST, an900.HIGHEST)
    found = an900.run(np.stack((x, np.full_like(x, an900.ZERO_G)), axis=1))
    return stamps_ns[[step.sample for step in found]]


def peaks(walk: Walk) -> Stamps:
    """Return the peaks of the norm in the band of steps, which needs the whole recording."""
    order = np.argsort(walk.stamps_ns, kind='stable')
    first = walk.stamps_ns[order[0]]
    time = (walk.stamps_ns[order] - first) / NANOSECONDS
    rate = min(PEAKS_RATE, (len(time) - 1) / time[-1])
    norm = np.linalg.norm(walk.force_s[order], axis=1)
    even = np.interp(np.arange(0.0, time[-1], 1.0 / rate), time, norm)
    band = butter(2, BAND, 'bandpass', fs=rate, output='sos')
    found, _ = find_peaks(sosfiltfilt(band, even - even.mean()), prominence=PROMINENCE)
    since: Stamps = np.round(found / rate * NANOSECONDS).astype(np.int64)
    return first + since


def _cells(walk: Walk, rate: int) -> tuple[Stamps, Array]:
    """Return stamps and norms at a rate [Hz], from the samples in the order of their stamps."""
    stamps_ns, unique = np.unique(walk.stamps_ns, return_index=True)
    resampler = Resampler(rate)
    rows = zip(stamps_ns.tolist(), walk.force_s[unique].tolist(), strict=True)
    cells = [cell for stamp_ns, force in rows for cell in resampler.add(stamp_ns, force)]
    return np.array([stamp_ns for stamp_ns, _ in cells], np.int64), np.array([f for _, f in cells])


PEDOMETER = 'pedometer'

OTHERS: dict[str, Callable[[Walk], Stamps]] = {
    'AN-900, printed': as_printed,
    'AN-900, corrected': corrected,
    'find_peaks': peaks,
}
"""What stands beside the pedometer: AN-900, as printed and corrected, and peaks of the norm."""


@dataclass(frozen=True)
class Count:
    """What was counted on a walk, by name; ``published`` is the pedometer's."""

    walk: Walk
    published: Published
    found: dict[str, Stamps]


def count(walk: Walk) -> Count:
    """Count the steps with all settings at their defaults, and with the others.

    Raises `RecordingError` where the walk is too short for one of them.
    """
    if walk.seconds < SHORTEST:
        raise RecordingError(f'{walk.name}: {walk.seconds:g} s is no walk')
    ours = published(walk)
    found = {PEDOMETER: ours.stamps_ns} | {name: other(walk) for name, other in OTHERS.items()}
    return Count(walk, ours, found)
