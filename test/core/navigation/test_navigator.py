"""The inertial navigator: alignment, laws, faults; streaming and blocks."""

from contextlib import suppress
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_walks import (
    MOUNTED,
    START_NS,
    Walk,
    blocks_of,
    filtered,
    joined,
    measured,
    navigator,
    streamed,
    walk,
)

from dead_reckoning.core.blocks import ImuBlock, StateBlock
from dead_reckoning.core.errors import (
    DivergedError,
    GapError,
    GravityError,
    MissingAccelerationError,
    MissingRateError,
    NotFiniteError,
    NotLevelledError,
    RepeatedStampError,
    SampleError,
    SettingsError,
)
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.kernels.navigation.filter import navigate, put_state
from dead_reckoning.core.kernels.navigation.measurement import correct
from dead_reckoning.core.navigation.aids import NO_AIDS
from dead_reckoning.core.navigation.alignment import RULES
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigation.states import state_of
from dead_reckoning.core.samples import NANOSECONDS, NOT_MEASURED, ImuSample
from dead_reckoning.core.stationarity import detector_class, names
from dead_reckoning.core.strides import Strides

WALK = walk(strides=8, turn=0.3)
NAN = float('nan')


def navigated(walk, **settings):
    """Return navigator and states for a walk, the first rest sample by sample."""
    found = navigator(**settings)
    return found, in_blocks(found, walk.block(), [])


def in_blocks(found, block, cuts):
    """Return the states for a block in parts; what is left to the stream goes there."""
    edges, blocks = [0, *cuts, len(block)], []
    for begin, end in pairwise(edges):
        blocks += blocks_of(found, block.part(begin, end))
    tail = found.flush()
    return StateBlock.join(blocks + ([StateBlock.of(tail)] if tail else []))


def assert_same(states, others, tolerance=1e-9):
    np.testing.assert_array_equal(states.stamp_ns, others.stamp_ns)
    np.testing.assert_array_equal(states.stationary, others.stationary)
    for value in ('position', 'velocity', 'attitude', 'angular_velocity'):
        for name in (value, f'{value}_covariance'):
            np.testing.assert_allclose(
                getattr(states, name), getattr(others, name), rtol=tolerance, atol=tolerance
            )


def imu(k, force=(0.0, 0.0, 9.81), rate=(0.0, 0.0, 0.0), **more):
    return ImuSample(START_NS + k * 5_000_000, 'imu_link', force, angular_velocity=rate, **more)


def at_rest(found, count=400, begin=0, **more):
    states = []
    for k in range(begin, begin + count):
        try:
            states += found.update(imu(k, **more))
        except NotLevelledError:
            assert not found.aligned
    return states


def test_at_rest_it_stays_where_it_is():
    found = navigator()
    states = at_rest(found)
    last = states[-1]
    np.testing.assert_allclose(last.position, 0.0, atol=1e-9)
    np.testing.assert_allclose(last.velocity, 0.0, atol=1e-9)
    assert last.attitude == pytest.approx((0.0, 0.0, 0.0, 1.0))
    assert last.stationary
    assert found.stationary
    assert found.statistic < found.threshold
    assert found.counts['zero_velocity'] == found.counts['zero_rate'] + 78  # the first 0.4 s
    assert 'gravity is 9.8100' in found.aligned
    delay = 8  # half the window and the shortest rest at 200 Hz
    stamps = [state.stamp_ns for state in states]
    assert stamps == [imu(k).stamp_ns for k in range(100, 400 - delay)]
    assert [state.stamp_ns for state in found.flush()] == [
        imu(k).stamp_ns for k in range(400 - delay, 400)
    ]


def test_without_look_ahead_nothing_is_late():
    found = navigator(look_ahead=0.0)
    at_rest(found)
    (state,) = found.update(imu(400))
    assert state.stamp_ns == imu(400).stamp_ns
    assert found.flush() == []


