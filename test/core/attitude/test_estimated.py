"""Attitude from gyro and gravity: closed forms, laws, simulated motions, error / σ."""

import math
from contextlib import suppress

import numpy as np
import pytest

from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import (
    CalibrationError,
    MissingRateError,
    NotFiniteError,
    NotLevelledError,
)
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import (
    composed,
    matrix_from_quaternion,
    quaternion_from_euler,
    yaw_from_quaternion,
)
from dead_reckoning.core.samples import UNKNOWN, ZERO, ImuSample
from dead_reckoning.sources import motions

START_NS = 1_700_000_000_000_000_000
LEVEL = (0.0, 0.0, GRAVITY)
DEGREE = math.radians(1.0)


def estimate(attitude_deviation=DEGREE, common=None, **settings):
    """Return a gravity removal that estimates the attitude."""
    return GravityRemoval(
        GravitySettings(attitude='estimate', **settings),
        CommonSettings(attitude_deviation=attitude_deviation, **(common or {})),
        FrameSettings(),
    )


def imu(stamp_ns, force, rate, noise=UNKNOWN):
    return ImuSample(
        stamp_ns,
        'imu_link',
        tuple(np.asarray(force, dtype=float).tolist()),
        angular_velocity=tuple(np.asarray(rate, dtype=float).tolist()),
        angular_velocity_covariance=noise,
    )


def heading(stamp_ns, yaw, deviation=0.02):
    covariance = (1e6, 0.0, 0.0, 0.0, 1e6, 0.0, 0.0, 0.0, deviation**2)
    return ImuSample(
        stamp_ns,
        'compass_link',
        ZERO,
        orientation=quaternion_from_euler(0.0, 0.0, float(yaw)),
        orientation_covariance=covariance,
    )


def stamps(count, dt, start_ns=START_NS):
    return (start_ns + np.round(np.arange(count) * dt * 1e9).astype(np.int64)).tolist()


def run(
    removal, forces, rates, dt=0.01, start_ns=START_NS, headings=None, every=5, deviation=0.02
):
    """Feed signals, shape (n, 3); return orientations, shape (n, 4), and variances, (n, 3).

    Rows from before the levelling are NaN.  ``headings``, shape (n,), come as a compass says them.
    """
    orientations = np.full((len(forces), 4), np.nan)
    variances = np.full((len(forces), 3), np.nan)
    for k, stamp_ns in enumerate(stamps(len(forces), dt, start_ns)):
        if headings is not None and k % every == 0:
            removal.follow_compass(heading(stamp_ns, headings[k], deviation))
        with suppress(NotLevelledError):
            given_back = removal.update(imu(stamp_ns, forces[k], rates[k])).imu
            orientations[k] = given_back.orientation
            variances[k] = given_back.orientation_covariance[::4]
    return orientations, variances


def array(quaternion):
    return np.reshape(matrix_from_quaternion(tuple(quaternion)), (3, 3))


def rotations(quaternions):
    return np.array([array(quaternion) for quaternion in quaternions])


def errors(orientations, truth):
    """Return the error about the axes of the world, shape (n, 3) [rad]; truth as rotations."""
    off = rotations(orientations) @ truth.transpose(0, 2, 1)
    skew = [off[:, 2, 1] - off[:, 1, 2], off[:, 0, 2] - off[:, 2, 0], off[:, 1, 0] - off[:, 0, 1]]
    return 0.5 * np.transpose(skew)


def at_rest(seconds, dt=0.01, force=LEVEL, rate=ZERO):
    count = round(seconds / dt)
    return np.tile(force, (count, 1)), np.tile(rate, (count, 1))


def then(*parts):
    """Put signals, pairs of force and rate, one after the other."""
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


def yaws(orientations):
    return np.array([yaw_from_quaternion(tuple(q)) for q in orientations])


# Closed forms ---------------------------------------------------------------------------------


