"""A low-pass of one pole for each axis, as an RC circuit or a sensor's own filter makes it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class OnePole:
    """Filter ``ẏ = ω·(x − y)``, ω = 2π·corner, exactly for an x that is straight between samples.

    With a = ω/rate and e = y − x: ``e_k = exp(−a)·e_(k−1) − (1 − exp(−a))/a · (x_k − x_(k−1))``.
    So the lag is right at any rate, below the corner too.  It starts settled; a corner of zero
    lets everything pass.  However the samples are cut into calls, the result is the same.
    """

    def __init__(self, corner: Sequence[float], rate: float) -> None:
        """``corner`` of each axis [Hz]; ``rate`` of the samples [Hz]."""
        a = [2.0 * np.pi * frequency / rate for frequency in corner]
        self._memory = [float(np.exp(-value)) for value in a]
        self._gain = [float(-np.expm1(-value) / value) if value > 0.0 else 0.0 for value in a]
        self._lag = [0.0] * len(a)
        self._last: Array | None = None

    def filter(self, values: Array) -> Array:
        """Return the output for the next samples, both of shape (n, axes)."""
        if not len(values) or not any(self._gain):
            return values
        last = values[:1] if self._last is None else self._last
        steps = np.diff(values, axis=0, prepend=last)
        self._last = values[-1:]
        filtered = np.empty_like(values)
        for axis, (memory, gain) in enumerate(zip(self._memory, self._gain, strict=True)):
            drive = (gain * steps[:, axis]).tolist()
            # Plain floats: many times faster here than arrays of one row.
            lags = list(
                accumulate(drive, lambda e, d, m=memory: m * e - d, initial=self._lag[axis])  # type: ignore[misc]
            )[1:]
            self._lag[axis] = lags[-1]
            filtered[:, axis] = values[:, axis] + lags
        return filtered
