"""Velocities and poses of other frames and points; what is refused, and why."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from moving_state import LEVEL_WALK
from scipy.spatial.transform import Rotation
from simulated_walks import START_NS, Walk, blocks_of, measured, navigator

from benchmarks.accuracy.inertial import VEHICLE
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.aiding import Aiding
from dead_reckoning.core.chain import FAULT, Chain
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import AidingError, NotFiniteError, NotLevelledError, SampleError
from dead_reckoning.core.mounting import Mounting
from dead_reckoning.core.navigator_stage import navigator_stage
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.samples import UNKNOWN, ImuSample, PoseSample, VelocitySample
from dead_reckoning.core.stages import (
    AIDING_ODOMETRY,
    AIDING_POSE,
    AIDING_TWIST,
    ODOMETRY,
    RAW,
    SET_POSE,
)

WALK = measured(LEVEL_WALK, 1)
BLOCK = WALK.block()
NOW = 600
STAMP = int(BLOCK.stamp_ns[NOW - 20])
SMALL = (1e-4, 0.0, 0.0, 0.0, 1e-4, 0.0, 0.0, 0.0, 1e-4)
HUGE = 1e6


def begun(mounting=None, frames=None, until=NOW, **settings):
    """Return a navigator on its way, and a chain of it."""
    found = navigator(**settings)
    found.keep()
    stage = navigator_stage(found, lambda _: mounting or Mounting(), frames=frames)
    chain = Chain([stage])
    for index in range(until):
        chain.push(RAW, BLOCK.sample(index))
    return found, chain


def velocity(value, frame_id='base_link', covariance=SMALL, stamp_ns=STAMP):
    return VelocitySample(stamp_ns, frame_id, value, covariance)


def pose(position=(0.0, 0.0, 0.0), yaw=0.0, **changes):
    given = {
        'stamp_ns': STAMP, 'frame_id': 'odom', 'position': position, 'position_covariance': SMALL,
        'attitude': quaternion_from_euler(0.0, 0.0, yaw), 'attitude_covariance': SMALL,
    }  # fmt: skip
    return PoseSample(**{**given, **changes})


def after(chain, count):
    """Return the states of so many more samples."""
    outputs = [o for k in range(NOW, NOW + count) for o in chain.push(RAW, BLOCK.sample(k))]
    return [value for name, value in outputs if name == ODOMETRY]


def faults(chain, name, sample):
    return [str(value) for output, value in chain.push(name, sample) if output == FAULT]


def test_the_frames_of_a_velocity_say_the_same():
    """Of a sensor that is mounted askew and away, its body, the world: one velocity."""
    turn = Rotation.from_euler('xyz', [0.3, -0.4, 1.9])
    at = np.array([0.7, -0.2, 0.3])
    rotation, rate = LEVEL_WALK.rotation[NOW - 20], LEVEL_WALK.rate[NOW - 20]
    body = rotation.T @ LEVEL_WALK.velocity[NOW - 20]
    there = body + np.cross(rate, at)
    wheel = Mounting(tuple(turn.as_quat()), tuple(at))
    spread = Rotation.from_euler('xyz', [0.5, 0.1, -0.8]).as_matrix() @ np.diag([0.02, 0.1, 0.3])
    of_body = spread @ spread.T
    of_sensor = turn.as_matrix().T @ of_body @ turn.as_matrix()
    of_world = rotation @ of_body @ rotation.T
    ends = []
    for value, frame_id, covariance, settings in (
        (there, 'base_link', of_body, {'twist_lever_arm': tuple(at)}),
        (there, '', of_body, {'twist_lever_arm': tuple(at)}),
        (rotation @ there, 'odom', of_world, {'twist_lever_arm': tuple(at)}),
        (turn.inv().apply(there), 'wheel', of_sensor, {}),
    ):
        found = navigator(**settings)
        found.keep()
        mountings = {'wheel': wheel, 'imu_link': Mounting()}
        stage = navigator_stage(found, mountings.__getitem__, frames=FrameSettings(mounting='tf'))
        chain = Chain([stage])
        for index in range(NOW):
            chain.push(RAW, BLOCK.sample(index))
        sample = velocity(tuple(value), frame_id, tuple(covariance.ravel()))
        assert not chain.push(AIDING_TWIST, sample)
        ends.append(found._state[:13].copy())
    for end in ends[1:3]:
        np.testing.assert_allclose(end[:6], ends[0][:6], atol=2e-2)
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-12)
    np.testing.assert_allclose(ends[3], ends[0], atol=1e-9)


def test_odometry_is_the_velocity_of_the_body_not_of_the_sensor():
    arm = (0.5, 0.0, -1.0)
    rate = LEVEL_WALK.rate[NOW - 20]
    at_sensor = LEVEL_WALK.rotation[NOW - 20].T @ LEVEL_WALK.velocity[NOW - 20]
    ends = []
    for mounting, value in (
        (Mounting(), at_sensor),
        (Mounting(translation=arm), at_sensor - np.cross(rate, arm)),
    ):
        found, chain = begun(mounting)
        assert not chain.push(AIDING_ODOMETRY, velocity(tuple(value)))
        ends.append(found._state[:6].copy())
    np.testing.assert_allclose(*ends, atol=2e-3)


def test_each_can_be_switched_off_while_running():
    found, chain = begun()
    off = {'aiding_twist': False, 'aiding_odom': False, 'aiding_pose': False}
    found.configure(found.settings.changed({f'navigator.{n}': v for n, v in off.items()}))
    before = found._state.copy()
    for name in (AIDING_TWIST, AIDING_ODOMETRY):
        assert not chain.push(name, velocity((3.0, 0.0, 0.0)))
    assert not chain.push(AIDING_POSE, pose((9.0, 9.0, 9.0)))
    np.testing.assert_array_equal(found._state, before)


def test_the_first_pose_places_the_body_and_later_ones_are_measured():
    found, chain = begun()
    assert not chain.push(AIDING_POSE, pose((100.0, -50.0, 7.0), 2.0))
    assert found.counts['placed'] == 1
    states = [v for n, v in chain.push(RAW, BLOCK.sample(NOW)) if n == ODOMETRY]
    assert np.hypot(states[0].position[0] - 100.0, states[0].position[1] + 50.0) < 1.0
    strides = found.strides.distance
    assert strides < 10.0  # it did not walk there
    assert not chain.push(AIDING_POSE, pose((100.0, -50.0, 7.0), 2.0, stamp_ns=STAMP + 5_000_000))
    assert found.counts['aiding_pose'] + found.counts['aiding_pose_refused'] == 1
    assert found.counts['aiding_yaw'] + found.counts['aiding_yaw_refused'] == 1
    assert found.counts['placed'] == 1


@pytest.mark.parametrize('ahead_ns', [None, 0, 50_000_000])
def test_a_body_that_is_placed_while_samples_wait_did_not_walk_there(ahead_ns):
    """In the last stance, now or at a stamp that is still to come, sample by sample or not."""
    at = len(BLOCK) - 200
    stamp_ns = 0 if ahead_ns is None else int(BLOCK.stamp_ns[at - 1]) + ahead_ns
    walked = []
    for blocks in (False, True):
        found = navigator()
        for begin, end in ((0, at), (at, len(BLOCK))):
            part = BLOCK.part(begin, end)
            if begin:
                walked.append((found.strides.count, found.strides.distance))
                Aiding(found).set_pose(pose((100.0, -50.0, 7.0), stamp_ns=stamp_ns))
            if blocks:
                blocks_of(found, part)
            else:
                for index in range(len(part)):
                    with suppress(NotLevelledError):
                        found.update(part.sample(index))
        assert found.counts['placed'] == 1
        walked.append((found.strides.count, found.strides.distance))
    assert walked[0][0] == walked[1][0] > 5
    assert walked[1][1] == pytest.approx(walked[0][1], abs=0.01)
    assert walked[3] == pytest.approx(walked[1], abs=1e-9)


@pytest.mark.parametrize('told', [True, False])
def test_a_steady_drive_on_a_smooth_road_is_no_rest_where_a_wheel_says_that_it_moves(told):
    """At 0.3 m/s for 20 s, after a start so smooth that no detector of rest sees it."""
    rate, speed, deviation = 100.0, 0.3, 0.02
    time = np.arange(2800) / rate
    forward = speed * np.clip(np.minimum(time - 4.0, 24.0 - time), 0.0, 1.0)
    along = np.array([[1.0, 0.0, 0.0]])
    force = np.gradient(forward, time)[:, None] * along + [0.0, 0.0, 9.81]
    way, still = np.cumsum(forward) / rate, np.zeros((len(time), 3))
    drive = Walk(
        time, force, still, way[:, None] * along, forward[:, None] * along,
        np.tile(np.eye(3), (len(time), 1, 1)),
    )  # fmt: skip
    block = measured(drive, 0, force_noise=2e-3, rate_noise=2e-4, force_bias=0.03).block()
    pipeline = Pipeline(Configuration(VEHICLE))
    covariance, random = (deviation**2, 0, 0, 0, HUGE, 0, 0, 0, HUGE), np.random.default_rng(0)
    states = []
    for index in range(len(block)):
        outputs = pipeline.chain.push(RAW, block.sample(index))
        states += [value for name, value in outputs if name == ODOMETRY]
        if told and index > 200 and index % 10 == 0:
            seen = forward[index] + deviation * random.normal()
            sample = velocity((seen, 0.0, 0.0), '', covariance, int(block.stamp_ns[index]))
            assert not pipeline.chain.push(AIDING_ODOMETRY, sample)
    at = int(np.searchsorted(block.stamp_ns, states[-1].stamp_ns))
    error = states[-1].position[0] - way[at]
    driving = [s.stationary for s in states if 8.0 < (s.stamp_ns - START_NS) * 1e-9 < 22.0]
    assert states[-1].stationary
    if told:
        assert not any(driving)
        assert abs(error) < 3.0 * np.sqrt(states[-1].position_covariance[0]) < 1.0
    else:  # nothing can tell it then: it is the case that is meant
        assert all(driving)
        assert error < -5.0


def test_a_pose_without_a_yaw_places_but_does_not_turn():
    found, chain = begun()
    unknown = (HUGE, 0.0, 0.0, 0.0, HUGE, 0.0, 0.0, 0.0, HUGE)
    before = found._state[13:17].copy()
    assert not chain.push(AIDING_POSE, pose((100.0, 0.0, 0.0), 1.0, attitude_covariance=unknown))
    np.testing.assert_allclose(found._state[13:17], before, atol=1e-3)
    assert found._state[0] == pytest.approx(100.0, abs=1.0)


def test_a_pose_without_an_orientation_needs_none():
    found, chain = begun()
    unknown = (HUGE, 0.0, 0.0, 0.0, HUGE, 0.0, 0.0, 0.0, HUGE)
    for k in range(2):  # the one that places, and one that is measured
        sample = pose(
            (100.0, 0.0, 0.0), attitude=(0.0,) * 4, attitude_covariance=unknown,
            stamp_ns=STAMP + 5_000_000 * k,
        )  # fmt: skip
        assert not chain.push(AIDING_POSE, sample)
    assert (found.counts['placed'], found.counts['aiding_pose']) == (1, 1)


def test_a_measured_pose_is_taken_as_a_whole_or_not_at_all():
    found, chain = begun()
    assert not chain.push(AIDING_POSE, pose())
    before = found._state.copy()
    (message,) = faults(chain, AIDING_POSE, pose((1.0, 0.0, 0.0), attitude=(0.0,) * 4))
    assert 'no rotation' in message
    np.testing.assert_array_equal(found._state, before)


def test_what_a_pose_does_not_know_stays():
    """An altimeter tells but the height, and a beacon but where along x."""
    for axis in range(3):
        found, chain = begun()
        position = found._state[:3].copy()
        covariance = np.eye(3) * HUGE
        covariance[axis, axis] = 0.04
        unknown = (HUGE, 0.0, 0.0, 0.0, HUGE, 0.0, 0.0, 0.0, HUGE)
        variances = found._state[17 : 17 + 256].reshape(16, 16).diagonal()[:3].copy()
        sample = pose(
            (70.0, 80.0, 90.0), position_covariance=tuple(covariance.ravel()),
            attitude_covariance=unknown,
        )  # fmt: skip
        assert not chain.push(AIDING_POSE, sample)
        others = [i for i in range(3) if i != axis]
        np.testing.assert_allclose(found._state[others], position[others], atol=0.05)
        assert found._state[axis] == pytest.approx(70.0 + 10.0 * axis, abs=0.5)
        after = found._state[17 : 17 + 256].reshape(16, 16).diagonal()[:3]
        assert after[axis] == pytest.approx(0.04, rel=0.05)
        np.testing.assert_allclose(after[others], variances[others], rtol=0.1)


def test_a_pose_before_the_first_state_of_a_mounted_sensor_is_refused():
    """Where it is from the origin shows but then; all later ones find the body there."""
    found = navigator(look_ahead=0.3, minimum=0.2, window=0.2)
    stage = navigator_stage(found, lambda _: Mounting(translation=(0.5, 0.2, -1.0)))
    chain, refused, states = Chain([stage]), [], []
    for index in range(260):
        states += [v for n, v in chain.push(RAW, BLOCK.sample(index)) if n == ODOMETRY]
        if found.aligned and len(states) < 3:  # it stands
            sample = pose((4.0, 5.0, 6.0), stamp_ns=int(BLOCK.stamp_ns[index]))
            said = faults(chain, AIDING_POSE, sample)
            assert bool(said) is not bool(states)
            refused += said
    assert len(refused) > 50
    assert 'before the first state' in refused[0]
    placed = next(state for state in states if state.stamp_ns == sample.stamp_ns)
    assert placed.position == pytest.approx((4.0, 5.0, 6.0), abs=0.01)


def test_a_yaw_that_is_set_with_its_variance_comes_right_with_a_velocity_of_the_world():
    """The body sets out along 40° of the world, and takes that for 0."""
    found, yaw, speed = navigator(zero_velocity=False), np.radians(40.0), 0.0
    aiding = Aiding(found)
    unknown = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, HUGE)
    covariance = tuple(np.diag([1e-2] * 3).ravel())
    for k in range(2000):
        stamp_ns, push = 1_000_000_000 + k * 10_000_000, 1.0 if 500 < k < 1000 else 0.0
        speed += 0.01 * push
        with suppress(NotLevelledError):
            found.update(
                ImuSample(stamp_ns, '', (push, 0.0, 9.81), angular_velocity=(0.0, 0.0, 0.0))
            )
        if k == 300:
            of_yaw = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5)
            aiding.set_pose(
                pose(stamp_ns=0, position_covariance=unknown, attitude_covariance=of_yaw)
            )
        if k > 300 and k % 100 == 0:
            along = (speed * np.cos(yaw), speed * np.sin(yaw), 0.0)
            aiding.take_twist(velocity(along, 'odom', covariance, stamp_ns))
    assert not found.counts['aiding_twist_refused']
    sigma = np.sqrt(found._state[17 : 17 + 256].reshape(16, 16)[8, 8])
    error = Rotation.from_quat(found._state[13:17]).as_euler('zyx')[0] - yaw
    assert abs(error) < 2.0 * sigma < np.radians(10.0)


def test_a_lever_arm_of_the_sensor_is_where_the_body_is_not():
    arm = (0.5, 0.2, -1.0)
    found, chain = begun(Mounting(translation=arm))
    assert not chain.push(SET_POSE, pose((4.0, 5.0, 6.0), 1.0, stamp_ns=0))
    states = after(chain, 9)  # by which the one that is placed now is filtered
    assert states[-1].position == pytest.approx((4.0, 5.0, 6.0), abs=1e-3)
    assert found.counts['placed'] == 1


def test_a_position_where_the_body_was_set_says_nothing_about_its_yaw():
    """The sensor is a metre off, and by its yaw nobody knows where."""
    found, chain = begun(Mounting(translation=(1.0, 0.0, 0.0)))
    unknown = (HUGE, 0.0, 0.0, 0.0, HUGE, 0.0, 0.0, 0.0, HUGE)
    of_yaw = (1e-4, 0.0, 0.0, 0.0, 1e-4, 0.0, 0.0, 0.0, 0.25)
    assert not chain.push(SET_POSE, pose((4.0, 5.0, 6.0), 1.0, attitude_covariance=of_yaw))
    assert not chain.push(AIDING_POSE, pose((4.0, 5.0, 6.0), attitude_covariance=unknown))
    assert found.counts['aiding_pose'] == 1
    variance = found._state[17 : 17 + 256].reshape(16, 16)[8, 8]
    assert variance == pytest.approx(0.25, rel=0.01)


def test_a_pose_of_rviz_is_one_in_a_plane():
    found, chain = begun()
    height, tilt = found._state[2], found._state[13:17].copy()
    flat = (0.25, 0.0, 0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.0)
    sample = pose(
        (4.0, 5.0, 0.0), 1.0, position_covariance=flat,
        attitude_covariance=(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0685), stamp_ns=0,
    )  # fmt: skip
    assert not chain.push(SET_POSE, sample)
    state = after(chain, 9)[-1]
    assert state.position == pytest.approx((4.0, 5.0, height), abs=1e-3)
    old, new = (Rotation.from_quat(q).as_euler('zyx') for q in (tilt, state.attitude))
    assert new[1:] == pytest.approx(old[1:], abs=0.02)
    assert new[0] == pytest.approx(1.0, abs=0.02)


ONE = (-1.0, *[0.0] * 8)


@pytest.mark.parametrize('name', [AIDING_TWIST, AIDING_ODOMETRY])
@pytest.mark.parametrize(
    ('covariance', 'said'),
    [
        (UNKNOWN, 'each axis needs a variance above 0, 1e6 where it is not measured'),
        (ONE, 'each axis needs a variance above 0'),
        ((1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0), 'no correlation of 1'),
        ((float('nan'), *SMALL[1:]), 'nan'),
        ((1e-300, *SMALL[1:]), '1e-300'),
    ],
)
def test_a_velocity_without_a_covariance_is_refused(name, covariance, said):
    found, chain = begun()
    before = found._state.copy()
    (message,) = faults(chain, name, velocity((1.0, 0.0, 0.0), covariance=covariance))
    assert said in message
    np.testing.assert_array_equal(found._state, before)


@pytest.mark.parametrize('variance', [1e-9, 1e-12])
@pytest.mark.parametrize('unmeasured', [1e6, 1e12])
def test_an_axis_that_is_not_measured_hides_no_other_one(variance, unmeasured):
    """Turned, the small variance is less than the rounding of the large ones."""
    for seed in range(20):
        turn = Rotation.random(random_state=seed)
        mountings = {'imu_link': Mounting(), 'wheel': Mounting(tuple(turn.as_quat()))}
        found = navigator(aiding_gate=1e9)
        aiding = Aiding(found, FrameSettings(mounting='tf'), mountings.__getitem__)
        for index in range(130):
            with suppress(NotLevelledError):
                found.update(BLOCK.sample(index))
        covariance = (variance, 0.0, 0.0, 0.0, unmeasured, 0.0, 0.0, 0.0, unmeasured)
        told = velocity((0.5, 0.0, 0.0), 'wheel', covariance, int(BLOCK.stamp_ns[129]))
        aiding.take_twist(told)
        found.update(BLOCK.sample(130))
        found.flush()
        body = Rotation.from_quat(found._state[13:17])
        along = (body * turn).inv().apply(found._state[3:6])
        assert along[0] == pytest.approx(0.5, abs=0.1)
        assert np.abs(along[1:]).max() < 0.2


def test_what_is_measured_in_a_gap_is_not_taken_after_it():
    """Neither as soon as the gap ends nor late: nobody knows how the body moved in it."""
    for late in (False, True):
        found, chain = begun(max_gap=0.2, aiding_delay=2.0)
        gap_ns = 900_000_000
        told = velocity((1.0, 0.0, 0.0), covariance=(1e-2, 0, 0, 0, 1e-2, 0, 0, 0, 1e-2))
        told = replace(told, stamp_ns=int(BLOCK.stamp_ns[NOW - 1]) + 500_000_000)
        if not late:
            assert not chain.push(AIDING_TWIST, told)
        for k in range(NOW, NOW + 40):
            sample = BLOCK.sample(k)
            chain.push(RAW, replace(sample, stamp_ns=sample.stamp_ns + gap_ns))
        if late:
            assert not chain.push(AIDING_TWIST, told)
        counts = found.counts
        assert (counts['aiding_twist'], counts['aiding_twist_refused']) == (0, 1)


def test_what_is_said_twice_counts_once_where_errors_last():
    variances = []
    for times in (1, 2):
        found, chain = begun(aiding_correlation=0.5, look_ahead=0.0)
        for k in range(5):
            told = velocity(tuple(LEVEL_WALK.velocity[NOW - 50 + 10 * k]), 'odom')
            told = replace(told, stamp_ns=int(BLOCK.stamp_ns[NOW - 50 + 10 * k]))
            for _ in range(times):
                assert not chain.push(AIDING_TWIST, told)
        assert found.counts['aiding_twist'] == 5 * times
        variances.append(found._state[17 : 17 + 256].reshape(16, 16).diagonal()[3:6].copy())
    np.testing.assert_allclose(variances[1], variances[0], rtol=1e-3)


@pytest.mark.parametrize(
    ('name', 'sample', 'said'),
    [
        (AIDING_TWIST, velocity((1.0, 0.0, 0.0), 'gps'), "'gps', which is neither the body"),
        (AIDING_TWIST, velocity((float('nan'), 0.0, 0.0)), 'velocity is'),
        (AIDING_POSE, pose(frame_id='map'), "'map', and the world of this filter is 'odom'"),
        (AIDING_POSE, pose(position_covariance=UNKNOWN), 'covariance of the position'),
        (AIDING_POSE, pose(attitude_covariance=ONE), 'covariance of the orientation'),
        (AIDING_POSE, pose(attitude=(0.0, 0.0, 0.0, 0.0)), 'no rotation'),
        (SET_POSE, pose(position_covariance=UNKNOWN), 'give each one above 0'),
        (SET_POSE, pose(attitude_covariance=UNKNOWN), 'give each one above 0'),
        (SET_POSE, pose(frame_id='map'), "'map'"),
        (SET_POSE, pose(stamp_ns=STAMP - 3_000_000_000), 'behind the Imu'),
        (AIDING_TWIST, velocity((1.0, 0.0, 0.0), stamp_ns=0), 'behind the Imu'),
    ],
)
def test_what_can_not_be_used_is_refused_and_changes_nothing(name, sample, said):
    found, chain = begun()
    before, placed = found._state.copy(), found.counts['placed']
    (message,) = faults(chain, name, sample)
    assert said in message
    assert message.startswith(f'{name}: ')
    assert found.dropped == {name: 1}
    np.testing.assert_array_equal(found._state, before)
    assert found.counts['placed'] == placed
    assert not faults(chain, AIDING_POSE, pose(stamp_ns=STAMP))  # the first one still places
    assert found.counts['placed'] == 1


def test_before_the_alignment_nothing_is_taken():
    found, chain = begun(until=20)
    (message,) = faults(chain, AIDING_TWIST, velocity((1.0, 0.0, 0.0)))
    assert 'before the alignment' in message
    assert not found.aligned


numbers = st.floats(width=64)
matrices = st.tuples(*[numbers] * 9)


@given(
    st.integers(-(2**31) * 10**9, 2**31 * 10**9),
    st.sampled_from(['', 'odom', 'base_link', 'x']),
    st.tuples(*[numbers] * 3),
    matrices | st.just(SMALL),
    st.tuples(*[numbers] * 4),
    matrices | st.just(SMALL),
)
def test_whatever_comes_the_state_stays_finite(stamp_ns, frame_id, value, first, q, second):
    found = navigator()
    aiding = Aiding(found)
    for index in range(130):
        with suppress(NotLevelledError):
            found.update(BLOCK.sample(index))
    for at in (stamp_ns, int(BLOCK.stamp_ns[128])):
        for take, sample in (
            (aiding.take_twist, VelocitySample(at, frame_id, value, first)),
            (aiding.take_odometry, VelocitySample(at, frame_id, value, first)),
            (aiding.take_pose, PoseSample(at, frame_id, value, first, q, second)),
            (aiding.set_pose, PoseSample(at, frame_id, value, first, q, second)),
        ):
            with suppress(SampleError):
                take(sample)
    for index in range(130, 150):
        found.update(BLOCK.sample(index))
    assert np.isfinite(found._state[: 17 + 256]).all()


def test_errors_are_of_one_kind():
    assert issubclass(AidingError, SampleError)
    assert not issubclass(NotFiniteError, AidingError)