@pytest.mark.parametrize('roll', [0.0, 0.5, -1.2])
@pytest.mark.parametrize('pitch', [0.0, 0.7, -1.0])
def test_it_starts_from_rest_like_the_held_attitude(roll, pitch):
    attitude = quaternion_from_euler(roll, pitch, 0.0)
    removal = estimate()
    force = array(attitude).T @ LEVEL
    orientations, _ = run(removal, *at_rest(0.6, force=force, rate=(0.01, -0.02, 0.03)))
    assert np.isnan(orientations[:50]).all()
    assert orientations[50:] == pytest.approx(np.tile(attitude, (10, 1)))
    assert removal.levelled.endswith('gyro bias 0.573, -1.146, 1.719 °/s')


@pytest.mark.parametrize('axis', [0, 1, 2])
def test_constant_turn_about_an_axis(axis):
    """90°/s for 2 s, gravity turning with it, the bias of the gyro taken off."""
    bias = np.array([0.02, -0.01, 0.03])
    rate = np.zeros(3)
    rate[axis] = math.radians(90.0)
    time = 0.01 * np.arange(1, 201)
    angles = math.radians(90.0) * (time - 0.005)  # the first step is half from rest
    turn = np.zeros((200, 4))
    turn[:, axis], turn[:, 3] = np.sin(angles / 2.0), np.cos(angles / 2.0)
    forces = np.array([array(q).T @ LEVEL for q in turn])
    signals = then(at_rest(0.51, rate=bias), (forces, np.tile(bias + rate, (200, 1))))
    orientations, _ = run(estimate(), *signals)
    assert np.abs((orientations[51:] * turn).sum(axis=1)) == pytest.approx(np.ones(200), abs=1e-9)


def coning(time, swing=0.3, turn=8.0):
    """Return the attitude of a body whose axis goes round a cone."""
    x, y = swing * math.cos(turn * time), swing * math.sin(turn * time)
    s = math.sin(swing / 2.0) / swing
    return (s * x, s * y, 0.0, math.cos(swing / 2.0))


def coning_rate(time, h=1e-5):
    """Return its rate of turn, shape (3,), frame of the body."""
    x, y, z, w = coning(time - h)
    dx, dy, dz, _ = composed((-x, -y, -z, w), coning(time + h))
    return (dx / h, dy / h, dz / h)


def test_turning_is_integrated_to_second_order():
    """A cone at 8 rad/s for 4 s: halving the step quarters the error."""
    off = []
    for dt in (0.04, 0.02, 0.01):
        count = round(4.0 / dt)
        start = array(coning(0.0)).T @ LEVEL
        still = at_rest(0.48, dt, force=start)
        forces = [array(coning(k * dt)).T @ LEVEL for k in range(count + 1)]
        rates = [coning_rate(k * dt) for k in range(count + 1)]
        # The rate jumps at the start of the cone, which no integration of samples sees.
        rates[0] = np.zeros(3)
        signals = then(still, (np.array(forces), np.array(rates)))
        orientations, _ = run(estimate(tilt_time=1000.0, rest_duration=0.3), *signals, dt)
        # From the second sample of the cone on: what turned since then, against the truth.
        first, last = (array(orientations[k]) for k in (-count, -1))
        turned = first.T @ last
        truth = array(coning(dt)).T @ array(coning(count * dt))
        off.append(np.linalg.norm(turned @ truth.T - np.eye(3)))
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.1)
    assert off[1] / off[2] == pytest.approx(4.0, rel=0.1)
    assert off[2] < 0.0025


def test_wrong_tilt_comes_back_as_two_low_passes_do():
    """A tilt that the gyro did not see: the share (1 + t/τ) exp(−t/τ) of it is left."""
    tilt, time_constant = 0.02, 2.0
    force = (0.0, GRAVITY * math.sin(tilt), GRAVITY * math.cos(tilt))
    orientations, _ = run(
        estimate(tilt_time=time_constant), *then(at_rest(0.51), at_rest(8.0, force=force))
    )
    roll = 2.0 * orientations[51:, 0]
    time = 0.01 * np.arange(1, 801)
    left = (1.0 + time / time_constant) * np.exp(-time / time_constant)
    assert roll == pytest.approx(tilt * (1.0 - left), abs=2e-4)


