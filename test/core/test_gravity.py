"""Gravity is taken off, and the covariance says how well."""

import math
from contextlib import suppress
from dataclasses import replace
from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import (
    GravityError,
    LateSampleError,
    MissingAccelerationError,
    MissingAttitudeError,
    MountingError,
    NotAtRestError,
    NotFiniteError,
    NotLevelledError,
    RepeatedStampError,
    SampleError,
    SupersededError,
    ZeroStampError,
)
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import (
    isotropic,
    matrix_from_quaternion,
    quaternion_from_euler,
    rotate,
    rotate_back,
)
from dead_reckoning.core.samples import UNKNOWN, ImuSample

STEP_NS = 10_000_000
START_NS = 1_700_000_000_000_000_000
LEVEL = (0.0, 0.0, GRAVITY)
NAN, INF = math.nan, math.inf
NOT_MEASURED = (-1.0, *UNKNOWN[1:])

angles = st.floats(-math.pi, math.pi)
quaternions = st.builds(quaternion_from_euler, angles, angles, angles)
vectors = st.tuples(*[st.floats(-50.0, 50.0)] * 3)


def gravity_removal(common=None, **settings):
    return GravityRemoval(
        GravitySettings(**settings), CommonSettings(**(common or {})), FrameSettings()
    )


def from_message(**settings):
    return gravity_removal(attitude='message', **({'measure': False} | settings))


def imu(step, force, orientation=None, covariance=UNKNOWN, orientation_covariance=UNKNOWN):
    return ImuSample(
        START_NS + step * STEP_NS,
        'imu_link',
        force,
        covariance,
        orientation=orientation,
        orientation_covariance=orientation_covariance,
    )


def turning(step, rate, covariance=UNKNOWN):
    return ImuSample(
        START_NS + step * STEP_NS,
        'imu_link',
        LEVEL,
        angular_velocity=rate,
        angular_velocity_covariance=covariance,
        orientation=(0.0, 0.0, 0.0, 1.0),
    )


def force_at(euler, acceleration_w=(0.0, 0.0, 0.0), gravity=GRAVITY):
    """Return what an accelerometer in an attitude measures under an acceleration."""
    x, y, z = acceleration_w
    return rotate_back(matrix_from_quaternion(quaternion_from_euler(*euler)), (x, y, z + gravity))


def levelled(removal, force=LEVEL, first=0):
    """Feed rest until the attitude is known; return the number of the next sample."""
    for step in range(first, first + 51):
        try:
            removal.update(imu(step, force))
        except NotLevelledError:
            assert step - first < 50
    return first + 51


def array(matrix):
    return np.reshape(matrix, (3, 3))


def cross(vector):
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def full_covariance(random, scale):
    root = random.normal(0.0, scale, (3, 3))
    return tuple((root @ root.T).ravel().tolist())


# At rest --------------------------------------------------------------------------------------


def test_no_sample_passes_before_the_attitude_is_known():
    removal = gravity_removal()
    for step in range(50):
        with pytest.raises(NotLevelledError, match=r'keep the device still for 0\.5 s'):
            removal.update(imu(step, LEVEL))
    assert removal.update(imu(50, LEVEL)).acceleration.acceleration == (0.0, 0.0, 0.0)


@pytest.mark.parametrize('roll', [0.0, 10.0, -40.0])
@pytest.mark.parametrize('pitch', [0.0, 25.0, -45.0])
@pytest.mark.parametrize('gravity', [GRAVITY, 9.78, 1.008 * GRAVITY])
def test_attitude_and_gravity_from_rest(roll, pitch, gravity):
    euler = (radians(roll), radians(pitch), 0.0)
    removal = gravity_removal()
    step = levelled(removal, force_at(euler, gravity=gravity))
    accelerated = (1.0, -2.0, 0.5)
    given_back = removal.update(imu(step, force_at(euler, accelerated, gravity)))
    assert given_back.acceleration.acceleration == pytest.approx(accelerated, abs=1e-12)
    assert given_back.acceleration.frame_id == 'odom'
    assert given_back.acceleration.stamp_ns == START_NS + step * STEP_NS
    assert given_back.imu.orientation == pytest.approx(quaternion_from_euler(*euler))
    assert removal.gravity == pytest.approx(gravity)
    assert removal.findings == []