def test_it_does_not_align_while_moving():
    found, shaken = navigator(), np.random.default_rng(0)
    for k in range(600):
        force = tuple(shaken.normal([0.0, 0.0, 9.81], 1.0).tolist())
        with pytest.raises(NotLevelledError):
            found.update(imu(k, force))
    for k in range(600, 1200):
        rate = (0.0, 0.5 * (k % 2), 0.0)
        with pytest.raises(NotLevelledError):
            found.update(imu(k, rate=rate))
    assert at_rest(found, begin=1200)[-1].position == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_a_gap_is_no_part_of_the_rest_that_aligns():
    found = navigator()
    at_rest(found, 60)
    at_rest(found, 100, 1060)
    assert not found.aligned
    at_rest(found, 1, 1160)
    assert '200.0 samples a second' in found.aligned


def test_numbers_that_just_pass_leave_it_in_order():
    found = navigator()
    at_rest(found)
    at_rest(found, 1, 400, force=(1e6, -1e6, 1e6))
    states = at_rest(found, 2000, 401)
    p = found._state[layout.COVARIANCE : layout.COVARIANCE + 256].reshape(16, 16)
    assert (p == p.T).all()
    assert np.linalg.eigvalsh(p[:15, :15])[0] > 0.0
    assert np.linalg.norm(states[-1].velocity) < 0.05


def test_what_is_no_gravity_is_no_rest():
    found = navigator()
    at_rest(found, force=(0.0, 0.0, 1.0))
    assert not found.aligned
    assert {type(finding) for finding in found.findings} == {GravityError}


def test_any_mounting_and_a_sensor_that_rests_at_another_gravity():
    force = tuple((9.9 * MOUNTED[2]).tolist())
    state = at_rest(navigator(), 2000, force=force)[-1]
    np.testing.assert_allclose(state.position, 0.0, atol=1e-6)


FAULTS = {
    NotFiniteError: {'force': (NAN, 0.0, 9.8)},
    MissingRateError: {'rate': None},
    MissingAccelerationError: {'specific_force_covariance': NOT_MEASURED},
}


def test_a_fault_changes_nothing():
    found, same = navigator(), navigator()
    at_rest(found), at_rest(same)
    for error, sample in FAULTS.items():
        with pytest.raises(error):
            found.update(imu(400, **sample))
    with pytest.raises(NotFiniteError):
        found.update(imu(400, rate=(0.0, 1e7, 0.0)))
    with pytest.raises(RepeatedStampError):
        found.update(imu(399))
    moving = {'force': (1.0, -2.0, 12.0), 'rate': (0.4, 1.0, -2.0)}
    assert_same(
        StateBlock.of(at_rest(found, 100, 400, **moving)),
        StateBlock.of(at_rest(same, 100, 400, **moving)),
        tolerance=0.0,
    )


def test_stamps_that_go_back_start_it_over():
    found = navigator()
    at_rest(found)
    with pytest.raises(NotLevelledError):
        found.update(imu(-1000))
    assert found.restarts == 1
    assert not found.aligned


def test_over_a_gap_uncertainty_grows_and_it_goes_on():
    found = navigator()
    before = at_rest(found)[-1]
    states = at_rest(found, 1, 800)
    assert len(states) == 8  # those that waited; a gap is nothing to look ahead into
    assert [type(finding) for finding in found.findings] == [GapError]
    after = at_rest(found, 100, 801)
    assert found.counts['gap'] == 1
    grown = 2.0 * 401 * 0.005  # 2 m/s over the gap
    assert after[0].stamp_ns == imu(800).stamp_ns
    for axis in (0, 4):
        assert after[0].position_covariance[axis] == pytest.approx(
            before.position_covariance[axis] + grown**2, rel=1e-3
        )
        assert after[0].velocity_covariance[axis] == pytest.approx(4.0)
    assert after[-1].velocity_covariance[0] < 1e-3
    np.testing.assert_allclose(after[-1].position, before.position, atol=1e-6)


POISONS = {
    'NaN': {layout.X_VELOCITY: NAN},
    'infinite': {layout.X_FORCE_BIAS: float('inf')},
    'far': {layout.X_POSITION: 1e13},
    'no rotation': {layout.X_ATTITUDE + i: 0.0 for i in range(4)},
    'no variance': {layout.COVARIANCE + 17 * 6: -0.1},
    'no covariance': {layout.COVARIANCE + 16 * 9 + 12: NAN},
}


