"""The smoother against Rauch, Tung and Striebel's, and the laws it keeps."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_walks import filtered, measured, navigator, streamed, walk

from dead_reckoning.core import navigator as module
from dead_reckoning.core import smoother as smoother_module
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.kernels.navigation.layout import ERRORS
from dead_reckoning.core.kernels.navigation.smoother import _undo, smooth
from dead_reckoning.core.kernels.navigation.strapdown import carry
from dead_reckoning.core.navigation import history
from dead_reckoning.core.navigation.aids import NO_AIDS, aid_row
from dead_reckoning.core.smoother import Smoother

WALK = measured(walk(strides=4, turn=0.4), 1)


def smoothed(block=None, stretch=200, monkeypatch=None, **settings):
    """Return filtered and smoothed states of a walk."""
    if monkeypatch is not None:
        for each in (module, smoother_module, history):
            monkeypatch.setattr(each, 'STRETCH', stretch)
    found = navigator(**settings)
    record = Smoother(found)
    states = streamed(found, WALK.block() if block is None else block)
    return states, StateBlock.join(list(record.blocks())[::-1])


def aids_of(states, rows):
    """Return velocities and positions, all a little off those of the states of some rows."""
    half, told = (0.01, 0.002, 0.0, 0.02, -0.003, 0.04), []
    for row in rows:
        off = 0.05 * np.sin(row + np.arange(3))
        for what, value in (
            (layout.WORLD_VELOCITY, states[row, 3:6]),
            (layout.WORLD_POSITION, states[row, :3]),
        ):
            values = (what, layout.BY_TWIST, 0.1, *(value + off), *half, *3 * (0.0,))
            told.append(aid_row(row, layout.VECTOR, values, 0))
    return np.array(told) if told else NO_AIDS


@pytest.mark.parametrize('every', [None, 40])
def test_it_is_that_of_rauch_tung_and_striebel(every):
    found, kept = navigator(floor=False, aiding_gate=1e3), []
    found.history = SimpleNamespace(
        newer=lambda: None, add=lambda *given: kept.append([np.copy(each) for each in given])
    )
    streamed(found, WALK.block().part(0, 1100))
    samples = np.concatenate([each[0] for each in kept])
    verdicts = np.concatenate([each[1] for each in kept])
    rules, state = kept[0][4], kept[0][5]
    alone, _, _ = filtered(rules, state.copy(), samples, verdicts)
    aids = aids_of(alone, range(300, len(alone), every) if every else ())
    out, trace, log = filtered(rules, state, samples, verdicts, aids)
    taken = state[layout.COUNTS + layout.AIDED + 2 * layout.BY_TWIST]
    assert taken == len(aids)
    n, causal = len(out), out.copy()
    smooth(trace, log, rules, np.zeros((16, 1)), np.zeros((16, 16)), out)
    used = slice(0, 15)  # the floor takes no part
    p = trace[:n, 33 : 33 + 256].reshape(n, 16, 16)
    correction, variance = np.zeros(15), p[-1][used, used]
    for k in range(n - 1, 0, -1):
        row, begin = trace[k], int(trace[k - 1, -1])
        predicted, gained = p[k].copy(), np.zeros(ERRORS)
        for entry in log[begin : int(row[-1])]:
            gain = entry[3 : 3 + ERRORS]
            predicted += np.outer(gain, gain) * entry[1]
            gained += gain * entry[2]
        f = np.eye(ERRORS)
        carry(f, row[0], rules[layout.GRAVITY], tuple(row[1:10]), tuple(row[10:13]), row[13:16])
        back = np.linalg.solve(predicted[used, used], (f @ p[k - 1])[used, used]).T
        correction = back @ (correction + gained[used])
        variance = p[k - 1][used, used] + back @ (variance - predicted[used, used]) @ back.T
        position = causal[k - 1, :3] + correction[:3]
        np.testing.assert_allclose(out[k - 1, :3], position, atol=1e-8)
        spread = out[k - 1, 10:19].reshape(3, 3)
        np.testing.assert_allclose(spread, variance[:3, :3], rtol=1e-5, atol=1e-9)
    assert np.abs(out[:n, :3] - causal[:, :3]).max() > 1e-3  # it does something


@pytest.mark.parametrize('of', [{4: 1.0}, {2: 1.0, 15: -1.0}, {3: 0.6, 4: -0.3, 9: 2.0}])
def test_it_goes_back_over_an_update(of):
    random = np.random.default_rng(3)
    adjoint, root, gain = random.normal(size=(16, 1)), *random.normal(size=(2, 16, 16))
    information, gain = root @ root.T, gain[0]
    h = np.zeros((1, 16))
    for i, share in of.items():
        h[0, i] = share
    total, innovation = 0.7, -0.3
    kept = np.eye(16) - gain[:, None] @ h
    expected = kept.T @ adjoint - h.T * innovation / total
    spread = kept.T @ information @ kept + h.T @ h / total
    entry = np.array([layout.MEASURE, total, innovation, *gain, *h[0]])
    _undo(entry, adjoint, information)
    np.testing.assert_allclose(adjoint, expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(information, spread, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize('kind', [layout.CLONE, layout.FORGET, layout.TURN, layout.FOLLOW])
def test_it_goes_back_over_what_is_no_measurement(kind):
    random = np.random.default_rng(4)
    adjoint, root = random.normal(size=(16, 1)), random.normal(size=(16, 16))
    information = root @ root.T
    step = np.eye(16)
    forgotten, spin = np.zeros(16), np.array([0.7, -0.2, 0.4])
    if kind == layout.CLONE:
        step[15] = step[2]
    elif kind == layout.FORGET:
        forgotten[[3, 4, 11]] = 1.0
        step[[3, 4, 11]] = 0.0
    else:
        step[3:6, 3:6] = Rotation.from_rotvec(spin).as_matrix()
        if kind == layout.TURN:
            step[6:9, 6:9] = step[3:6, 3:6]
    expected, spread = step.T @ adjoint, step.T @ information @ step
    entry = np.array([kind, *spin, *np.zeros(15), *forgotten])
    _undo(entry, adjoint, information)
    np.testing.assert_allclose(adjoint, expected, atol=1e-12)
    np.testing.assert_allclose(information, spread, atol=1e-12)


def test_it_ends_where_the_filter_does_and_knows_better_before():
    filtered, states = smoothed()
    begin = len(states) - len(filtered)  # the smoother has the alignment too
    np.testing.assert_array_equal(states.stamp_ns[begin:], filtered.stamp_ns)
    np.testing.assert_array_equal(states.stationary[begin:], filtered.stationary)
    np.testing.assert_allclose(states.position[-1], filtered.position[-1], atol=1e-9)
    for name in ('position_covariance', 'velocity_covariance', 'attitude_covariance'):
        before, after = getattr(filtered, name)[:, ::4], getattr(states, name)[begin:, ::4]
        assert (after <= before * (1.0 + 1e-6) + 1e-12).all()
        assert (after > -1e-12).all()


def test_velocity_no_longer_jumps_where_a_stance_begins():
    filtered, states = smoothed()
    begin = len(states) - len(filtered)
    landing = np.flatnonzero(np.diff(filtered.stationary.astype(int)) == 1)
    jumps = [
        np.linalg.norm(np.diff(v, axis=0)[landing], axis=1).mean()
        for v in (filtered.position, states.position[begin:])
    ]
    assert jumps[1] < 0.5 * jumps[0]


@pytest.mark.parametrize('stretch', [60, 333])
def test_where_the_state_is_kept_does_not_matter(stretch, monkeypatch):
    _, whole = smoothed()
    _, parts = smoothed(stretch=stretch, monkeypatch=monkeypatch)
    assert_near(parts, whole)


def test_blocks_give_what_the_stream_gives():
    _, stream = smoothed()
    found = navigator()
    record = Smoother(found)
    block = WALK.block()
    streamed_part = block.part(0, 300)
    for index in range(len(streamed_part)):
        try:
            found.update(streamed_part.sample(index))
        except module.NotLevelledError:
            assert not found.aligned
    rows = np.zeros((len(block) - 300, layout.ROW))
    rows[:, 0] = np.diff(block.stamp_ns[299:]) / 1e9
    rows[:, 1:4], rows[:, 4:7] = block.specific_force[300:], block.angular_velocity[300:]
    rows[:, 7] = found._rate_variance
    found.take(rows, block.stamp_ns[300:])
    found.flush()
    assert_near(StateBlock.join(list(record.blocks())[::-1]), stream)


def test_it_goes_over_gaps_and_stops_at_restarts():
    block = WALK.block()
    block.stamp_ns[900:] += 2_000_000_000
    _, states = smoothed(block)
    assert np.isfinite(states.position).all()
    gap = int(np.flatnonzero(np.diff(states.stamp_ns) > 1_000_000_000)[0])
    spread = states.position_covariance[:, 0]
    assert spread[gap + 1] > spread[gap] + 1.0
    _, alone = smoothed(WALK.block())
    twice = np.concatenate([WALK.block().stamp_ns, WALK.block().stamp_ns])
    both = type(block).join([WALK.block(), WALK.block()])
    assert len(twice) == len(both)
    found = navigator()
    record = Smoother(found)
    for index in range(len(both)):
        if index == len(block):
            found.flush()
        try:
            found.update(both.sample(index))
        except module.NotLevelledError:
            assert not found.aligned
    found.flush()
    states = StateBlock.join(list(record.blocks())[::-1])
    assert_near(states.part(0, len(alone)), alone)
    assert_near(states.part(len(alone), 2 * len(alone)), alone)


def assert_near(states, others):
    np.testing.assert_array_equal(states.stamp_ns, others.stamp_ns)
    for name in ('position', 'velocity', 'attitude', 'position_covariance', 'angular_velocity'):
        np.testing.assert_allclose(getattr(states, name), getattr(others, name), atol=1e-9)
