"""Errors beside the covariance that goes with them, over many simulated walks and drives."""

from contextlib import suppress
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_drives import driven
from simulated_walks import filtered, navigator, walk

from dead_reckoning.core.errors import NotLevelledError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.stationarity import STATIONARY

RUNS = 100
FORCE_NOISE, RATE_NOISE = 0.03, 3e-4
FREE = 0.2
"""How long wheels are not believed before the errors are looked at [s]."""

CASES = {
    'walk': (lambda: walk(strides=10, turn=0.3), {}, (3.3, 6.6, 9.9, 13.2)),
    'drive': (
        lambda: driven(loops=1, loop_time=45.0),
        {'nonholonomic': True, 'slip': 1e-3, 'slip_angle': 0.0, 'rate_bias': 5e-4},
        (9.0, 12.0, 28.0, 31.0, 47.0, 50.0),
    ),
}
"""The truth, settings, and times [s] within swings, and on the way of a vehicle."""


def at_the_start(true, **settings):
    """Return rules and state of a navigator, before its first sample."""
    found, kept = navigator(
        acceleration_noise=FORCE_NOISE, rate_noise=RATE_NOISE, sampling_noise=0.0,
        acceleration_bias=0.05, stance_velocity=1e-5, pivot=0.0, height=0.0, zero_rate=False,
        floor=False, look_ahead=0.0, **settings,
    ), []  # fmt: skip
    found.history = SimpleNamespace(
        newer=lambda: None, add=lambda *given: kept.append([np.copy(each) for each in given])
    )
    block = true.block()
    while not found.aligned:
        with suppress(NotLevelledError):
            found.update(block.sample(len(found._alignment._stamps)))
    return kept[0][4], kept[0][5]


@pytest.fixture(scope='module', params=CASES)
def normalized_errors(request):
    """Return eᵀ P⁻¹ e of position, velocity, attitude, biases, and all, shape (runs, epochs, 6).

    The errors at the start and the filter's noises are drawn.  Rests are given to it, as white
    noise of the size that it holds for that of a swing hides the swing's ends from a detector.
    They are exact, and so are wheels, and nearly so believed: what a foot does in a stance, or a
    wheel in a bend, is not drawn here.
    """
    make, settings, times = CASES[request.param]
    true = make()
    rules, start = at_the_start(true, **settings)
    free = rules.copy()
    free[layout.NONHOLONOMIC] = 0.0
    first, step = layout.COVARIANCE, true.time[1]
    spread = np.linalg.cholesky(start[first : first + 256].reshape(16, 16)[:15, :15])
    random = np.random.default_rng(1)
    count = len(true.time)
    verdicts = np.zeros((count, 3))
    verdicts[:, STATIONARY] = np.linalg.norm(true.velocity, axis=1) == 0.0
    rotations = Rotation.from_matrix(true.rotation)
    results = np.zeros((RUNS, len(times), 6))
    for run in range(RUNS):
        drawn = spread @ random.normal(size=15)
        rate_bias, force_bias = (
            begin + np.cumsum(random.normal(0.0, rules[wander] * step**0.5, (count, 3)), axis=0)
            for begin, wander in (
                (drawn[9:12], layout.RATE_WALK),
                (drawn[12:15], layout.ACCELERATION_WALK),
            )
        )
        rows = np.zeros((count, layout.ROW))
        rows[:, 0] = step
        rows[:, 1:4] = true.force + force_bias
        rows[:, 1:4] += random.normal(0.0, FORCE_NOISE / step**0.5, (count, 3))
        rows[:, 4:7] = true.rate + rate_bias
        rows[:, 4:7] += random.normal(0.0, RATE_NOISE / step**0.5, (count, 3))
        state = start.copy()
        state[0:3], state[3:6] = true.position[0] - drawn[:3], -drawn[3:6]
        state[13:17] = (Rotation.from_rotvec(drawn[6:9]).inv() * rotations[0]).as_quat()
        begin = 0
        for index, time in enumerate(times):
            k, last = round(time / step), round((time - FREE) / step)
            filtered(rules, state, rows[begin:last], verdicts[begin:last])
            _, trace, _ = filtered(free, state, rows[last : k + 1], verdicts[last : k + 1])
            begin = k + 1
            x, p = trace[-1, 16:33], trace[-1, 33:289].reshape(16, 16)
            theta = (rotations[k] * Rotation.from_quat(x[13:17]).inv()).as_rotvec()
            error = np.concatenate([
                true.position[k] - x[:3],
                Rotation.from_rotvec(-theta).apply(true.velocity[k]) - x[3:6],
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