@pytest.mark.parametrize('poison', POISONS.values(), ids=POISONS)
@pytest.mark.parametrize('way', ['stream', 'blocks', 'at a gap', 'at the end'])
def test_what_is_no_state_never_comes_out_and_it_begins_anew(poison, way):
    found = navigator()
    last_ns = at_rest(found)[-1].stamp_ns
    for index, value in poison.items():
        found._state[index] = value
    if way == 'blocks':
        block = ImuBlock.of([imu(k) for k in range(400, 800)])
        states = [
            s for part in blocks_of(found, block) for s in map(part.sample, range(len(part)))
        ]
    elif way == 'at the end':
        assert found.flush() == []
        states = at_rest(found, 400, 400)
    else:
        states = at_rest(found, 400, 400 if way == 'stream' else 900)
    assert [type(finding) for finding in found.findings] == [DivergedError]
    assert found.aligned
    assert states[0].stamp_ns > last_ns + 0.5e9  # once it has rested
    assert states[0].position == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
    assert np.isfinite([(*s.position, *s.velocity_covariance) for s in states]).all()


def test_blocks_give_what_the_stream_gives_where_it_diverges():
    """After a gap of 60 years, at 1000 m/s."""
    moved = measured(WALK, 1)
    block = moved.block()
    block.stamp_ns[700:] += 2 * 10**9 * NANOSECONDS
    settings = {'gap_speed': 1000.0, 'rest_duration': 0.2}
    stream, found = navigator(**settings), navigator(**settings)
    one_by_one, parts = streamed(stream, block), in_blocks(found, block, [710, 900])
    assert_same(parts, one_by_one)
    kinds = [type(finding) for finding in stream.findings]
    assert kinds == [type(finding) for finding in found.findings] == [GapError, DivergedError]
    assert len(one_by_one) < len(block) - 50


def test_a_correction_of_any_size_turns_the_velocity():
    x, dx = np.zeros(17), np.zeros(16)
    x[3:6], x[13:17] = (30.0, 4.0, 0.0), (0.0, 0.0, 0.6, 0.8)
    dx[3:6], dx[6:9] = (-30.0, -4.0, 2.0), (0.0, 3.0, 40.0)
    correct(x, dx)
    assert np.linalg.norm(x[3:6]) == pytest.approx(2.0)
    assert Rotation.from_quat(x[13:17]).inv().apply(x[3:6]) == pytest.approx((0.0, 0.0, 2.0))


def test_a_clipped_sample_counts_and_widens_the_covariance():
    found, same = navigator(force_range=40.0, rate_range=10.0), navigator()
    for each in (found, same):
        at_rest(each)
        each.last = at_rest(each, 20, 400, force=(40.0, 0.0, 9.8), rate=(0.0, -10.0, 0.0))[-1]
    assert found.counts['saturated'] == 12
    assert found.last.velocity_covariance[0] > 2.0 * same.last.velocity_covariance[0]
    assert found.last.attitude_covariance[0] > same.last.attitude_covariance[0]


@pytest.mark.parametrize('detector', names())
def test_blocks_give_what_the_stream_gives(detector):
    moved = measured(WALK, 1)
    block = moved.block()
    block.specific_force[900] = NAN
    block.angular_velocity_covariance[1100] = NOT_MEASURED
    block.angular_velocity_covariance[1200:1300, ::4] = 1e-5
    block.stamp_ns[1400] = block.stamp_ns[1399]
    block.stamp_ns[1500:] += NANOSECONDS
    stream = navigator(detector=(detector,))
    one_by_one = []
    for index in range(len(block)):
        with suppress(SampleError):
            one_by_one += stream.update(block.sample(index))
    one_by_one += stream.flush()
    random = np.random.default_rng(2)
    for cuts in ([], sorted(random.integers(0, len(block), 7).tolist())):
        found = navigator(detector=(detector,))
        assert_same(in_blocks(found, block, cuts), StateBlock.of(one_by_one))
        assert found.counts == stream.counts
        assert found.strides.count == stream.strides.count
        assert found.strides.distance == pytest.approx(stream.strides.distance, rel=1e-9)