def test_attitude_of_rest_is_held_while_it_moves():
    removal = gravity_removal()
    step = levelled(removal)
    for k in range(200):
        moved = removal.update(imu(step + k, (3.0 * math.sin(k), 0.0, GRAVITY)))
        assert moved.imu.orientation == (0.0, 0.0, 0.0, 1.0)
        assert moved.acceleration.acceleration[0] == pytest.approx(3.0 * math.sin(k))


def test_sample_that_passes_keeps_what_it_carried():
    removal = gravity_removal(common={'attitude_deviation': 0.1, 'noise_deviation': 0.2})
    step = levelled(removal)
    sample = ImuSample(
        START_NS + step * STEP_NS, 'my_imu', LEVEL, UNKNOWN, (0.1, 0.2, 0.3), (2.0,) * 9
    )
    passed = removal.update(sample).imu
    assert (passed.stamp_ns, passed.frame_id) == (sample.stamp_ns, 'my_imu')
    assert passed.specific_force == sample.specific_force
    assert passed.angular_velocity == (0.1, 0.2, 0.3)
    assert passed.angular_velocity_covariance == (2.0,) * 9
    assert passed.orientation_covariance[::4] == pytest.approx((0.01,) * 3)
    assert passed.specific_force_covariance[::4] == pytest.approx((0.04,) * 3)


def test_motion_at_the_start_delays_the_attitude():
    """Still from sample 120 on, while the third window of 51 samples is running."""
    removal = gravity_removal()
    for step in range(153):
        with pytest.raises(NotLevelledError):
            removal.update(imu(step, (2.0 * (step % 2) * (step < 120), 0.0, GRAVITY)))
    levelled(removal, first=153)
    assert removal.gravity == pytest.approx(GRAVITY)
    assert removal.findings == [], 'motion is no fault of the input'


# From messages --------------------------------------------------------------------------------


@given(quaternions, vectors)
def test_attitude_of_the_message_is_used(quaternion, accelerated):
    x, y, z = accelerated
    rot_ws = matrix_from_quaternion(quaternion)
    sample = imu(1, rotate_back(rot_ws, (x, y, z + GRAVITY)), quaternion)
    given_back = from_message().update(sample)
    assert given_back.acceleration.acceleration == pytest.approx(accelerated, abs=1e-9)
    assert given_back.imu is sample


def test_quaternion_of_another_length_is_brought_to_one():
    euler = (0.3, -0.2, 1.0)
    longer = tuple(1.5 * part for part in quaternion_from_euler(*euler))
    given_back = from_message().update(imu(1, force_at(euler), longer))
    assert given_back.acceleration.acceleration == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_magnitude_is_what_was_set_until_it_is_measured():
    euler = (0.3, -0.2, 1.0)
    quaternion = quaternion_from_euler(*euler)
    force = force_at(euler, gravity=9.85)
    removal = from_message(measure=True, magnitude=9.8)
    heights = [
        removal.update(imu(step, force, quaternion)).acceleration.acceleration[2]
        for step in range(60)
    ]
    assert heights[:50] == pytest.approx([0.05] * 50)
    assert heights[50:] == pytest.approx([0.0] * 10, abs=1e-12)


def test_magnitude_stays_as_set_where_it_is_not_to_be_measured():
    removal = from_message(measure=False, magnitude=9.8)
    for step in range(200):
        removal.update(imu(step, (0.0, 0.0, 9.85), (0.0, 0.0, 0.0, 1.0)))
    assert removal.gravity == 9.8


# Covariance -----------------------------------------------------------------------------------


@pytest.mark.parametrize('seed', range(10))
def test_covariance_agrees_with_numpy(seed):
    random = np.random.default_rng(seed)
    quaternion = quaternion_from_euler(*random.uniform(-3.0, 3.0, 3))
    force = tuple(random.normal(0.0, 10.0, 3).tolist())
    noise, tilt = full_covariance(random, 0.1), full_covariance(random, 0.02)
    given_back = from_message().update(imu(1, force, quaternion, noise, tilt))
    rot_ws = array(matrix_from_quaternion(quaternion))
    spread = cross(rot_ws @ force)
    expected = rot_ws @ array(noise) @ rot_ws.T + spread @ array(tilt) @ spread.T
    np.testing.assert_allclose(array(given_back.acceleration.covariance), expected, rtol=1e-9)


