"""Trajectories: poses over time, paired by their stamps and laid over each other."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from dead_reckoning.core.errors import InputError

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

DEGENERATE = 1e-12
"""Positions lie on a line where their second singular value is this small beside the first."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Poses in a frame w, in order of time.

    ``stamp_ns``
        shape (n,) [ns], increasing.
    ``position``, ``attitude``
        shapes (n, 3) [m] and (n, 4), unit quaternions (x, y, z, w) that take b into w.
    ``deviation``
        standard deviation of the position, shape (n, 3) [m], frame w; None where nobody says.
    """

    stamp_ns: NDArray[np.int64]
    position: Array
    attitude: Array
    deviation: Array | None = None

    def __len__(self) -> int:
        """Return the number of poses."""
        return len(self.stamp_ns)

    @property
    def rotation(self) -> Rotation:
        """The attitudes, as rotations from b to w."""
        return Rotation.from_quat(self.attitude)

    @property
    def steps(self) -> Array:
        """Distance from each pose to the next, shape (n - 1,) [m]."""
        distances: Array = np.linalg.norm(np.diff(self.position, axis=0), axis=1)
        return distances

    @property
    def length(self) -> float:
        """Length of the way [m]."""
        return float(self.steps.sum())

    @property
    def closure(self) -> float:
        """Distance from start to end [m]."""
        return float(np.linalg.norm(self.position[-1] - self.position[0]))

    def at(self, indices: Indices) -> Trajectory:
        """Return some of the poses."""
        return Trajectory(
            self.stamp_ns[indices],
            self.position[indices],
            self.attitude[indices],
            None if self.deviation is None else self.deviation[indices],
        )


def associate(
    truth: Trajectory, estimate: Trajectory, max_difference: float
) -> tuple[Trajectory, Trajectory]:
    """Pair each pose of the one that has fewer (the estimate, if as many) with the nearest other.

    Both come back with as many poses; what has none within ``max_difference`` [s] is left out.
    Of two that are as near, the earlier counts.  Raises `InputError` where no pair is left.
    """
    truth_is_shorter = len(estimate) > len(truth)
    short, long = (truth, estimate) if truth_is_shorter else (estimate, truth)
    after = np.searchsorted(long.stamp_ns, short.stamp_ns).clip(0, len(long) - 1)
    before = np.maximum(after - 1, 0)
    to_before = np.abs(short.stamp_ns - long.stamp_ns[before])
    to_after = np.abs(short.stamp_ns - long.stamp_ns[after])
    nearest = np.where(to_before <= to_after, before, after)
    kept = np.flatnonzero(np.minimum(to_before, to_after) <= round(max_difference * 1e9))
    if not len(kept):
        raise InputError(
            f'no stamps in common: the truth lasts from {truth.stamp_ns[0]} to '
            f'{truth.stamp_ns[-1]}, the estimate from {estimate.stamp_ns[0]} to '
            f'{estimate.stamp_ns[-1]} [ns], and none are within {max_difference:g} s of each '
            'other; --max-difference allows more'
        )
    of_short, of_long = short.at(kept), long.at(nearest[kept])
    return (of_short, of_long) if truth_is_shorter else (of_long, of_short)


@dataclass(frozen=True, eq=False)
class Alignment:
    """A rigid motion that lays an estimate over the truth: ``p ← R p + t``, ``q ← R q``."""

    rotation: Rotation
    translation: Array

    def apply(self, trajectory: Trajectory) -> Trajectory:
        """Move a trajectory; its deviations stay those of its own axes."""
        return replace(
            trajectory,
            position=self.rotation.apply(trajectory.position) + self.translation,
            attitude=(self.rotation * trajectory.rotation).as_quat(),
        )


def align(truth: Trajectory, estimate: Trajectory, kind: str) -> Alignment:
    """Return what moves paired positions closest to the truth: the least sum of squares.

    ``none``: nothing.  ``yaw``: a turn about the vertical and a translation, what dead reckoning
    can not know; with p and q less their means, ``ψ = atan2(Σ p_x q_y − p_y q_x, Σ p_x q_x +
    p_y q_y)``.  ``se3``: any rotation and a translation (Umeyama 1991, doi:10.1109/34.88573,
    without scale); raises `InputError` for positions on one line, which leave it open.
    """
    if kind == 'none':
        return Alignment(Rotation.identity(), np.zeros(3))
    mean_p, mean_q = estimate.position.mean(axis=0), truth.position.mean(axis=0)
    # Rows are those of the truth: Σ q pᵀ.
    products = (truth.position - mean_q).T @ (estimate.position - mean_p)
    if kind == 'yaw':
        yaw = np.arctan2(products[1, 0] - products[0, 1], products[0, 0] + products[1, 1])
        rotation = Rotation.from_euler('z', yaw)
    else:
        u, values, vt = np.linalg.svd(products)
        if values[1] <= DEGENERATE * values[0]:
            raise InputError(
                f'--align se3: the {len(truth)} paired positions lie on one line, about which '
                'any turn fits; take --align yaw or none'
            )
        sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
        rotation = Rotation.from_matrix(u @ np.diag((1.0, 1.0, sign)) @ vt)
    return Alignment(rotation, mean_q - rotation.apply(mean_p))