def test_bias_tilts_by_twice_the_time_constant():
    """A drift of the gyro while it moves: it lags by 2 τ b, no more."""
    bias, time_constant = 0.005, 2.0
    shaking = at_rest(30.0, rate=(bias, 0.0, 0.0))
    shaking[0][::2, 1], shaking[0][1::2, 1] = 1.0, -1.0  # no rest
    orientations, _ = run(estimate(tilt_time=time_constant), *then(at_rest(0.51), shaking))
    assert 2.0 * orientations[-1, 0] == pytest.approx(2.0 * time_constant * bias, rel=0.02)


def test_slide_leaves_hardly_a_tilt():
    """Pushed and stopped: at most distance/τ² is taken for gravity."""
    distance, time_constant = 0.5, 4.0
    motion = motions.motion_class('slide')
    motion = motion(motion.Settings(distance=distance))
    truth = motion.at(np.arange(0.0, 12.0, 0.01))
    forces = truth.acceleration + LEVEL
    orientations, _ = run(estimate(tilt_time=time_constant), forces, np.zeros((1200, 3)))
    tilt = np.abs(errors(orientations[51:], truth.rotation[51:]))
    limit = distance / time_constant**2 / GRAVITY
    assert 0.3 * limit < tilt.max() < limit


# Yaw ------------------------------------------------------------------------------------------


def test_yaw_is_free_without_a_compass():
    orientations, variances = run(estimate(), *at_rest(20.0))
    assert yaws(orientations[51:]) == pytest.approx(np.zeros(1949))
    assert (np.diff(variances[51:, 2]) > 0.0).all()


def test_first_yaw_of_the_compass_is_taken_whole_later_ones_by_the_time_constant():
    removal = estimate(compass_time=5.0)
    headings = np.where(np.arange(1051) <= 50, 1.0, 1.2)
    orientations, variances = run(removal, *at_rest(10.51), headings=headings, deviation=0.1)
    yaw = yaws(orientations)
    assert yaw[50] == pytest.approx(1.0)
    assert math.sqrt(variances[50, 2]) == pytest.approx(0.1, rel=0.1)
    left = 1.2 - yaw[55::5]
    time = 0.05 * np.arange(1, len(left) + 1)
    assert left == pytest.approx(0.2 * np.exp(-time / 5.0), abs=2e-3)


def test_compass_does_not_become_better_by_being_asked_often():
    """Its error lasts, as that of a compass does."""
    _, variances = run(estimate(), *at_rest(30.0), headings=np.ones(3000), deviation=0.05)
    assert math.sqrt(variances[-1, 2]) == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize('end', [3.1, -3.1])
def test_yaw_takes_the_short_way(end):
    headings = np.where(np.arange(500) <= 50, -end, end)
    orientations, _ = run(estimate(compass_time=1.0), *at_rest(5.0), headings=headings)
    assert (np.abs(yaws(orientations[50:])) > 3.0).all()


def test_compass_corrects_at_once_what_a_gap_has_hidden():
    removal = estimate(compass_time=100.0, common={'turn_deviation': 0.5})
    run(removal, *at_rest(2.0), headings=np.ones(200))
    later = START_NS + 20 * 10**9
    removal.update(imu(later, LEVEL, ZERO))
    removal.follow_compass(heading(later + 10**6, 2.0))
    last = removal.update(imu(later + 10**7, LEVEL, ZERO)).imu
    assert yaw_from_quaternion(last.orientation) == pytest.approx(2.0, abs=0.05)


def test_compass_before_the_rest_sets_the_first_yaw():
    headings = np.full(60, 0.8)
    orientations, _ = run(estimate(), *at_rest(0.6), headings=headings, every=40, deviation=0.1)
    assert yaws(orientations[50:]) == pytest.approx(np.full(10, 0.8))