@pytest.mark.parametrize('attitude', ['rest', 'estimate', 'message'])
def test_rest_that_trembles_is_known_less_well(attitude):
    """What the levelling leaves of tremor lasts, and is as large as is published."""
    random = np.random.default_rng(3)
    exact = {'attitude_deviation': 0.0, 'noise_deviation': 0.0}
    euler = (0.1, -0.2, 0.0)
    heights, tilts, vertical, level = [], [], [], []
    for _ in range(200):
        removal = gravity_removal(exact, attitude=attitude, rest_deviation=1.0)
        for step, shake in enumerate(random.normal(0.0, 0.2, (51, 3))):
            sample = turning(step, (0.0, 0.0, 0.0), isotropic(1e-9))
            force = tuple(shake + force_at(euler))
            orientation = quaternion_from_euler(*euler) if attitude == 'message' else None
            with suppress(NotLevelledError):
                made = removal.update(
                    replace(sample, specific_force=force, orientation=orientation)
                )
        off = matrix_from_quaternion(made.imu.orientation)
        heights.append(removal.gravity - GRAVITY)
        tilts.append(rotate(off, force_at(euler))[0] / GRAVITY)
        spread = cross(rotate(off, force)) @ array(made.imu.orientation_covariance)
        tilted = (spread @ cross(rotate(off, force)).T)[2, 2]
        vertical.append(made.acceleration.covariance[8] - tilted)
        level.append(made.imu.orientation_covariance[4])
    assert np.sqrt(np.mean(np.square(heights)) / np.mean(vertical)) == pytest.approx(1.0, abs=0.15)
    if attitude != 'message':
        ratio = np.sqrt(np.mean(np.square(tilts)) / np.mean(level))
        assert ratio == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize('seed', range(3))
def test_covariance_is_that_of_the_errors(seed):
    """Monte Carlo: attitude turned about the axes of the world, force with noise."""
    random = np.random.default_rng(seed)
    quaternion = quaternion_from_euler(*random.uniform(-3.0, 3.0, 3))
    accelerated = random.normal(0.0, 3.0, 3)
    rot_ws = matrix_from_quaternion(quaternion)
    force = rotate_back(rot_ws, tuple(accelerated + LEVEL))
    noise, tilt = full_covariance(random, 0.1), full_covariance(random, 0.005)
    removal = from_message()
    errors = []
    trials = 4000
    turns = random.multivariate_normal(np.zeros(3), array(tilt), trials)
    shakes = random.multivariate_normal(np.zeros(3), array(noise), trials)
    for step, (turn, shake) in enumerate(zip(turns, shakes, strict=True), 1):
        x, y, z = turn / 2.0
        qx, qy, qz, qw = quaternion
        turned = (
            x * qw + y * qz - z * qy + qx,
            y * qw + z * qx - x * qz + qy,
            z * qw + x * qy - y * qx + qz,
            qw - x * qx - y * qy - z * qz,
        )
        given_back = removal.update(
            imu(step, tuple((shake + force).tolist()), turned, noise, tilt)
        )
        errors.append(given_back.acceleration.acceleration - accelerated)
    published = from_message().update(imu(1, force, quaternion, noise, tilt))
    root = np.linalg.cholesky(array(published.acceleration.covariance))
    whitened = np.linalg.solve(root, np.transpose(errors))
    np.testing.assert_allclose(np.cov(whitened), np.eye(3), atol=0.1)
    np.testing.assert_allclose(whitened.mean(axis=1), 0.0, atol=0.1)


def test_unknown_covariances_are_replaced_by_what_is_set():
    """At rest one degree of tilt is 0.171 m/s² on the horizontal axes."""
    common = {'attitude_deviation': radians(1.0), 'noise_deviation': 0.05}
    removal = gravity_removal(common)
    variances = removal.update(imu(levelled(removal), LEVEL)).acceleration.covariance[::4]
    assert np.sqrt(variances) == pytest.approx(
        [math.hypot(0.1712, 0.05), math.hypot(0.1712, 0.05), 0.05], rel=1e-3
    )
    messages = gravity_removal(common, attitude='message', measure=False)
    sample = imu(1, LEVEL, (0.0, 0.0, 0.0, 1.0))
    assert messages.update(sample).acceleration.covariance[::4] == pytest.approx(variances)


# Laws -----------------------------------------------------------------------------------------


