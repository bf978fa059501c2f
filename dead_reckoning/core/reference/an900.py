"""AN-900's pedometer as its listing computes it: integers, and floats of 32 bits.

For those who port it and want to compare; `dead_reckoning.core.step_detectors.an900` is what the
package itself counts with.  Source: Analog Devices AN-900, J. Scarlett, listing `ped.c`.  Each
peculiarity, and what it does: docs/reference-algorithms.md, "AN-900".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Single = np.float32
Singles = NDArray[np.float32]
Counts = NDArray[np.int64]

LOWEST, HIGHEST = 0, 4 * 4095
"""What the sum of four conversions of 12 bits can be [counts]."""

ZERO_G = 4 * 2048
"""What the four conversions of an axis sum up to where no force acts [counts]."""

SPAN = 8
"""How many magnitudes the moving sum has."""

FEWEST = SPAN + 1
"""How many samples there must be before a step is looked for."""

LATENCY = SPAN // 2
"""By how many samples the moving sum is taken to lag."""

STEP_THRESHOLD = Single(5.0)
"""Change of the sum from one sample to the next that is a slope [counts]."""

DEAD_BAND = Single(1.0)
"""Change of the sum below which it is put back [counts]."""

WALK_FUDGE = Single(0.0249)
"""Length of a step over the root in equation (2), of counts; no unit is given."""

NO_EXTREME = 10000.0
"""Where the minimum of the sum starts; the maximum starts at minus this."""

LARGEST_INT = 2**31 - 1

ZERO = Single(0.0)


@dataclass(frozen=True, slots=True)
class Step:
    """Tell where a step was found and what the listing knows after it.

    ``sample`` counts from 0.  ``stride`` is the listing's word for the length of one step;
    ``average_stride`` and ``distance``, their sum, are in its unit.
    """

    sample: int
    stride: float
    average_stride: float
    steps: int
    distance: float


def run(counts: Counts, *, corrected: bool = False, average: int = 1) -> list[Step]:
    """List the steps the listing counts from its start button on.

    ``counts``, shape (n, 2), are what its `get_sample` returns for x and y: sums of four
    conversions, from `LOWEST` to `HIGHEST`.  ``corrected`` repairs the parenthesis in the middle
    of maximum and minimum, and takes absolute values of floats; nothing else differs.
    ``average`` is `avgconst`, from 1 on.

    Nothing overruns: of a pause all samples are kept, however long.  Where the listing divides by
    zero, the corrected stride is infinite or NaN, and so is the distance from then on.
    """
    samples = magnitudes(counts)
    found = crossings(moving_sums(samples), corrected)
    lengths = strides(samples, found, corrected)
    averages = averaged(lengths, average)
    # Added up one after the other, in 32 bits.
    distances = np.add.accumulate(averages)
    numbers = range(1, len(found) + 1)
    rows = (lengths.tolist(), averages.tolist(), numbers, distances.tolist())
    return [Step(*row) for row in zip(found, *rows, strict=True)]


def magnitudes(counts: Counts) -> Singles:
    """Return the listing's vector sum of each sample, shape (n,) [counts].

    >>> magnitudes(np.array([[8192 + 1200, 8192 - 1600]]))
    array([500.], dtype=float32)
    """
    x, y = (counts - ZERO_G).T
    # The squares fit its unsigned integers; the cast to float rounds, the root is of doubles.
    square = (x * x + y * y).astype(Single)
    root: Singles = np.sqrt(square.astype(np.float64) / 16.0).astype(Single)
    return root


def moving_sums(samples: Singles) -> Singles:
    """Return the sum of the last eight after each sample, shape (n,), with what stays in it.

    It is carried on, not added up anew, so it keeps what rounding leaves, and what is lost where
    it is put back since it changed by less than `DEAD_BAND`.
    """
    sums = []
    old = total = ZERO
    for leaving, sample in zip([ZERO] * SPAN + list(samples[:-SPAN]), samples, strict=False):
        total = total - leaving + sample
        # The listing's integer `abs` makes no difference here: below 1 it is 0.
        if abs(total - old) < DEAD_BAND:
            total = old
        sums.append(total)
        if len(sums) >= SPAN:
            old = total
    return np.array(sums, Single)


def crossings(sums: Singles, corrected: bool = False) -> list[int]:
    """Return the samples at which the listing's `IsStep` finds a step."""
    before = sums[FEWEST - 2 : -1]
    sums = sums[FEWEST - 1 :]
    rises = (sums > before + STEP_THRESHOLD).tolist()
    falls = (sums < before - STEP_THRESHOLD).tolist()
    # Up, down, or unknown at first: the listing's `stepflag` 1, 0 and 2.
    up: bool | None = None
    maximum, minimum = -NO_EXTREME, NO_EXTREME
    middle = below = 0.0
    found = []
    changes = zip(sums.tolist(), before.tolist(), rises, falls, strict=True)
    for at, (total, old, rising, falling) in enumerate(changes, FEWEST - 1):
        if up:
            if total > middle and old < below and maximum > minimum:
                found.append(at)
                maximum, minimum = -NO_EXTREME, NO_EXTREME
            elif falling:
                up = False
                if old > maximum:
                    maximum = old
        elif rising:
            if up is not None and old < minimum:
                minimum = old
            up = True
            # A sum of doubles, rounded once: of 32-bit floats it would be no other.
            middle = below = float(Single((maximum + minimum) / 2.0))
            if not corrected:
                below = float(Single(maximum + minimum / 2.0))
        elif falling:
            up = False
    return found


