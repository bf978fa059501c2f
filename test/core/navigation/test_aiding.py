"""Compass, bounded velocity and wheels: what they measure, when they are refused, what they do."""

from contextlib import suppress
from itertools import pairwise

import numpy as np
import pytest
from moving_state import DT, LEVEL_WALK, STATE, jacobian, measurements, placed
from scipy.spatial.transform import Rotation
from simulated_drives import driven, length, navigated_drive, way
from simulated_walks import (
    START_NS,
    blocks_of,
    measured,
    navigator,
    walk,
)

from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.errors import MissingAttitudeError, NotLevelledError, StaleCompassError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.navigation.aids import aid_row
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.samples import NOT_MEASURED, ZERO, ImuSample
from dead_reckoning.core.smoother import Smoother

DEGREE = np.pi / 180.0


def compass(stamp_ns, yaw, deviation=2.5 * DEGREE):
    huge, variance = 1e6, deviation**2
    return ImuSample(
        int(stamp_ns), 'compass', ZERO, NOT_MEASURED,
        orientation=quaternion_from_euler(0.0, 0.0, yaw),
        orientation_covariance=(huge, 0.0, 0.0, 0.0, huge, 0.0, 0.0, 0.0, variance),
    )  # fmt: skip


def yaw_of(walk):
    return np.unwrap(Rotation.from_matrix(walk.rotation).as_euler('xyz')[:, 2])


def turned_by(found, states, walk):
    """Return by how much the yaw of states is beyond that of a walk [rad]."""
    stamps = START_NS + np.round(walk.time * 1e9).astype(np.int64)
    true = yaw_of(walk)[np.searchsorted(stamps, states.stamp_ns)]
    yaw = Rotation.from_quat(states.attitude).as_euler('xyz')[:, 2]
    return (yaw - true + np.pi) % (2.0 * np.pi) - np.pi


def with_compass(walk, headings, found=None, **settings):
    """Return navigator and states for a walk, with headings [rad] by the number of the sample."""
    found = found or navigator(**settings)
    block, states = walk.block(), []
    for index in range(len(block)):
        if index in headings:
            found.follow_compass(compass(block.stamp_ns[index] - 2_000_000, headings[index]))
        with suppress(NotLevelledError):
            states += found.update(block.sample(index))
    return found, StateBlock.of(states + found.flush())


def test_what_a_compass_measures_is_the_yaw():
    rules, state, row = placed(compass_correlation=0.0, averaging=0.0)
    values = (0.3, 1e-4, 0.1, 0.0, 0.0, layout.BY_COMPASS)
    aid = np.array([aid_row(0, layout.YAW, values, 0)])
    rules[layout.AXIS_GATE] = 1e9
    x, ((h, innovation),) = measurements(rules, state, row, aid)

    def yaw(velocity, rotation, bias):
        first = rotation.as_matrix()[:, 0]
        return np.arctan2(first[1], first[0])

    np.testing.assert_allclose(h, jacobian(yaw, x), atol=1e-8)
    expected = 0.3 - yaw(None, Rotation.from_quat(x[13:17]), None)
    assert innovation == pytest.approx((expected + np.pi) % (2.0 * np.pi) - np.pi)


def test_what_wheels_measure_is_the_velocity_of_their_axle():
    arm = np.array([-1.2, 0.3, -0.5])
    rules, state, row = placed(nonholonomic=True, axle=tuple(arm), axis_gate=1e9)
    x, found = measurements(rules, state, row)

    def at_axle(velocity, rotation, bias):
        return (rotation.inv().apply(velocity) + np.cross(STATE['rate'] - bias, arm))[1:]

    expected = jacobian(at_axle, x)
    value = at_axle(x[3:6], Rotation.from_quat(x[13:17]), x[6:9])
    assert len(found) == 2
    for axis, (h, _) in enumerate(found):
        np.testing.assert_allclose(h, expected[axis], atol=1e-8)
    assert found[0][1] == pytest.approx(-value[0])