@given(quaternions, vectors, angles)
def test_turning_the_world_turns_what_comes_out(quaternion, force, yaw):
    about_z = matrix_from_quaternion(quaternion_from_euler(0.0, 0.0, yaw))
    x, y, z, w = quaternion
    s, c = math.sin(yaw / 2.0), math.cos(yaw / 2.0)
    turned = (c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z)
    before = from_message().update(imu(1, force, quaternion)).acceleration
    after = from_message().update(imu(1, force, turned)).acceleration
    assert after.acceleration == pytest.approx(rotate(about_z, before.acceleration), abs=1e-9)


@given(quaternions, vectors, quaternions)
def test_turning_the_sensor_in_its_mounting_changes_nothing(quaternion, force, mounting):
    """The same body, the sensor screwed on another way: force and attitude turn together."""
    rot_mount = matrix_from_quaternion(mounting)
    (x, y, z, w), (a, b, c, d) = quaternion, mounting
    combined = (
        w * a + x * d + y * c - z * b,
        w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d,
        w * d - x * a - y * b - z * c,
    )
    before = from_message().update(imu(1, force, quaternion)).acceleration
    remounted = imu(1, rotate_back(rot_mount, force), combined)
    after = from_message().update(remounted).acceleration
    assert after.acceleration == pytest.approx(before.acceleration, abs=1e-9)
    assert after.covariance == pytest.approx(before.covariance, abs=1e-9)


# Errors ---------------------------------------------------------------------------------------

QUATERNION = (0.0, 0.0, 0.0, 1.0)
BAD_ANYWHERE = [
    (lambda step: imu(step, (NAN, 0.0, GRAVITY)), NotFiniteError),
    (lambda step: imu(step, (0.0, INF, GRAVITY)), NotFiniteError),
    (lambda step: imu(step, (0.0, INF, -INF)), NotFiniteError),
    (lambda step: imu(step, LEVEL, QUATERNION, (NAN,) * 9), NotFiniteError),
    (lambda step: imu(step, LEVEL, QUATERNION, (*UNKNOWN[:8], INF)), NotFiniteError),
    (lambda step: imu(step, LEVEL, QUATERNION, UNKNOWN, (NAN,) * 9), NotFiniteError),
    (lambda step: turning(step, (0.0, NAN, 0.0)), NotFiniteError),
    (lambda step: turning(step, (0.0, 0.0, 0.0), (*UNKNOWN[:8], NAN)), NotFiniteError),
    (lambda step: imu(step, LEVEL, QUATERNION, NOT_MEASURED), MissingAccelerationError),
    (lambda step: ImuSample(0, 'imu_link', LEVEL, orientation=QUATERNION), ZeroStampError),
    (lambda step: imu(step - 1, LEVEL, QUATERNION), RepeatedStampError),
    (lambda step: imu(step - 2, LEVEL, QUATERNION), LateSampleError),
    (lambda step: imu(step - 99, LEVEL, QUATERNION), LateSampleError),
]
BAD_IN_MESSAGES = [
    (lambda step: imu(step, LEVEL), MissingAttitudeError),
    (lambda step: imu(step, LEVEL, (0.0, 0.0, 0.0, 0.0)), NotFiniteError),
    (lambda step: imu(step, LEVEL, (NAN, 0.0, 0.0, 1.0)), NotFiniteError),
    (lambda step: imu(step, LEVEL, (0.0, 0.0, INF, 1.0)), NotFiniteError),
]


def outputs_of(removal, samples):
    """Feed samples; return what comes out and, of each that raises, the kind of error."""
    outputs = []
    for sample in samples:
        try:
            out = removal.update(sample)
        except SampleError as error:
            outputs.append(type(error))
        else:
            acceleration = out.acceleration
            outputs.append((acceleration.acceleration, acceleration.covariance))
    return outputs


@pytest.mark.parametrize(
    ('attitude', 'bad', 'error'),
    [('rest', *case) for case in BAD_ANYWHERE]
    + [('message', *case) for case in BAD_ANYWHERE + BAD_IN_MESSAGES],
)
@pytest.mark.parametrize('at', [25, 80])
def test_bad_sample_is_refused_and_leaves_no_trace(attitude, bad, error, at):
    """At 25 the search for rest is on, at 80 it is over."""
    random = np.random.default_rng(4)
    forces = random.normal(LEVEL, 0.05, (150, 3)).tolist()
    good = [imu(step, tuple(force), QUATERNION) for step, force in enumerate(forces, 100)]
    undisturbed = outputs_of(gravity_removal(attitude=attitude), good)
    disturbed = outputs_of(
        gravity_removal(attitude=attitude), [*good[:at], bad(100 + at), *good[at:]]
    )
    assert disturbed.pop(at) is error
    assert disturbed == undisturbed


