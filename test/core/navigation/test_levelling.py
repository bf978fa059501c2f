"""Levelling again on the way: tilt, gravity and gyro bias anew, position and yaw as they were."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_walks import GRAVITY, blocks_of, measured, navigator, walk

from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.errors import NotAtRestError, NotLevelledError, SupersededError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.smoother import Smoother

WALK = walk(strides=8, turn=0.2, end=6.0)
MOVED = measured(WALK, 1)
END = len(WALK.time) - 1000
"""In the last rest."""


def covariance(found):
    first = layout.COVARIANCE
    return found._state[first : first + 256].reshape(16, 16).copy()


def walked(end, found=None, moved=MOVED):
    found = found or navigator()
    blocks_of(found, moved.block().part(0, end))
    return found


def go_on(found, begin, count, moved=MOVED):
    states = []
    block = moved.block()
    for index in range(begin, begin + count):
        states += found.update(block.sample(index))
    return states


def test_position_and_yaw_stay_and_the_tilt_is_that_of_gravity():
    found = walked(END)
    tilt = Rotation.from_rotvec([0.15, -0.1, 0.0])
    begin = layout.X_ATTITUDE
    spoilt = tilt * Rotation.from_quat(found._state[begin : begin + 4])
    found._state[begin : begin + 4] = spoilt.as_quat()
    before = found._state[:3].copy()
    future = found.level()
    assert found.levelling
    go_on(found, END, 100)
    assert not future.done()
    go_on(found, END + 100, 1)
    assert 'gyro bias' in future.result()
    assert future.result() == found.aligned
    assert not found.levelling
    after = Rotation.from_quat(found._state[begin : begin + 4])
    bias = found._state[layout.X_FORCE_BIAS : layout.X_FORCE_BIAS + 3]
    up = after.apply(MOVED.force[END : END + 100].mean(axis=0) - bias)
    assert np.degrees(np.arctan2(np.hypot(up[0], up[1]), up[2])) < 0.05
    turn = (after * spoilt.inv()).as_rotvec()
    assert np.linalg.norm(turn[:2]) == pytest.approx(np.hypot(0.15, 0.1), rel=0.1)
    assert abs(turn[2]) < 0.01
    np.testing.assert_allclose(found._state[:3], before, atol=0.02)


def test_a_bias_that_jumped_is_learnt_and_one_that_is_known_stays():
    jumped = measured(WALK, 1)
    jumped.rate[END:] += [0.03, -0.02, 0.01]
    for moved, jump in ((MOVED, 0.0), (jumped, np.array([0.03, -0.02, 0.01]))):
        found = walked(END, moved=moved)
        first = layout.X_RATE_BIAS
        before, known = found._state[first : first + 3].copy(), covariance(found)[9, 9]
        found.level()
        go_on(found, END, 101, moved)
        np.testing.assert_allclose(found._state[first : first + 3], before + jump, atol=2e-3)
        expected = 2.0 * (7e-4 / 0.5) ** 2 + 3e-4**2 / 0.5  # of the sway, over the rest
        if np.any(jump):
            assert covariance(found)[9, 9] == pytest.approx(expected, rel=0.2)
        else:
            assert covariance(found)[9, 9] < 1.1 * known


def test_the_tilt_is_known_as_the_bias_of_the_accelerometer_is():
    """R (f − b_a) is (0, 0, g): their errors are one, and the others' covariances are kept."""
    found = walked(END)
    before = covariance(found)
    found.level()
    go_on(found, END, 101)
    p = covariance(found)
    assert (p == p.T).all()
    assert np.linalg.eigvalsh(p[:15, :15])[0] > 0.0
    rotation = Rotation.from_quat(found._state[13:17]).as_matrix()
    of_tilt = GRAVITY * np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    h = np.hstack([np.zeros((2, 6)), of_tilt, np.zeros((2, 3)), -rotation[:2], np.zeros((2, 1))])
    assert (np.diag(h @ p @ h.T) < 0.05**2).all()
    assert (np.diag(p)[12:15] < 1.01 * np.diag(before)[12:15]).all()
    np.testing.assert_allclose(p[:3, :3], before[:3, :3], rtol=0.1, atol=1e-4)
    without = walked(END)
    go_on(without, END, 101)
    assert p[8, 8] == pytest.approx(covariance(without)[8, 8], rel=0.01)


