"""Give what the mbed page's program gives: integers up to the gain, doubles after it.

The tutorial *Dead Reckoning* of the mbed cookbook, sections 2 to 8, whose listings have lost the
branches of ``else`` and the line that counts quiet updates; here they are as its text describes
them.  An ``int`` has 32 bits and wraps; a division of two of them truncates toward zero.  What the
program does otherwise than one expects: ``docs/reference-algorithms.md``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Doubles = npt.NDArray[np.float64]


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


def run(counts: npt.NDArray[np.int64], constants: Constants) -> Doubles:
    """Return all updates of a recording, shape (n,): its first conversions calibrate.

    An update is a row of `integrate`.

    What is left at the end and makes no whole update makes none.  A count has 16 bits there, sign
    extended: of a greater one, the low 16 count.
    """
    samples = counts.astype(np.int16).astype(np.int64)
    zero = means(samples[: constants.calibration_count], constants.calibration_count)[0]
    moving = means(samples[constants.calibration_count :], constants.sample_count)
    return integrate(moving - zero, constants)


def means(samples: npt.NDArray[np.int64], count: int) -> npt.NDArray[np.int64]:
    """Return the averages of each so many samples, truncated toward zero.

    >>> means(np.array([-1, -2, 3, 4, 9]), 2).tolist()
    [-1, 3]
    """
    whole = len(samples) // count * count
    totals = samples[:whole].reshape(-1, count).sum(axis=1).astype(np.int32).astype(np.int64)
    truncated: npt.NDArray[np.int64] = np.sign(totals) * (np.abs(totals) // count)
    return truncated


def integrate(averages: npt.NDArray[np.int64], constants: Constants) -> Doubles:
    """Return the updates that follow from averages without their zero, shape (n,) [counts].

    A row is acceleration, velocity and position at the end of an update, in the units of the gain:
    shape (n, 3).  The trapezoid is ``v += (a' + (a - a') / 2) · T`` with the last acceleration a',
    and the same again for the position, in this order of doubles.
    """
    quiet = (constants.window_min <= averages) & (averages <= constants.window_max)
    accelerations = np.where(quiet, 0.0, averages * constants.gain)
    steps = _trapezoids(_before(accelerations), accelerations, constants.update_time)
    reached = np.empty_like(steps)
    begin = 0
    ends = _ends(accelerations == 0.0, constants.no_movement)
    for end in (*(ends + 1).tolist(), len(steps)):
        # `accumulate` adds one after the other, as the loop of the page does.
        np.add.accumulate(steps[begin:end], out=reached[begin:end])
        begin = end
    reached += 0.0  # a sum that begins at 0 is never −0
    velocities = reached.copy()
    velocities[ends] = 0.0
    ways = _trapezoids(_before(velocities), reached, constants.update_time)
    return np.column_stack((accelerations, velocities, np.add.accumulate(ways) + 0.0))


def _before(values: Doubles) -> Doubles:
    """Return what each update finds of the one before; the first finds 0."""
    return np.concatenate(([0.0], values[:-1]))


def _trapezoids(last: Doubles, now: Doubles, time: float) -> Doubles:
    areas: Doubles = (last + (now - last) / 2.0) * time
    return areas


def _ends(quiet: npt.NDArray[np.bool_], no_movement: int) -> npt.NDArray[np.intp]:
    """Return the updates that end a movement: those of one quiet stretch after it change nothing.

    >>> _ends(np.array([True, False, True, True, True, True, True]), 2).tolist()
    [4]
    """
    indices = np.arange(len(quiet))
    last_loud = np.maximum.accumulate(np.where(quiet, -1, indices))
    return np.nonzero(indices - last_loud == no_movement + 1)[0]