def test_what_a_held_body_measures_is_its_velocity():
    rules, state, row = placed(gravity_direction=True, gate=1e9)
    x, found = measurements(rules, state, row)
    expected = jacobian(lambda velocity, rotation, bias: velocity, x)
    # ξ is the velocity but for the turn θ × v, of which a velocity that is zero has none.
    h = np.array([h for h, _ in found])
    np.testing.assert_allclose(h[:, 3:6], expected[:, 3:6], atol=1e-8)
    assert found[0][1] == pytest.approx(-x[3])


def test_the_first_yaw_is_that_of_the_compass():
    yaw = yaw_of(LEVEL_WALK)
    headings = {20: yaw[20] + 2.0}
    found, states = with_compass(LEVEL_WALK, headings)
    assert turned_by(found, states, LEVEL_WALK)[0] == pytest.approx(2.0, abs=1e-3)
    assert states.attitude_covariance[0, 8] == pytest.approx((2.5 * DEGREE) ** 2, rel=1e-3)
    for ignored in ({'compass': False}, {'compass_timeout': 0.2}):
        _, states = with_compass(LEVEL_WALK, headings, **ignored)
        assert states.attitude_covariance[0, 8] < 1e-5
        begin = Rotation.from_quat(states.attitude[0]).as_euler('xyz')[2]
        assert begin == pytest.approx(0.0, abs=1e-3)


def test_turning_the_world_turns_the_way():
    moved, yaw, ways = measured(LEVEL_WALK, 3), yaw_of(LEVEL_WALK), []
    for turn in (0.0, 2.2):
        found, states = with_compass(moved, {k: yaw[k] + turn for k in range(0, len(yaw), 10)})
        ways.append((found.counts, states.position[:, 0] + 1j * states.position[:, 1]))
    assert ways[0][0] == ways[1][0]
    np.testing.assert_allclose(ways[1][1], np.exp(2.2j) * ways[0][1], atol=1e-9)


def test_a_compass_that_comes_late_turns_the_way_on_from_there():
    yaw = yaw_of(LEVEL_WALK)
    late = 1300
    headings = {k: yaw[k] + 1.0 for k in range(late, len(yaw), 10)}
    found, states = with_compass(LEVEL_WALK, headings)
    _, others = with_compass(LEVEL_WALK, {})
    n = late - int(np.searchsorted(LEVEL_WALK.block().stamp_ns, states.stamp_ns[0]))
    np.testing.assert_array_equal(states.position[: n - 10], others.position[: n - 10])
    jump = np.linalg.norm(np.diff(states.position, axis=0), axis=1).max()
    assert jump < 1.1 * np.linalg.norm(np.diff(others.position, axis=0), axis=1).max()
    assert turned_by(found, states, LEVEL_WALK)[-1] == pytest.approx(1.0, abs=0.01)
    p = found._state[layout.COVARIANCE : layout.COVARIANCE + 256].reshape(16, 16)
    assert (p == p.T).all()
    assert np.linalg.eigvalsh(p[:15, :15])[0] > 0.0


def test_yaw_that_drifts_follows_the_compass():
    slow = walk(strides=40, turn=0.3, mounted=np.eye(3))
    moved = measured(slow, 2)
    moved.rate[600:] += [0.0, 0.0, 0.01]  # a bias that no rest shows
    yaw = yaw_of(slow)
    headings = {k: yaw[k] for k in range(0, len(yaw), 10)}
    ends = [
        turned_by(*with_compass(moved, given, still_deviation=0.0, compass_correlation=0.5), slow)[
            -1
        ]
        for given in (headings, {20: yaw[20]})
    ]
    assert abs(ends[0]) < 0.25 * abs(ends[1])
    assert abs(ends[1]) > 5.0 * DEGREE


def test_a_heading_is_taken_at_its_own_time():
    """One that is old is compared with the yaw that was, by the rate since."""
    rules, state, row = placed(compass_correlation=0.0, axis_gate=1e9)
    values = (0.3, 1e-4, 0.1, 0.0, 0.0, layout.BY_COMPASS)
    aid = np.array([aid_row(0, layout.YAW, values, 0)])
    old = aid.copy()
    old[0, 1] = -0.2
    x, ((h, now),) = measurements(rules, state.copy(), row, aid)
    _, ((_, then),) = measurements(rules, state.copy(), row, old)
    turn = Rotation.from_quat(x[13:17]).apply(STATE['rate'] - x[6:9])
    assert then - now == pytest.approx(0.2 * h[6:9] @ turn, rel=1e-6)
    # The attitude is that of the middle of the time of which the sample is a mean.
    yaw = Rotation.from_quat(x[13:17]).as_euler('xyz')[2]
    assert now == pytest.approx(0.3 - yaw - 0.5 * DT * h[6:9] @ turn, rel=1e-6)