def test_missing_attitude_names_the_remedy():
    with pytest.raises(MissingAttitudeError, match=r'set gravity\.attitude to rest'):
        from_message().update(imu(1, LEVEL))


def test_missing_acceleration_names_the_remedy():
    with pytest.raises(MissingAccelerationError, match='topic of an accelerometer'):
        gravity_removal().update(imu(1, LEVEL, covariance=NOT_MEASURED))


# Start, restart, gaps --------------------------------------------------------------------------


def test_stamps_that_go_back_far_start_all_over():
    removal = gravity_removal()
    levelled(removal, force_at((0.2, 0.0, 0.0), gravity=9.7), first=1000)
    assert removal.gravity == pytest.approx(9.7)
    with pytest.raises(NotLevelledError):
        removal.update(imu(0, LEVEL))
    assert removal.restarts == 1
    assert removal.gravity == GRAVITY
    step = levelled(removal, first=1)
    assert removal.update(imu(step, LEVEL)).imu.orientation == QUATERNION


def test_reset_is_a_new_start():
    removal = gravity_removal()
    levelled(removal, force_at((0.2, 0.0, 0.0)), first=1000)
    removal.reset()
    step = levelled(removal, first=0)
    assert removal.update(imu(step, LEVEL)).imu.orientation == QUATERNION
    assert removal.restarts == 0


def test_gap_changes_nothing():
    removal = gravity_removal()
    step = levelled(removal)
    before = removal.update(imu(step, (1.0, 0.0, GRAVITY))).acceleration
    after = removal.update(imu(step + 100_000, (1.0, 0.0, GRAVITY))).acceleration
    assert (after.acceleration, after.covariance) == (before.acceleration, before.covariance)


# Levelling on demand ---------------------------------------------------------------------------


def test_level_takes_the_attitude_anew_once_it_is_known():
    removal = gravity_removal()
    step = levelled(removal)
    tilted = (radians(10.0), radians(-5.0), 0.0)
    future = removal.level()
    for k in range(50):
        held = removal.update(imu(step + k, force_at(tilted)))
        assert held.imu.orientation == QUATERNION
        assert not future.done()
    after = removal.update(imu(step + 50, force_at(tilted)))
    assert after.imu.orientation == pytest.approx(quaternion_from_euler(*tilted))
    assert after.acceleration.acceleration == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    said = future.result(timeout=0)
    assert said == 'gravity is 9.8066 m/s², roll 10.000°, pitch -5.000°'


def test_level_measures_gravity_under_attitudes_of_messages():
    removal = from_message()
    future = removal.level()
    for step in range(51):
        removal.update(imu(step, (0.0, 0.0, 9.7), QUATERNION))
    assert future.result(timeout=0) == 'gravity is 9.7000 m/s²'
    assert removal.gravity == pytest.approx(9.7)


@pytest.mark.parametrize(
    ('forces', 'error'),
    [
        ([(2.0, 0.0, GRAVITY), (-2.0, 0.0, GRAVITY)], NotAtRestError),
        ([(0.0, 0.0, 1.0)], GravityError),
    ],
)
@pytest.mark.parametrize('attitude', ['rest', 'message'])
def test_level_that_fails_says_why_and_changes_nothing(attitude, forces, error):
    removal = gravity_removal(attitude=attitude)
    for step in range(60):
        if attitude == 'rest' and step < 50:
            with pytest.raises(NotLevelledError):
                removal.update(imu(step, LEVEL, QUATERNION))
        else:
            removal.update(imu(step, LEVEL, QUATERNION))
    future = removal.level()
    for step in range(60, 160):
        last = removal.update(imu(step, forces[step % len(forces)], QUATERNION))
    assert isinstance(future.exception(timeout=0), error)
    assert last.imu.orientation == QUATERNION
    assert removal.gravity == pytest.approx(GRAVITY)
    assert removal.findings == [], 'who asked was told'