def test_covariances_are_those_of_position_velocity_attitude_and_rate():
    found, kept = navigator(), []
    found.history = SimpleNamespace(
        newer=lambda: None, add=lambda *given: kept.append([np.copy(each) for each in given])
    )
    streamed(found, WALK.block().part(0, 760))
    samples, verdicts = (np.concatenate([each[i] for each in kept]) for i in (0, 1))
    out, trace, _ = filtered(kept[0][4], kept[0][5], samples, verdicts)
    k = 680  # on the swing
    p, shape = trace[k, 33:289].reshape(16, 16), (3, 3)
    np.testing.assert_allclose(out[k, 10:19].reshape(shape), p[:3, :3], rtol=1e-12)
    np.testing.assert_allclose(out[k, 19:28].reshape(shape), p[3:6, 3:6], rtol=1e-12)
    np.testing.assert_allclose(out[k, 28:37].reshape(shape), p[6:9, 6:9], rtol=1e-12)
    noise = 0.005**2 * np.eye(3)  # common.rate_deviation
    np.testing.assert_allclose(out[k, 40:49].reshape(shape), p[9:12, 9:12] + noise, rtol=1e-12)
    state = state_of(1, out[k].tolist())
    assert state.pose_cross_covariance == tuple(p[:3, 6:9].ravel())
    assert state.twist_cross_covariance == tuple(-p[3:6, 9:12].ravel())


def test_the_covariance_of_the_velocity_is_that_of_the_twist():
    """Errors are drawn, put into the state as the filter would, and seen from the body."""
    found = navigator()
    streamed(found, WALK.block().part(0, 690))
    x = found._state[: layout.X]
    p = found._state[layout.COVARIANCE : layout.COVARIANCE + 256].reshape(16, 16)
    p[6:9, 6:9] += 0.01 * np.eye(3)  # an attitude that is hardly known
    found_twist = Rotation.from_quat(x[13:17]).inv().apply(x[3:6])
    assert np.linalg.norm(found_twist) > 0.5
    twists = []
    for drawn in np.random.default_rng(0).multivariate_normal(np.zeros(16), p, 4000):
        true = x.copy()
        correct(true, drawn)
        twists.append(Rotation.from_quat(true[13:17]).inv().apply(true[3:6]) - found_twist)
    out = np.zeros(layout.STATE_ROW)
    put_state(out, x, p, (0.0, 0.0, 0.0), 0.0, 0.0)
    turn = Rotation.from_quat(out[6:10]).as_matrix()
    published = turn.T @ out[19:28].reshape(3, 3) @ turn
    spread = np.cov(np.transpose(twists))
    np.testing.assert_allclose(spread, published, atol=0.1 * np.diag(published).max())