# Laws -----------------------------------------------------------------------------------------


def moving(name='vehicle', rate=100, seconds=20.0, **settings):
    """Return force, rate and attitude of a motion, the attitude with yaw 0 at the start."""
    motion = motions.motion_class(name)
    motion = motion(motion.Settings(**settings))
    truth = motion.at(np.arange(0.0, seconds, 1.0 / rate))
    force = np.einsum('nji,nj->ni', truth.rotation, truth.acceleration + LEVEL)
    start = array(quaternion_from_euler(0.0, 0.0, float(truth.euler[0, 2])))
    return force, truth.angular_velocity, start.T @ truth.rotation


def heading_of(truth):
    return np.unwrap(np.arctan2(truth[:, 1, 0], truth[:, 0, 0]))


def test_turning_the_sensor_in_its_mounting_turns_the_attitude_alone():
    force, rate, _ = moving()
    rot_mount = array(quaternion_from_euler(0.7, -0.4, 0.0))
    straight, variances = run(estimate(), force, rate)
    other, others = run(estimate(), force @ rot_mount, rate @ rot_mount)
    # Levelling sets the yaw to 0 for either, so one is turned against the other once and for all.
    off = rotations(other[51:]) @ (rotations(straight[51:]) @ rot_mount).transpose(0, 2, 1)
    assert off == pytest.approx(np.tile(off[0], (len(off), 1, 1)), abs=1e-9)
    assert off[0][2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)
    assert others[51:] == pytest.approx(variances[51:], rel=1e-6)


def test_turning_the_world_turns_the_yaw():
    force, rate, truth = moving()
    yaw = heading_of(truth)
    here, _ = run(estimate(), force, rate, headings=yaw)
    there, _ = run(estimate(), force, rate, headings=yaw + 1.0)
    about_z = array(quaternion_from_euler(0.0, 0.0, 1.0))
    assert rotations(there[51:]) == pytest.approx(about_z @ rotations(here[51:]), abs=1e-9)


def test_same_input_gives_the_same_bits():
    force, rate, _ = moving()
    first, second = (run(estimate(), force, rate)[0] for _ in range(2))
    np.testing.assert_array_equal(first, second)


# Simulated motions ----------------------------------------------------------------------------

BIAS, NOISE, SCALE, OFFSET = 0.02, 0.005, 0.005, 0.005


def measured(random, force, rate):
    """Return force and rate as a sensor with drawn errors measures them."""
    force = force + random.normal(0.0, OFFSET * GRAVITY, 3)
    force = force + random.normal(0.0, 0.03, force.shape)
    rate = rate * (1.0 + random.normal(0.0, SCALE, 3)) + random.normal(0.0, BIAS, 3)
    return force, rate + random.normal(0.0, NOISE, rate.shape)


MOTIONS = {
    'vehicle': ({}, 60.0),
    'turntable': ({'angle': 12.0}, 15.0),
    'walk': ({'steps': 20}, 18.0),
    'slide': ({}, 12.0),
}


@pytest.mark.parametrize('aided', [False, True])
@pytest.mark.parametrize('name', MOTIONS)
def test_error_is_as_large_as_the_covariance_says(name, aided):
    """12 draws of bias, offset, noise and sensitivity: error / σ of 1 at most, not far less."""
    settings, seconds = MOTIONS[name]
    force, rate, truth = moving(name, 50, seconds, **settings)
    random = np.random.default_rng(6)
    ratios = []
    for _ in range(12):
        headings = heading_of(truth) + random.normal(0.0, 0.03) if aided else None
        orientations, variances = run(
            estimate(OFFSET, rate_scale_deviation=SCALE, common={'rate_deviation': NOISE}),
            *measured(random, force, rate),
            0.02,
            headings=headings,
            every=3,
            deviation=0.03,
        )
        off = errors(orientations[30:], truth[30:])
        ratios.append(off / np.sqrt(variances[30:]))
    tilt, turn = np.array(ratios)[:, :, :2], np.array(ratios)[:, :, 2]
    assert 0.2 < math.sqrt((tilt**2).mean()) < 1.2
    assert 0.2 < math.sqrt((turn**2).mean()) < 1.4
    assert np.abs(tilt).max() < 4.0
    assert np.abs(turn).max() < 4.0


