"""Give what the mbed page's program gives: integers up to the gain, doubles after it.

The tutorial *Dead Reckoning* of the mbed cookbook, sections 2 to 8, whose listings have lost the
branches of ``else`` and the line that counts quiet updates; here they are as its text describes
them.  An ``int`` has 32 bits and wraps; a division of two of them truncates toward zero.  What the
program does otherwise than one expects: ``docs/reference-algorithms.md``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Updates = list[tuple[float, float, float]]
"""Acceleration, velocity and position at the end of each update, in the units of the gain."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Constants:
    """The constants that the page leaves to its user.

    ``calibration_count``, ``sample_count``
        conversions of the zero and of an update, 1 or more.
    ``window_min``, ``window_max``
        accelerations from the one to the other, both included, count as none [counts].
    ``gain``
        acceleration per count.
    ``update_time``
        time of an update.
    ``no_movement``
        more quiet updates than this in a row end the movement, 0 or more.
    """

    calibration_count: int
    sample_count: int
    window_min: float
    window_max: float
    gain: float
    update_time: float
    no_movement: int


def run(counts: npt.NDArray[np.int64], constants: Constants) -> Updates:
    """Return all updates of a recording, shape (n,): its first conversions calibrate.

    What is left at the end and makes no whole update makes none.  A count has 16 bits there, sign
    extended: of a greater one, the low 16 count.
    """
    samples = counts.astype(np.int16).astype(np.int64)
    zero = means(samples[: constants.calibration_count], constants.calibration_count)[0]
    moving = means(samples[constants.calibration_count :], constants.sample_count)
    return integrate((moving - zero).tolist(), constants)


def means(samples: npt.NDArray[np.int64], count: int) -> npt.NDArray[np.int64]:
    """Return the averages of each so many samples, truncated toward zero.

    >>> means(np.array([-1, -2, 3, 4, 9]), 2).tolist()
    [-1, 3]
    """
    whole = len(samples) // count * count
    totals = samples[:whole].reshape(-1, count).sum(axis=1).astype(np.int32).astype(np.int64)
    truncated: npt.NDArray[np.int64] = np.sign(totals) * (np.abs(totals) // count)
    return truncated


def integrate(accelerations: Iterable[int], constants: Constants) -> Updates:
    """Return the updates that follow from averaged counts without their zero.

    The trapezoid is ``v += (a' + (a - a') / 2) · T`` with the last acceleration a', and the same
    again for the position, in this order of doubles.
    """
    low, high, gain = constants.window_min, constants.window_max, constants.gain
    time, no_movement = constants.update_time, constants.no_movement
    last_a = last_v = position = 0.0
    quiet = 0
    updates = []
    for count in accelerations:
        a = 0.0 if low <= count <= high else count * gain
        v = last_v + (last_a + ((a - last_a) / 2.0)) * time
        position = position + (last_v + ((v - last_v) / 2.0)) * time
        quiet = quiet + 1 if a == 0 else 0
        if quiet > no_movement:
            v = 0.0
            quiet = 0
        updates.append((a, v, position))
        last_a, last_v = a, v
    return updates
