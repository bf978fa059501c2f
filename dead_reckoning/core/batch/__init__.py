"""Estimators over columns: kernels do what is regular, the estimators themselves the rest.

A kernel does the common case only: levelled, at rest or on the way, each sample sound and in order
of time.  It stops before the first sample that asks for more, which the streaming estimator then
takes; so every odd case is written once.  The modules here carry the state of an estimator into a
kernel and back, and so know its inside.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

from numpy.typing import NDArray

from dead_reckoning.core.chain import Output

Run: TypeAlias = Callable[[Any, int], tuple[int, list[Output]]]
"""Does samples of a block from one on; returns how many, possibly none, and what came out of them:
samples, blocks of them, or else `Stamped`."""

Column = TypeVar('Column', bound=NDArray[Any])

NOTHING: tuple[int, list[Output]] = (0, [])


def first(column: Column, count: int) -> Column:
    """Return the first rows of a column; a copy where most are left, which then need no memory."""
    part: Any = column[:count]
    rows: Column = part if 2 * count > len(column) else part.copy()
    return rows