def test_without_numba_it_gives_the_same():
    block = WALK.block()
    found = navigator()
    streamed(found, block.part(0, 500))
    found.flush()
    rows = np.zeros((40, layout.ROW))
    rows[:, 0], rows[:, 1:4], rows[:, 4:7] = 0.005, WALK.force[600:640], WALK.rate[600:640]
    verdicts = np.full((40, 3), 0.1)
    verdicts[15:30, 2] = 0.0
    outs = []
    for function in (navigate, navigate.__wrapped__):
        state, out = found._state.copy(), np.zeros((40, layout.STATE_ROW))
        trace, log = np.zeros((40, layout.TRACE_ROW)), np.zeros((400, layout.LOG_ROW))
        function(rows, verdicts, NO_AIDS, found._rules, state, out, trace, log)
        outs.append((state, out, trace, log))
    for compiled, plain in zip(*outs, strict=True):
        np.testing.assert_allclose(compiled, plain, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize('gait', [{}, {'turn': 0.2}, {'stride_length': 0.8, 'stride_time': 1.4}])
def test_a_walk_comes_out_as_it_was(gait):
    true = walk(strides=20, **gait)
    found, states = navigated(measured(true, 3))
    length = np.linalg.norm(np.diff(true.position[::20], axis=0), axis=1).sum()
    skipped = len(true.time) - len(states)
    # The yaw starts at zero, wherever the sensor looks: compare what does not depend on it.
    way = true.position[-1] - true.position[0]
    assert np.linalg.norm(states.position[-1]) == pytest.approx(
        np.linalg.norm(way), abs=0.006 * length
    )
    assert abs(states.position[-1, 2] - way[2]) < 0.02
    assert found.strides.count == 20
    strides = gait.get('stride_length', 1.4) * 20
    assert found.strides.distance == pytest.approx(strides, rel=0.005)
    still = np.linalg.norm(true.velocity, axis=1)[skipped:] == 0.0
    assert states.stationary[still].mean() > 0.9
    assert states.stationary[np.linalg.norm(true.velocity, axis=1)[skipped:] > 0.5].mean() < 0.01


@pytest.mark.parametrize(
    ('gait', 'height'),
    [
        ({'strides': 12, 'stride_length': 0.29, 'rise': 0.17}, 12 * 0.17),
        ({'strides': 6, 'stride_length': 0.58, 'rise': -0.34}, -6 * 0.34),
        ({'strides': 20, 'stride_length': 1.4, 'rise': 0.07}, 20 * 0.07),
        ({'strides': 20, 'stride_length': 1.0, 'rise': 0.05}, 20 * 0.05),
    ],
    ids=['stairs', 'stairs down, two steps a stride', 'ramp', 'ramp with short strides'],
)
def test_stairs_and_ramps_are_not_flattened(gait, height):
    level = {'strides': 6, 'stride_length': 1.3}
    true = joined(
        walk(end=0.2, **level), walk(start=0.2, end=0.2, **gait), walk(start=0.2, **level)
    )
    for seed in range(6):
        _, states = navigated(measured(true, seed))
        assert states.position[-1, 2] == pytest.approx(height, rel=0.03)


def test_level_floor_bounds_the_height():
    moved = measured(walk(strides=20), 4, force_bias=0.3)
    found, states = navigated(moved)
    free, drifted = navigated(moved, floor=False)
    assert abs(states.position[-1, 2]) < abs(drifted.position[-1, 2])
    assert found.counts['floor'] >= 20
    assert free.counts['floor'] == free.counts['new_floor'] == 0


def rotated(walk, rotation):
    """Return a walk whose sensor is turned in its housing."""
    return Walk(
        walk.time, walk.force @ rotation, walk.rate @ rotation,
        walk.position, walk.velocity, walk.rotation,
    )  # fmt: skip


def test_a_turned_sensor_walks_the_same_way():
    moved = measured(WALK, 5)
    _, states = navigated(moved)
    _, others = navigated(rotated(moved, MOUNTED))
    # But for the yaw, which starts at zero for either: one turn about the vertical for all.
    ways = [s.position[:, 0] + 1j * s.position[:, 1] for s in (states, others)]
    turn = ways[1][-1] / ways[0][-1]
    assert abs(turn) == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(ways[1], turn * ways[0], atol=1e-8)
    np.testing.assert_allclose(others.position[:, 2], states.position[:, 2], atol=1e-8)


def test_a_mirrored_sensor_walks_the_mirrored_way():
    moved, mirror = measured(WALK, 6), np.array([1.0, -1.0, 1.0])
    mirrored = Walk(
        moved.time, moved.force * mirror, -moved.rate * mirror,
        moved.position, moved.velocity, moved.rotation,
    )  # fmt: skip
    _, states = navigated(moved)
    _, others = navigated(mirrored)
    np.testing.assert_allclose(others.position, states.position * mirror, atol=1e-9)


def test_another_time_gives_the_same():
    moved = measured(WALK, 7)
    states = in_blocks(navigator(), moved.block(), [])
    later = in_blocks(navigator(), moved.block(START_NS + 123_456_789), [])
    np.testing.assert_array_equal(later.position, states.position)
    assert set((later.stamp_ns - states.stamp_ns).tolist()) == {123_456_789}


@pytest.mark.parametrize('rate', [100.0, 400.0])
def test_another_rate_gives_nearly_the_same(rate):
    ends, deviations = [], []
    for each in (rate, 200.0):
        found, states = navigated(walk(each, strides=10))
        ends.append(states.position[-1])
        assert found.strides.count == 10
        deviations.append(np.sqrt(states.position_covariance[-1, [0, 4, 8]]))
    assert (np.abs(ends[0] - ends[1]) < 0.25 * deviations[1]).all()
    np.testing.assert_allclose(deviations[0], deviations[1], rtol=0.15)


def averaged(walk, count):
    """Return a walk of which so many samples each were averaged."""
    n = len(walk.time) // count * count
    columns = [
        column[:n].reshape(-1, count, *column.shape[1:]).mean(axis=1)
        for column in (walk.time, walk.force, walk.rate, walk.position, walk.velocity)
    ]
    return Walk(*columns, walk.rotation[count // 2 : n : count])


def test_means_at_a_low_rate_lose_little():
    """A walk measured at 400 Hz and averaged to 50 ends nearly where it does at full rate."""
    full, far = walk(400.0, strides=20, turn=0.1), []
    _, states = navigated(full)
    for averaging in (1.0, 0.0):
        _, others = navigated(averaged(full, 8), averaging=averaging)
        far.append(np.linalg.norm(others.position[-1, :2] - states.position[-1, :2]))
    length = np.linalg.norm(np.diff(full.position, axis=0), axis=1).sum()
    assert far[0] < 0.002 * length
    assert far[0] < 0.5 * far[1]


def test_covariance_stays_one_for_ten_hours():
    true = walk(100.0, strides=40, turn=np.pi / 20.0)
    random = np.random.default_rng(8)
    found, _ = navigated(measured(true, 8))
    begin = round(100.0 * 2.5)  # in the first rest: all that comes after repeats
    count = len(true.time) - begin
    rows = np.zeros((count, layout.ROW))
    stamp_ns, hours = found._timeline._last_ns, 10.0
    for _ in range(round(hours * 360_000 / count)):
        rows[:, 0] = 0.01
        rows[:, 1:4] = true.force[begin:] + random.normal(0.0, 0.1, (count, 3))
        rows[:, 4:7] = true.rate[begin:] + random.normal(0.0, 0.003, (count, 3))
        stamps = stamp_ns + 10_000_000 * (1 + np.arange(count))
        stamp_ns = int(stamps[-1])
        states = found.take(rows, stamps)
    p = found._state[layout.COVARIANCE : layout.COVARIANCE + 256].reshape(16, 16)
    assert (p == p.T).all()
    assert np.linalg.eigvalsh(p[:15, :15])[0] > 0.0
    assert np.isfinite(states.position).all()
    assert np.linalg.norm(found._state[layout.X_ATTITUDE : layout.X_ATTITUDE + 4]) == (
        pytest.approx(1.0, abs=1e-8)
    )


def test_settings_of_the_detector_are_taken():
    kind = detector_class('shoe')
    found = navigator(kind.Settings(least=1.5))
    at_rest(found)
    assert found.threshold == 1.5


def test_settings_are_declared_once_for_filter_and_user():
    declared = {p.name: p for p in NavigatorSettings.parameters()}
    for name in ('acceleration_noise', 'sway', 'still_window', 'floor_slope', 'max_gap'):
        assert declared[name].key == f'navigator.{name}'
    switches = {name for name in RULES if declared[name].type is bool}
    changed = {name: 1.5 * declared[name].default for name in RULES if name not in switches}
    changed |= {'force_range': 1.0, 'rate_range': 2.0}
    found = navigator(**changed)
    at_rest(found)
    for name, value in changed.items():
        assert found._rules[getattr(layout, name.upper())] == pytest.approx(value)
    assert len(set(changed.values())) > 15  # so that a wrong place shows
    for name in switches:
        found.configure(NavigatorSettings(**{each: each == name for each in switches}))
        on = [found._rules[getattr(layout, each.upper())] > 0.0 for each in switches]
        assert on == [each == name for each in switches]
    with pytest.raises(SettingsError, match=r'navigator\.detector'):
        NavigatorSettings(detector=('none',))


def test_no_accelerometer_bias_where_it_is_left_out():
    found, _ = navigated(measured(WALK, 9), acceleration_bias=0.0)
    bias = found._state[layout.X_FORCE_BIAS : layout.X_FORCE_BIAS + 3]
    assert not bias.any()
    free, _ = navigated(measured(WALK, 9))
    assert free._state[layout.X_FORCE_BIAS : layout.X_FORCE_BIAS + 3].any()


def test_strides_are_counted_from_stance_to_stance():
    strides = Strides()
    places = [(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (1.1, 0.0, 0.0), (1.1, 0.3, 0.4)]
    for x, y, z in places:
        strides.update(False, (x + 0.5, y, z))
        strides.update(True, (x + 0.01, y, z))
        strides.update(True, (x, y, z))
    assert strides.count == 2
    assert strides.distance == pytest.approx(0.1 + 1.0 + 0.5)