def test_gravity_is_measured_anew():
    moved = measured(WALK, 1)
    moved.force[END:] *= 1.02
    found = walked(END, moved=moved)
    future = found.level()
    go_on(found, END, 101, moved)
    gravity = found._rules[layout.GRAVITY]
    bias = found._state[layout.X_FORCE_BIAS : layout.X_FORCE_BIAS + 3]
    rest = np.linalg.norm(moved.force[END : END + 100].mean(axis=0) - bias)
    assert gravity == pytest.approx(rest, rel=1e-3)
    assert f'gravity is {gravity:.4f} m/s²' in future.result()


def test_while_moving_it_says_why_not_and_changes_nothing():
    found, same = walked(900), walked(900)
    future = found.level()
    go_on(found, 900, 150)
    go_on(same, 900, 150)
    with pytest.raises(NotAtRestError, match='hold the device still'):
        future.result(timeout=0)
    np.testing.assert_array_equal(found._state, same._state)
    assert found.aligned == same.aligned


def test_who_asks_is_answered_by_the_first_alignment_a_reset_or_the_next_who_asks():
    found = navigator()
    future = found.level()
    blocks_of(found, MOVED.block().part(0, 150))
    assert future.result(timeout=0) == found.aligned
    future = found.level()
    again = found.level()
    with pytest.raises(SupersededError):
        future.result(timeout=0)
    found.reset()
    with pytest.raises(SupersededError):
        again.result(timeout=0)
    future = found.level()
    shaken = measured(WALK, 2, force_noise=0.2)
    with pytest.raises(NotLevelledError):
        go_on(found, 0, 150, shaken)
    for index in range(1, 150):
        with pytest.raises(NotLevelledError):
            go_on(found, index, 1, shaken)
    with pytest.raises(NotAtRestError):
        future.result(timeout=0)


def test_it_goes_on_well_and_the_smoother_goes_back_over_it():
    found = navigator()
    record = Smoother(found)
    blocks = blocks_of(found, MOVED.block().part(0, END))
    found.level()
    blocks += blocks_of(found, MOVED.block().part(END, len(MOVED.time)))
    states = StateBlock.join([*blocks, StateBlock.of(found.flush())])
    smoothed = StateBlock.join(list(record.blocks())[::-1])
    smoothed = smoothed.part(len(smoothed) - len(states), len(smoothed))
    np.testing.assert_array_equal(smoothed.stamp_ns, states.stamp_ns)
    np.testing.assert_allclose(smoothed.position[-1], states.position[-1], atol=1e-9)
    assert np.abs(smoothed.position - states.position).max() < 0.1
    alone = StateBlock.join(blocks_of(navigator(), MOVED.block()))
    np.testing.assert_allclose(states.position[-1], alone.position[-1], atol=0.05)
    before = states.position_covariance[:, 0]
    assert (smoothed.position_covariance[:, 0] <= before * (1.0 + 1e-6)).all()


def test_a_switch_of_the_compass_drops_no_level_that_waits():
    found = walked(END)
    future = found.level()
    go_on(found, END, 101)
    assert future.done()
    waiting = len(found._aids.waiting)
    assert waiting == 0 or found._aids.waiting[0][1] == layout.LEVEL
    found._aids.add(10**30, layout.LEVEL, (0.0,) * 8)
    found._aids.add(10**30, layout.YAW, (*[0.0] * 5, layout.BY_COMPASS))
    found._aids.add(10**30, layout.YAW, (*[0.0] * 5, layout.BY_POSE_YAW))
    found.configure(found.settings.changed({'navigator.compass': False}))
    kinds = [kind for _, kind, _ in found._aids.waiting]
    assert kinds == [*[layout.LEVEL] * (waiting + 1), layout.YAW]  # that of a pose stays