def test_slow_turns_of_a_vehicle_are_not_learnt_for_bias():
    """80 s for an eight: the yaw stays right to 3° in three minutes."""
    force, rate, truth = moving('vehicle', 50, 184.0, loop_time=80.0)
    random = np.random.default_rng(2)
    rate = rate + 0.01 + random.normal(0.0, NOISE, rate.shape)
    orientations, _ = run(estimate(), force, rate, 0.02)
    off = errors(orientations[30:], truth[30:])
    assert np.abs(off[:, 2]).max() < 3.0 * DEGREE
    assert np.sqrt((off[:, :2] ** 2).mean()) < 1.0 * DEGREE


def test_linear_acceleration_is_right_while_it_turns():
    """Turned over by 60° and back, as in the hand: gravity is off all the way."""
    time = np.arange(0.0, 20.0, 0.01)
    half = 0.5 * math.radians(60.0)
    roll = np.where(time > 2.0, half * (1.0 - np.cos(time - 2.0)), 0.0)
    turn = np.where(time > 2.0, half * np.sin(time - 2.0), 0.0)
    forces = GRAVITY * np.transpose([np.zeros(2000), np.sin(roll), np.cos(roll)])
    removal = estimate()
    left = []
    for k, stamp_ns in enumerate(stamps(2000, 0.01)):
        with suppress(NotLevelledError):
            made = removal.update(imu(stamp_ns, forces[k], (turn[k], 0.0, 0.0)))
            left.append(made.acceleration.acceleration)
    assert np.abs(left).max() < 0.01


# The life of an estimator -----------------------------------------------------------------------


def test_gap_holds_the_attitude_and_its_uncertainty_grows():
    removal = estimate(common={'turn_deviation': 0.1})
    run(removal, *at_rest(2.0))
    before = removal.update(imu(START_NS + 2 * 10**9, LEVEL, ZERO)).imu
    after = removal.update(imu(START_NS + 5 * 10**9, LEVEL, (1.0, 0.0, 0.0))).imu
    assert after.orientation == before.orientation
    grown = np.subtract(after.orientation_covariance, before.orientation_covariance)[::4]
    assert grown == pytest.approx([0.09] * 3, rel=0.01)


def test_gravity_makes_good_for_a_gap():
    removal = estimate(tilt_time=2.0)
    run(removal, *at_rest(2.0))
    tilt = 0.3
    force = (0.0, GRAVITY * math.sin(tilt), GRAVITY * math.cos(tilt))
    later = START_NS + 10 * 10**9
    orientations, variances = run(removal, *at_rest(25.0, force=force), start_ns=later)
    assert orientations[-1] == pytest.approx(quaternion_from_euler(tilt, 0.0, 0.0), abs=2e-3)
    assert variances[-1, 0] < 1.3 * DEGREE**2


def test_free_fall_leaves_the_attitude_to_the_gyro():
    falling = at_rest(30.0, force=ZERO)
    orientations, _ = run(estimate(), *then(at_rest(1.0), falling, at_rest(10.0)))
    assert np.isfinite(orientations[51:]).all()
    assert orientations[-1] == pytest.approx((0.0, 0.0, 0.0, 1.0), abs=1e-6)


