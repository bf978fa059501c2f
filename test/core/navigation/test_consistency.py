"""Errors beside the covariance that goes with them, over many simulated walks."""

from contextlib import suppress

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_walks import filtered, navigator, walk

from dead_reckoning.core.errors import NotLevelledError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.stationarity import STATIONARY

RUNS, RATE = 100, 200.0
FORCE_NOISE, RATE_NOISE = 0.03, 3e-4
EPOCHS = (3.3, 6.6, 9.9, 13.2)
"""Times within swings [s]."""


def at_the_start(true):
    """Return rules and state of a navigator, before its first sample."""
    found, kept = navigator(
        acceleration_noise=FORCE_NOISE, rate_noise=RATE_NOISE, sampling_noise=0.0,
        acceleration_bias=0.05, stance_velocity=1e-5, pivot=0.0, height=0.0,
        still_deviation=0.0, floor=False, look_ahead=0.0,
    ), []  # fmt: skip
    found.record = lambda *given: kept.append([np.copy(each) for each in given])
    block = true.block()
    for index in range(101):
        with suppress(NotLevelledError):
            found.update(block.sample(index))
    return kept[0][4], kept[0][5]


@pytest.fixture(scope='module')
def normalized_errors():
    """Return eᵀ P⁻¹ e of position, velocity, attitude, biases, and all, shape (runs, epochs, 6).

    The errors at the start and the filter's noises are drawn.  Stances are given to it, as white
    noise of the size that it holds for that of a swing hides the swing's ends from a detector.
    They are exact, and nearly so believed: what a foot does in a stance is not drawn here.
    """
    true = walk(strides=10, turn=0.3)
    rules, start = at_the_start(true)
    first = layout.COVARIANCE
    deviation = np.sqrt(start[first : first + 256 : 17])[:15]
    stands = np.linalg.norm(true.velocity, axis=1) == 0.0
    epochs = [round(RATE * t) for t in EPOCHS]
    random = np.random.default_rng(1)
    count, steps = len(true.time), np.sqrt(1.0 / RATE)
    verdicts = np.zeros((count, 3))
    verdicts[:, STATIONARY] = stands
    rotations = Rotation.from_matrix(true.rotation)
    results = np.zeros((RUNS, len(epochs), 6))
    for run in range(RUNS):
        drawn = deviation * random.normal(size=15)
        rate_bias, force_bias = (
            begin + np.cumsum(random.normal(0.0, rules[walk] * steps, (count, 3)), axis=0)
            for begin, walk in (
                (drawn[9:12], layout.RATE_WALK),
                (drawn[12:15], layout.ACCELERATION_WALK),
            )
        )
        rows = np.zeros((count, layout.ROW))
        rows[:, 0] = 1.0 / RATE
        rows[:, 1:4] = true.force + force_bias
        rows[:, 1:4] += random.normal(0.0, FORCE_NOISE / steps, (count, 3))
        rows[:, 4:7] = true.rate + rate_bias
        rows[:, 4:7] += random.normal(0.0, RATE_NOISE / steps, (count, 3))
        state = start.copy()
        state[0:3], state[3:6] = true.position[0] - drawn[:3], -drawn[3:6]
        state[13:17] = (Rotation.from_rotvec(drawn[6:9]).inv() * rotations[0]).as_quat()
        _, trace, _ = filtered(rules, state, rows, verdicts)
        for index, k in enumerate(epochs):
            x, p = trace[k, 16:33], trace[k, 33:289].reshape(16, 16)
            theta = (rotations[k] * Rotation.from_quat(x[13:17]).inv()).as_rotvec()
            error = np.concatenate([
                true.position[k] - x[:3],
                true.velocity[k] - Rotation.from_rotvec(theta).apply(x[3:6]),
                theta,
                rate_bias[k] - x[6:9],
                force_bias[k] - x[9:12],
            ])  # fmt: skip
            parts = [slice(3 * i, 3 * i + 3) for i in range(5)] + [slice(0, 15)]
            for part, values in enumerate(parts):
                e = error[values]
                results[run, index, part] = e @ np.linalg.solve(p[values, values], e)
    return results


def test_normalized_error_of_all_is_that_of_fifteen_degrees_of_freedom(normalized_errors):
    anees = normalized_errors[:, :, 5].mean(axis=0) / 15.0
    bound = 1.96 * np.sqrt(2.0 / (15 * RUNS))
    assert np.abs(anees - 1.0).max() < bound


@pytest.mark.parametrize(
    'part', range(5), ids=['position', 'velocity', 'attitude', 'rate bias', 'force bias']
)
def test_normalized_error_of_each_part(normalized_errors, part):
    anees = normalized_errors[:, :, part].mean(axis=0) / 3.0
    assert np.abs(anees - 1.0).max() < 3.0 * np.sqrt(2.0 / (3 * RUNS))
