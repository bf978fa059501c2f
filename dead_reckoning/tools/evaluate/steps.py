"""Steps beside the true ones: how many, how far, and when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

TOLERANCE_NS = 100_000_000
"""How far a step may be from the true one [ns]."""

MAX_LAG_NS = 1_000_000_000
"""How far all steps together may be from the true ones [ns]."""


@dataclass(frozen=True, eq=False)
class Steps:
    """A count of steps; their times, shape (n,) [ns], and distance [m] where these are known."""

    count: int
    stamp_ns: NDArray[np.int64] | None = None
    distance: float | None = None


def timing(truth_ns: NDArray[np.int64], estimate_ns: NDArray[np.int64]) -> dict[str, float | None]:
    """Return F1, precision, recall of step times within ±0.1 s, after one constant lag [s].

    The lag, estimate less truth and at most 1 s, is that under which most steps have a partner:
    the middle of the fullest window of 0.2 s among all differences; of two as full, the one
    nearer to 0.  Each step is matched once; a share of nothing is None.
    """
    lag_ns = _lag(truth_ns, estimate_ns)
    matched = _matched(truth_ns, estimate_ns - lag_ns)

    def share(count: float) -> float | None:
        return matched / count if count else None

    return {
        'f1': share((len(truth_ns) + len(estimate_ns)) / 2),
        'precision': share(len(estimate_ns)),
        'recall': share(len(truth_ns)),
        'matched': matched,
        'lag_s': lag_ns / 1e9,
        'tolerance_s': TOLERANCE_NS / 1e9,
    }


def _lag(truth_ns: NDArray[np.int64], estimate_ns: NDArray[np.int64]) -> int:
    first = np.searchsorted(truth_ns, estimate_ns - MAX_LAG_NS)
    last = np.searchsorted(truth_ns, estimate_ns + MAX_LAG_NS, side='right')
    pairs = zip(estimate_ns.tolist(), first.tolist(), last.tolist(), strict=True)
    each = [stamp - truth_ns[a:b] for stamp, a, b in pairs]
    differences = np.sort(np.concatenate([truth_ns[:0], *each]))
    if not len(differences):
        return 0
    ends = np.searchsorted(differences, differences + 2 * TOLERANCE_NS, side='right')
    middles = (differences + differences[ends - 1]) // 2
    full = ends - np.arange(len(differences))
    best = np.lexsort((np.abs(middles), -full))[0]
    return int(middles[best])


def _matched(truth_ns: NDArray[np.int64], estimate_ns: NDArray[np.int64]) -> int:
    """Count pairs within the tolerance, in order, each step once."""
    matched = 0
    true, made = truth_ns.tolist(), estimate_ns.tolist()
    while true and made:
        difference = made[-1] - true[-1]
        matched += abs(difference) <= TOLERANCE_NS
        if difference >= -TOLERANCE_NS:
            made.pop()
        if difference <= TOLERANCE_NS:
            true.pop()
    return matched
