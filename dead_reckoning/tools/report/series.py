"""Series thinned to what a picture can show: its pixels, and no fewer extremes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.tools.report.contents import Array, Stamps

COLUMNS = 1200
"""How many points of time a picture distinguishes."""

PIXELS = 1500
"""How many points of the plane it distinguishes, along the longer side."""

GAP = 1.0
"""A line is broken where nothing came for longer than this [s], or than 20 times the usual."""


def elapsed(stamp_ns: Stamps, start_ns: int) -> Array:
    """Return times from the start on [s], shape (n,); stamps that went back stand still."""
    if not len(stamp_ns):
        return np.zeros(0)
    steps = np.maximum(np.diff(stamp_ns, prepend=stamp_ns[:1]), 0)
    time: Array = (stamp_ns[0] - start_ns + np.cumsum(steps)) / 1e9
    return time


def breaks(stamp_ns: Stamps) -> NDArray[np.bool_]:
    """Say before which samples a line is broken, shape (n,): gaps, and stamps that go back."""
    steps = np.diff(stamp_ns) / 1e9
    usual = float(np.median(steps)) if len(steps) else 0.0
    return np.append(False, (steps > max(GAP, 20.0 * usual)) | (steps < 0.0))


def envelope(time: Array, values: Array, broken: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
    """Return times, shape (k,), and least and greatest values there, shapes (k, m).

    ``values`` has shape (n, m).  Short series come as they are; in long ones a point stands for a
    pixel's time.  NaN stands where the line is broken.
    """
    groups = np.cumsum(broken)
    if len(time) > 2 * COLUMNS:
        span = max(time[-1] - time[0], 1e-9)
        groups = groups + (COLUMNS * (time - time[0]) / span).astype(np.int64)
        begins = np.flatnonzero(np.diff(groups, prepend=-1))
    else:
        begins = np.arange(len(time))
    low = np.minimum.reduceat(values, begins, axis=0)
    high = np.maximum.reduceat(values, begins, axis=0)
    at = np.flatnonzero(np.add.reduceat(broken, begins)[1:]) + 1
    return (
        np.insert(time[begins], at, np.nan),
        np.insert(low, at, np.nan, axis=0),
        np.insert(high, at, np.nan, axis=0),
    )


def line(time: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Return an envelope, shapes (k,), as one line that goes up and down in it."""
    if np.array_equal(low, high, equal_nan=True):
        return time, low
    return np.repeat(time, 2), np.column_stack([low, high]).ravel()


def way(position: Array, broken: NDArray[np.bool_]) -> Array:
    """Return a way in the plane, shape (k, 2), without what a picture does not distinguish."""
    extent = max(float(np.ptp(position, axis=0).max()), 1e-9)
    pixels = np.rint(position * (PIXELS / extent)).astype(np.int64)
    kept = np.append(True, (np.diff(pixels, axis=0) != 0).any(axis=1)) | broken
    kept[-1] = True
    at = np.flatnonzero(broken[kept])
    return np.insert(position[kept], at, np.nan, axis=0)


def intervals(time: Array, flags: NDArray[np.bool_], broken: NDArray[np.bool_]) -> Array:
    """Return where flags are set as rows of begin and length [s]; what a pixel hides is merged."""
    before = np.append(False, flags[:-1]) & ~broken
    after = np.append(flags[1:] & ~broken[1:], False)
    begin, end = time[flags & ~before], time[flags & ~after]
    if not len(begin):
        return np.zeros((0, 2))
    pixel = (time[-1] - time[0]) / COLUMNS
    apart = np.append(True, begin[1:] - end[:-1] > pixel)
    first = np.flatnonzero(apart)
    last = np.append(first[1:], len(begin)) - 1
    return np.column_stack([begin[first], np.maximum(end[last] - begin[first], pixel)])