def test_iron_on_the_way_is_refused_until_it_lasts_too_long():
    yaw = yaw_of(LEVEL_WALK)
    headings = {k: yaw[k] + (0.6 if k > 700 else 0.0) for k in range(0, len(yaw), 10)}
    found, states = with_compass(LEVEL_WALK, headings, compass_correlation=1e3)
    assert found.counts['compass_refused'] > 100
    assert abs(turned_by(found, states, LEVEL_WALK)[-1]) < 0.02
    found, states = with_compass(LEVEL_WALK, headings, compass_correlation=2.0)
    assert found.counts['compass_refused'] < 60
    assert turned_by(found, states, LEVEL_WALK)[-1] > 0.2


@pytest.mark.parametrize('interval', [0.05, 0.2])
def test_errors_of_the_compass_that_last_are_known_as_such(interval):
    """However often it comes: NEES of the yaw with an error that is correlated over 4 s."""
    time, deviation = 4.0, 2.5 * DEGREE
    rest = walk(50.0, strides=2, end=30.0, mounted=np.eye(3))
    yaw, step = yaw_of(rest), round(interval * 50.0)
    random, errors = np.random.default_rng(3), []
    for _ in range(40):
        keep, wrong, headings = np.exp(-interval / time), deviation * random.normal(), {}
        for k in range(0, len(yaw), step):
            headings[k] = yaw[k] + wrong
            wrong = keep * wrong + np.sqrt(1.0 - keep**2) * deviation * random.normal()
        found, states = with_compass(rest, headings, compass_correlation=time, axis_gate=1e9)
        errors.append(turned_by(found, states, rest)[-1] ** 2 / states.attitude_covariance[-1, 8])
    assert states.attitude_covariance[-1, 8] < 0.5 * deviation**2  # it does average
    assert 0.4 < np.mean(errors) < 1.5


def test_a_compass_that_falls_silent_is_said_once():
    yaw = yaw_of(LEVEL_WALK)
    found, _ = with_compass(LEVEL_WALK, {k: yaw[k] for k in range(0, 500, 10)})
    assert [type(finding) for finding in found.findings] == [StaleCompassError]
    with pytest.raises(MissingAttitudeError):
        found.follow_compass(ImuSample(START_NS, 'compass', ZERO))


def test_switched_off_it_is_not_followed():
    yaw = yaw_of(LEVEL_WALK)
    headings = dict.fromkeys(range(0, len(yaw), 10), 2.0)
    found, states = with_compass(LEVEL_WALK, headings, compass=False)
    _, others = with_compass(LEVEL_WALK, {})
    assert found.counts['compass'] == found.counts['compass_refused'] == 0
    np.testing.assert_array_equal(states.position, others.position)


@pytest.mark.parametrize('first', [0, 700])
def test_with_a_compass_blocks_give_what_the_stream_gives(first):
    yaw = yaw_of(LEVEL_WALK)
    headings = {k: yaw[k] + 0.3 for k in range(first, len(yaw), 37)}
    found, states = with_compass(LEVEL_WALK, headings)
    same, block, blocks = navigator(), LEVEL_WALK.block(), []
    edges = sorted({0, *headings, len(block)})
    for begin, end in pairwise(edges):
        if begin in headings:
            same.follow_compass(compass(block.stamp_ns[begin] - 2_000_000, headings[begin]))
        blocks += blocks_of(same, block.part(begin, end))
    others = StateBlock.join([*blocks, StateBlock.of(same.flush())])
    assert same.counts == found.counts
    assert found.counts['compass'] > 40
    np.testing.assert_allclose(others.position, states.position, atol=1e-12)
    np.testing.assert_allclose(others.attitude_covariance, states.attitude_covariance, rtol=1e-9)