def strides(samples: Singles, found: Sequence[int], corrected: bool = False) -> Singles:
    """Return the length of each step by equation (2), shape (steps,).

    Maximum and minimum are of the samples after the step before.  The mean and the double sum
    take the last `SPAN` of that one too, and leave out `LATENCY` at both ends.
    """
    if not len(found):
        return np.zeros(0, Single)
    ends = np.array(found) + 1
    fresh = np.concatenate(([0], ends[:-1]))
    maximum = np.maximum.reduceat(samples[: ends[-1]], fresh)
    minimum = np.minimum.reduceat(samples[: ends[-1]], fresh)
    begins = np.concatenate(([0], ends[:-1] - SPAN))
    mean, displacement = np.zeros((2, len(ends)), Single)
    # Steps of one length are computed at once; `accumulate` adds as the listing does, one after
    # the other in 32 bits, where `sum` would not.
    lengths = ends - begins
    for length in np.unique(lengths):
        (chosen,) = np.nonzero(lengths == length)
        inner = samples[begins[chosen, None] + np.arange(LATENCY, length - LATENCY)]
        means = np.add.accumulate(inner, axis=1)[:, -1] / Single(length - SPAN)
        velocities = np.add.accumulate(inner - means[:, None], axis=1)
        mean[chosen] = means
        displacement[chosen] = np.add.accumulate(velocities, axis=1)[:, -1]
    with np.errstate(divide='ignore', invalid='ignore'):
        squared = displacement * (maximum - minimum) / (mean - minimum)
    size = np.abs(squared.astype(np.float64))
    if not corrected:
        size = _whole(size)
    lengths_of_steps: Singles = np.sqrt(size).astype(Single) * WALK_FUDGE
    return lengths_of_steps


def averaged(lengths: Singles, average: int) -> Singles:
    """Return the listing's exponential average; the first two steps stand for themselves."""
    weight, others = Single(average), Single(average - 1)
    averages: list[Single] = []
    with np.errstate(invalid='ignore'):
        for length in lengths:
            if len(averages) >= 2:
                length = (others * averages[-1] + length) / weight
            averages.append(length)
    return np.array(averages, Single)


def _whole(size: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cut sizes down to integers, as C's `abs` of a float does before all else.

    Where C leaves open what that is, it is what the routines of ARM give: NaN is 0, and what 32
    bits do not hold is the nearest that they do.
    """
    whole: NDArray[np.float64] = np.trunc(np.nan_to_num(np.minimum(size, LARGEST_INT), nan=0.0))
    return whole
