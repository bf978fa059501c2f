"""AN-900's pedometer as its listing computes it: integers, and floats of 32 bits.

For those who port it and want to compare; `dead_reckoning.core.step_detectors.an900` is what the
package itself counts with.  Source: Analog Devices AN-900, J. Scarlett, listing `ped.c`.  Each
peculiarity, and what it does: docs/reference-algorithms.md, "AN-900".
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
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
    magnitude = magnitudes(counts)
    samples = list(magnitude)
    found: list[Step] = []
    carried, last = 0, -1
    average_stride = distance = ZERO
    with np.errstate(divide='ignore', invalid='ignore'):
        for at in crossings(moving_sums(magnitude), corrected):
            step = samples[last + 1 - carried : at + 1]
            length = stride(step, carried, corrected)
            if len(found) < 2:
                average_stride = length
            else:
                others = Single(average - 1) * average_stride
                average_stride = (others + length) / Single(average)
            distance = distance + average_stride
            lengths = float(length), float(average_stride), len(found) + 1, float(distance)
            found.append(Step(at, *lengths))
            carried, last = SPAN, at
    return found


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


def crossings(sums: Singles, corrected: bool = False) -> Iterator[int]:
    """Yield the samples at which the listing's `IsStep` finds a step."""
    before = sums[FEWEST - 2 : -1]
    sums = sums[FEWEST - 1 :]
    rises = (sums > before + STEP_THRESHOLD).tolist()
    falls = (sums < before - STEP_THRESHOLD).tolist()
    # Up, down, or unknown at first: the listing's `stepflag` 1, 0 and 2.
    up: bool | None = None
    maximum, minimum = -NO_EXTREME, NO_EXTREME
    middle = below = 0.0
    changes = zip(sums.tolist(), before.tolist(), rises, falls, strict=True)
    for at, (total, old, rising, falling) in enumerate(changes, FEWEST - 1):
        if up:
            if total > middle and old < below and maximum > minimum:
                yield at
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


def stride(samples: Sequence[Single], carried: int, corrected: bool = False) -> Single:
    """Return the length of a step by equation (2), of all its samples.

    The first ``carried`` of them are the last of the step before.  They count for the mean, as
    far as `LATENCY` leaves them in, and not for maximum and minimum.
    """
    maximum, minimum = max(samples[carried:]), min(samples[carried:])
    inner = samples[LATENCY : len(samples) - LATENCY]
    mean = ZERO
    for sample in inner:
        mean = mean + sample
    mean = mean / Single(len(inner))
    velocity = displacement = ZERO
    for sample in inner:
        velocity = velocity + (sample - mean)
        displacement = displacement + velocity
    squared = displacement * (maximum - minimum) / (mean - minimum)
    size = abs(float(squared)) if corrected else _integer_abs(squared)
    return Single(math.sqrt(size)) * WALK_FUDGE


def _integer_abs(value: Single) -> int:
    """Return C's `abs` of a float: cut down to an integer first.

    Where C leaves open what that is, it is what the routines of ARM give: NaN is 0, and what 32
    bits do not hold is the nearest that they do.
    """
    return 0 if math.isnan(value) else int(min(abs(float(value)), LARGEST_INT))