@pytest.mark.parametrize('first', [0, 1300])
def test_with_a_compass_the_smoother_ends_where_the_filter_does(first):
    yaw = yaw_of(LEVEL_WALK)
    random = np.random.default_rng(5)
    headings = {k: yaw[k] + random.normal(0.3, 0.04) for k in range(first, len(yaw), 10)}
    found = navigator(compass_correlation=0.1)
    record = Smoother(found)
    _, states = with_compass(measured(LEVEL_WALK, 4), headings, found)
    smoothed = StateBlock.join(list(record.blocks())[::-1])
    smoothed = smoothed.part(len(smoothed) - len(states), len(smoothed))
    np.testing.assert_allclose(smoothed.position[-1], states.position[-1], atol=1e-9)
    np.testing.assert_allclose(smoothed.attitude[-1], states.attitude[-1], atol=1e-9)
    spread, better = states.attitude_covariance[:, 8], smoothed.attitude_covariance[:, 8]
    assert (better <= spread * (1.0 + 1e-6)).all()
    if first == 0:
        before, after = (np.std(turned_by(found, each, LEVEL_WALK)) for each in (states, smoothed))
        assert after < 0.6 * before


@pytest.mark.parametrize(
    ('switch', 'others'),
    [
        ('zero_velocity', {}),
        ('zero_rate', {}),
        ('floor', {}),
        ('gravity_direction', {'gravity_direction': True}),
        ('nonholonomic', {'nonholonomic': True}),
    ],
)
def test_what_is_switched_off_on_the_way_stops_and_goes_on_when_switched_on(switch, others):
    found, block = navigator(**others), LEVEL_WALK.block()
    counted, begin = [], 0
    for end, on in ((800, True), (1800, False), (len(block), True)):
        found.configure(NavigatorSettings(**{**others, switch: on, 'gate': 1.0}))
        blocks_of(found, block.part(begin, end))
        begin = end
        counted.append(found.counts[switch])
    assert 0 < counted[0] == counted[1] < counted[2]
    assert found.settings.gate == 50.0  # what may not change did not


def test_wheels_keep_a_vehicle_on_its_way():
    true = driven(loops=2)
    farthest = {}
    for wheels in (False, True):
        for seed in range(3):
            found, states = navigated_drive(true, seed, nonholonomic=wheels)
            error = states.position - way(true, states)
            farthest.setdefault(wheels, []).append(np.linalg.norm(error, axis=1).max())
    spread = np.sqrt(states.position_covariance[:, ::4].sum(axis=1))
    assert np.mean(farthest[True]) < 0.6 * np.mean(farthest[False])
    assert max(farthest[True]) < 0.04 * length(true)
    assert np.sqrt(np.mean((np.linalg.norm(error, axis=1) / spread)[1000:] ** 2)) < 3.0
    assert found.counts['nonholonomic'] > 20 * found.counts['nonholonomic_refused']


@pytest.mark.parametrize('seed', range(4))
def test_without_a_rest_a_drive_of_six_kilometres_is_as_wrong_as_it_says(seed):
    """A turn of R̂ must not show the speed: else it is 250 km, and σ a sixteenth of that."""
    true = driven(length=2000.0, width=1000.0, loop_time=400.0, loops=1)
    rests = {'zero_velocity': False, 'zero_rate': False}
    found, states = navigated_drive(true, seed, 0.0, nonholonomic=True, **rests)
    error = np.linalg.norm(states.position - way(true, states), axis=1)
    spread = np.sqrt(states.position_covariance[:, ::4].sum(axis=1))
    assert (error / spread)[1000:].max() < 4.0
    assert error.max() < 0.1 * length(true)
    assert found.counts['nonholonomic_refused'] == 0


def test_a_sensor_off_the_axle_is_told_so():
    arm = (1.5, 0.3, 0.5)
    true = driven(loops=1, stops=2, arm=arm)
    ends = []
    for axle in ((0.0, 0.0, 0.0), tuple(-a for a in arm)):
        _, states = navigated_drive(true, 1, axle=axle, slip=0.02, slip_angle=0.0)
        ends.append(np.linalg.norm(states.position - way(true, states), axis=1).max())
    assert ends[1] < 0.7 * ends[0]