def test_level_before_the_first_rest_waits_for_it():
    removal = gravity_removal()
    with pytest.raises(NotLevelledError):
        removal.update(imu(0, LEVEL))
    future = removal.level()
    levelled(removal, first=1)
    assert future.result(timeout=0).startswith('gravity is 9.8066')


def test_search_goes_on_after_a_level_that_failed_before_the_first_rest():
    removal = gravity_removal()
    future = removal.level()
    for step in range(51):
        with pytest.raises(NotLevelledError):
            removal.update(imu(step, (2.0 * (step % 2), 0.0, GRAVITY)))
    assert isinstance(future.exception(timeout=0), NotAtRestError)
    levelled(removal, first=51)


@pytest.mark.parametrize('measure', [True, False])
def test_level_that_failed_leaves_the_search_as_it_was(measure):
    """With attitudes from messages: whether gravity is measured is up to `measure` alone."""
    removal = gravity_removal(attitude='message', measure=measure)
    future = removal.level()
    outputs_of(removal, [imu(k, (2.0 * (k % 2), 0.0, GRAVITY), QUATERNION) for k in range(51)])
    assert isinstance(future.exception(timeout=0), NotAtRestError)
    outputs_of(removal, [imu(k, (0.0, 0.0, 9.7), QUATERNION) for k in range(51, 151)])
    assert removal.gravity == pytest.approx(9.7 if measure else GRAVITY)


def test_asking_again_supersedes_the_first():
    removal = gravity_removal()
    first, second = removal.level(), removal.level()
    assert isinstance(first.exception(timeout=0), SupersededError)
    levelled(removal)
    assert second.done()


@pytest.mark.parametrize('attitude', ['rest', 'message'])
def test_stamps_that_go_back_end_a_level(attitude):
    removal = gravity_removal(attitude=attitude, measure=False)
    outputs_of(removal, [imu(1000 + step, LEVEL, QUATERNION) for step in range(60)])
    future = removal.level()
    outputs_of(removal, [imu(0, LEVEL, QUATERNION)])
    assert isinstance(future.exception(timeout=0), NotAtRestError)


@pytest.mark.parametrize('attitude', ['rest', 'message'])
def test_reset_ends_a_level(attitude):
    removal = gravity_removal(attitude=attitude, measure=False)
    future = removal.level()
    removal.reset()
    assert isinstance(future.exception(timeout=0), SupersededError)


# Findings -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('force', 'cause'),
    [
        ((0.0, 0.0, 1.0), 'the unit is g'),
        ((0.0, 0.0, 0.0), 'gravity is removed already'),
        ((0.0, 0.0, 1000.0), 'the unit is mg'),
        ((0.0, 0.0, 7.3), "the sensor's range"),
    ],
)
@pytest.mark.parametrize('attitude', ['rest', 'message'])
def test_wrong_input_is_found_at_rest(attitude, force, cause):
    removal = gravity_removal(attitude=attitude)
    outputs = outputs_of(removal, [imu(step, force, QUATERNION) for step in range(60)])
    (finding,) = removal.findings
    assert isinstance(finding, GravityError)
    assert f'most likely {cause}' in str(finding)
    if attitude == 'rest':
        assert set(outputs) == {NotLevelledError}


def test_sensor_on_its_side_is_worth_a_warning_and_levels_all_the_same():
    removal = gravity_removal()
    step = levelled(removal, force_at((radians(90.0), 0.0, 0.0)))
    (finding,) = removal.findings
    assert isinstance(finding, MountingError)
    given_back = removal.update(imu(step, force_at((radians(90.0), 0.0, 0.0))))
    assert given_back.acceleration.acceleration == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_attitude_in_ned_is_worth_a_warning():
    """The same rest with an attitude that is upside down: gravity shows on the wrong side."""
    removal = gravity_removal(attitude='message')
    ned = quaternion_from_euler(math.pi, 0.0, 0.0)
    outputs_of(removal, [imu(step, LEVEL, ned) for step in range(60)])
    (finding,) = removal.findings
    assert 'NED where ENU is meant' in str(finding)


def test_tilted_mounting_with_its_attitude_is_none():
    removal = gravity_removal(attitude='message')
    euler = (radians(90.0), 0.0, 0.0)
    samples = [imu(step, force_at(euler), quaternion_from_euler(*euler)) for step in range(60)]
    outputs_of(removal, samples)
    assert removal.findings == []