def test_levelling_again_keeps_yaw_and_renews_tilt_and_bias():
    removal = estimate()
    run(removal, *at_rest(1.0), headings=np.full(100, 1.0))
    future = removal.level()
    force = array(quaternion_from_euler(0.2, 0.1, 0.0)).T @ LEVEL
    signals = at_rest(0.6, force=force, rate=(0.0, 0.0, 0.05))
    orientations, _ = run(removal, *signals, start_ns=START_NS + 10**9)
    assert 'roll 11.459°, pitch 5.730°, gyro bias 0.000, 0.000, 2.865 °/s' in future.result(0)
    assert orientations[-1] == pytest.approx(quaternion_from_euler(0.2, 0.1, 1.0), abs=0.03)


def test_stamps_that_go_back_far_start_all_over():
    removal = estimate()
    force, rate, _ = moving()
    run(removal, force, rate)
    earlier = START_NS - 10**11
    again, _ = run(removal, force, rate, start_ns=earlier)
    np.testing.assert_array_equal(again, run(estimate(), force, rate, start_ns=earlier)[0])
    assert removal.restarts == 1


def test_reset_starts_all_over():
    removal = estimate()
    force, rate, _ = moving()
    run(removal, force, rate)
    removal.reset()
    np.testing.assert_array_equal(run(removal, force, rate)[0], run(estimate(), force, rate)[0])


@pytest.mark.parametrize('rate', [(math.nan, 0.0, 0.0), (0.0, math.inf, -math.inf)])
def test_rate_that_is_no_number_is_refused_and_leaves_no_trace(rate):
    force, turn, _ = moving(seconds=5.0)
    expected, _ = run(estimate(), force, turn)
    disturbed = estimate()
    run(disturbed, force[:200], turn[:200])
    later = START_NS + 2 * 10**9
    with pytest.raises(NotFiniteError, match='angular velocity'):
        disturbed.update(imu(later, LEVEL, rate))
    with pytest.raises(NotFiniteError, match='angular velocity'):
        disturbed.update(imu(later, LEVEL, ZERO, (math.nan,) * 9))
    rest, _ = run(disturbed, force[200:], turn[200:], start_ns=later)
    np.testing.assert_array_equal(rest, expected[200:])


def test_device_without_a_gyro_is_told_what_to_do():
    with pytest.raises(MissingRateError, match=r'set gravity\.attitude to rest'):
        estimate().update(ImuSample(START_NS, 'imu_link', LEVEL))


def test_gyro_in_degrees_is_found_at_rest():
    removal = estimate()
    orientations, _ = run(removal, *at_rest(1.0, rate=(0.5, 0.0, 0.0)))
    assert np.isnan(orientations).all()
    assert isinstance(removal.findings[0], CalibrationError)
    assert '°/s instead of rad/s' in str(removal.findings[0])


def test_turning_before_the_rest_delays_the_attitude():
    turning = at_rest(1.53)
    turning[1][::2, 2] = 0.2
    orientations, _ = run(estimate(), *then(turning, at_rest(0.6)))
    assert np.isnan(orientations[:200]).all()
    assert np.isfinite(orientations[-1]).all()


def test_rate_comes_without_its_bias_which_is_not_known_exactly():
    removal = estimate()
    run(removal, *at_rest(0.6, rate=(0.01, -0.02, 0.03)))
    noise = (2e-6, 1e-6, 0.0, 1e-6, 2e-6, 0.0, 0.0, 0.0, 2e-6)
    passed = removal.update(imu(START_NS + 10**9, LEVEL, (0.11, 0.18, 0.33), noise)).imu
    assert passed.angular_velocity == pytest.approx((0.1, 0.2, 0.3))
    added = np.subtract(passed.angular_velocity_covariance, noise)
    assert added[[1, 2, 3, 5, 6, 7]] == pytest.approx(0.0)
    assert (added[[0, 4, 8]] > 0.0).all()
    assert (added[[0, 4, 8]] < 1e-5).all()
    unknown = removal.update(imu(START_NS + 11 * 10**8, LEVEL, (0.11, 0.18, 0.33))).imu
    assert unknown.angular_velocity_covariance[0] > CommonSettings().rate_deviation ** 2
