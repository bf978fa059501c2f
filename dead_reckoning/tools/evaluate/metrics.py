"""Errors of a trajectory beside its truth, pose by pose, and what sums them up."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial.transform import Rotation

from dead_reckoning.core.errors import InputError
from dead_reckoning.core.samples import UNMEASURED_VARIANCE
from dead_reckoning.tools.evaluate.trajectory import Array, Indices, Trajectory

SLACK_NS = 1000
"""Stamps that were seconds as decimals once are off by less; a delta must not skip a pose."""


def statistics(errors: Array) -> dict[str, float]:
    """Return rmse, mean, median, std (divided by n), min, max and sse of errors, as evo does."""
    squares = float(errors @ errors)
    return {
        'rmse': float(np.sqrt(squares / len(errors))),
        'mean': float(errors.mean()),
        'median': float(np.median(errors)),
        'std': float(errors.std()),
        'min': float(errors.min()),
        'max': float(errors.max()),
        'sse': squares,
    }


def absolute_errors(truth: Trajectory, estimate: Trajectory) -> tuple[Array, Array]:
    """Return distance [m] and angle [°] between paired poses, shapes (n,): the APE.

    ``|p − q|``, and the angle of ``P⁻¹ Q`` for rotations P of the estimate, Q of the truth.
    """
    return (
        np.linalg.norm(estimate.position - truth.position, axis=1),
        np.degrees((estimate.rotation.inv() * truth.rotation).magnitude()),
    )


def relative_errors(
    truth: Trajectory, estimate: Trajectory, delta: float, unit: str
) -> tuple[Array, Array]:
    """Return distance [m] and angle [°] between paired motions over ``delta``: the RPE.

    For consecutive poses i, j that are ``delta`` apart, translation and rotation of
    ``(Q_i⁻¹ Q_j)⁻¹ (P_i⁻¹ P_j)``, poses P of the estimate, Q of the truth.  Raises `InputError`
    where the trajectory is shorter than that.
    """
    marks = _marks(estimate, delta, unit)
    if len(marks) < 2:
        raise InputError(
            f'--delta {delta:g} {unit} is more than the {len(estimate)} paired poses span: '
            'take a smaller one'
        )
    motions = []
    for of in (truth.at(marks), estimate.at(marks)):
        backward = of.rotation[:-1].inv()
        motions.append((backward.apply(np.diff(of.position, axis=0)), backward * of.rotation[1:]))
    (true_way, true_turn), (way, turn) = motions
    return (
        np.linalg.norm(way - true_way, axis=1),
        np.degrees((true_turn.inv() * turn).magnitude()),
    )


def _marks(estimate: Trajectory, delta: float, unit: str) -> Indices:
    """Return the poses at which ``delta`` has gone by since the one before, the first included."""
    gone_by: Iterable[float]
    if unit == 'frames':
        gone_by = [1] * (len(estimate) - 1)
    elif unit == 'm':
        gone_by = estimate.steps.tolist()
    else:
        gone_by = np.diff(estimate.stamp_ns).tolist()
        delta = delta * 1e9 - SLACK_NS
    marks, gone = [0], 0.0
    for index, more in enumerate(gone_by, 1):
        gone += more
        if gone >= delta:
            marks.append(index)
            gone = 0.0
    return np.array(marks)


def consistency(
    truth: Trajectory, estimate: Trajectory, turn: Rotation
) -> dict[str, dict[str, float]]:
    """Say for each axis of the estimate whether its σ is as large as its error.

    ``estimate`` as it came, not aligned: the truth is turned back to it instead, as σ belongs to
    its axes, and moved so that both start at one place, as σ is about the way from there.  rms of
    error / σ (1 where σ is right), the share within 3 σ (0.997), and how many poses count: those
    at which σ is more than nothing, and less than that of what nobody measures.  Axes without such
    a pose are left out.
    """
    assert estimate.deviation is not None
    way = estimate.position - estimate.position[0]
    true_way = turn.inv().apply(truth.position - truth.position[0])
    errors = way - true_way
    found = {}
    for k, axis in enumerate('xyz'):
        sigma = estimate.deviation[:, k]
        counts = (sigma > 0.0) & (sigma < 0.999 * UNMEASURED_VARIANCE**0.5)
        if counts.any():
            ratio = errors[counts, k] / sigma[counts]
            found[axis] = {
                'rms': float(np.sqrt(np.mean(ratio**2))),
                'within_3_sigma': float(np.mean(np.abs(ratio) <= 3.0)),
                'samples': int(counts.sum()),
            }
    return found
