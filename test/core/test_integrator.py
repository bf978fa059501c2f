"""Double integration against closed forms, laws, and the documents' checks."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import (
    LateSampleError,
    MissingAttitudeError,
    NotAtRestError,
    NotFiniteError,
    RepeatedStampError,
    SampleError,
    SettingsError,
    SupersededError,
    ZeroStampError,
)
from dead_reckoning.core.integrator import Integrator, IntegratorSettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import (
    matrix_from_quaternion,
    quaternion_from_euler,
    rotate,
)
from dead_reckoning.core.samples import (
    IDENTITY_QUATERNION,
    UNKNOWN,
    ZERO,
    ImuSample,
    LinearAcceleration,
)

START_NS = 1_700_000_000_000_000_000
STEP_NS = 10_000_000
DT = 0.01
NAN, INF = math.nan, math.inf
BARE = {'window_minimum': 0.0, 'window_maximum': 0.0, 'movement_end': 'off'}
METHODS = ['trapezoid', 'euler']


def integrator(**settings):
    return Integrator(IntegratorSettings(**settings), CommonSettings())


def bare(**settings):
    """Return an integrator without window and movement-end check."""
    return integrator(**(BARE | settings))


def pair(
    stamp_ns,
    acceleration,
    orientation=IDENTITY_QUATERNION,
    noise=UNKNOWN,
    attitude=UNKNOWN,
    rate=None,
):
    x, y, z = acceleration
    imu = ImuSample(
        stamp_ns,
        'imu_link',
        (x, y, z + GRAVITY),
        noise,
        rate,
        orientation=orientation,
        orientation_covariance=attitude,
    )
    return LinearAcceleration(stamp_ns, 'odom', acceleration), imu


def run(estimator, accelerations, stamps_ns=None, orientation=IDENTITY_QUATERNION):
    """Feed accelerations, shape (n, 3) or along x (n,); return the states."""
    accelerations = np.asarray(accelerations, dtype=float)
    if accelerations.ndim == 1:
        accelerations = np.outer(accelerations, [1.0, 0.0, 0.0])
    if stamps_ns is None:
        stamps_ns = START_NS + STEP_NS * np.arange(len(accelerations))
    return [
        estimator.update(*pair(int(stamp), tuple(acceleration), orientation))
        for stamp, acceleration in zip(stamps_ns, accelerations.tolist(), strict=True)
    ]


def plain(states):
    return [dataclasses.astuple(state) for state in states]


def positions(states):
    return np.array([state.position for state in states])


def velocities(states):
    return np.array([state.velocity for state in states])


# Closed forms ---------------------------------------------------------------------------------


def test_constant_acceleration_is_exact_under_trapezoid():
    acceleration = np.array([0.5, -1.0, 2.0])
    states = run(bare(), np.tile(acceleration, (501, 1)))
    time = DT * np.arange(501)[:, np.newaxis]
    np.testing.assert_allclose(velocities(states), acceleration * time, atol=1e-12)
    np.testing.assert_allclose(positions(states), 0.5 * acceleration * time**2, atol=1e-11)


def irregular(count, seed=5):
    steps = np.random.default_rng(seed).integers(2_000_000, 30_000_000, count - 1)
    return START_NS + np.concatenate(([0], np.cumsum(steps)))


def test_euler_is_that_of_ch_robotics():
    """v[k+1] = v[k] + T a[k], r[k+1] = r[k] + T v[k], with T as the stamps say."""
    random = np.random.default_rng(6)
    accelerations, stamps = random.normal(0.0, 2.0, (200, 3)), irregular(200)
    states = run(bare(method='euler'), accelerations, stamps)
    velocity, position = np.zeros(3), np.zeros(3)
    for k, state in enumerate(states):
        assert state.velocity == pytest.approx(velocity, abs=1e-12)
        assert state.position == pytest.approx(position, abs=1e-12)
        if k + 1 < len(states):
            step = (stamps[k + 1] - stamps[k]) * 1e-9
            velocity, position = velocity + step * accelerations[k], position + step * velocity


def test_trapezoid_is_that_of_an3397_with_measured_steps():
    random = np.random.default_rng(7)
    accelerations, stamps = random.normal(0.0, 2.0, (200, 3)), irregular(200)
    states = run(bare(), accelerations, stamps)
    velocity, position = np.zeros(3), np.zeros(3)
    for k in range(1, len(states)):
        step = (stamps[k] - stamps[k - 1]) * 1e-9
        before = velocity
        velocity = velocity + step * 0.5 * (accelerations[k - 1] + accelerations[k])
        position = position + step * 0.5 * (before + velocity)
        assert states[k].velocity == pytest.approx(velocity, abs=1e-12)
        assert states[k].position == pytest.approx(position, abs=1e-12)


def test_constant_acceleration_over_irregular_steps():
    """A nominal dt would be wrong here by far."""
    stamps = irregular(300)
    time = (stamps - stamps[0]) * 1e-9
    assert np.diff(time).std() > 0.005
    states = run(bare(), np.ones(300), stamps)
    np.testing.assert_allclose(positions(states)[:, 0], 0.5 * time**2, atol=1e-10)


@pytest.mark.parametrize(('method', 'order'), [('trapezoid', 2), ('euler', 1)])
def test_error_falls_with_the_order_of_the_method(method, order):
    """a = sin 2t for 2 s; halving dt divides the error by 2^order."""
    errors = []
    for count in (100, 200, 400, 800):
        time = np.linspace(0.0, 2.0, count + 1)
        stamps = START_NS + np.round(time * 1e9).astype(np.int64)
        last = run(bare(method=method), np.sin(2.0 * time), stamps)[-1]
        errors.append(abs(last.position[0] - (2.0 / 2.0 - math.sin(4.0) / 4.0)))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert ratios == pytest.approx([2.0**order] * 3, rel=0.05)


@pytest.mark.parametrize('method', METHODS)
def test_first_sample_only_sets_the_start(method):
    (state,) = run(bare(method=method), [5.0])
    assert state.stamp_ns == START_NS
    assert (state.position, state.velocity) == (ZERO, ZERO)
    assert not state.stationary


def test_state_carries_attitude_and_rate():
    attitude = quaternion_from_euler(0.1, 0.2, 0.3)
    covariance = (1e-3, 0.0, 0.0, 0.0, 2e-3, 0.0, 0.0, 0.0, 3e-3)
    imu = ImuSample(
        START_NS, 'imu_link', ZERO, UNKNOWN, (0.1, 0.2, 0.3), (4.0,) * 9, attitude, covariance
    )
    state = bare().update(LinearAcceleration(START_NS, 'odom', ZERO), imu)
    assert state.attitude == attitude
    assert state.attitude_covariance == covariance
    assert state.angular_velocity == (0.1, 0.2, 0.3)
    assert state.angular_velocity_covariance == (4.0,) * 9


def test_attitude_without_covariance_gets_the_one_that_is_set():
    estimator = Integrator(IntegratorSettings(), CommonSettings(attitude_deviation=0.1))
    (state,) = run(estimator, [0.0])
    assert state.attitude_covariance[::4] == pytest.approx((0.01,) * 3)


# Laws -----------------------------------------------------------------------------------------


def wandering(count=300, seed=8):
    """Push along all axes, in bursts with rests between."""
    random = np.random.default_rng(seed)
    pushes = random.normal(0.0, 1.0, (count, 3))
    pushes[60:100] = pushes[200:240] = 0.01
    return pushes


def turned(yaw, quaternion):
    x, y, z, w = quaternion
    s, c = math.sin(yaw / 2.0), math.cos(yaw / 2.0)
    return (c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z)


@given(st.floats(-3.1, 3.1))
@pytest.mark.parametrize('movement_end', ['all', 'each', 'off'])
def test_turning_the_world_turns_the_path(movement_end, yaw):
    """Sensor and push turn together, so window and check see the same."""
    quaternion = quaternion_from_euler(0.4, -0.3, 0.2)
    rot_yaw = np.reshape(matrix_from_quaternion(quaternion_from_euler(0.0, 0.0, yaw)), (3, 3))
    pushes = wandering(120)
    settings = {'movement_end': movement_end}
    before = run(integrator(**settings), pushes, orientation=quaternion)
    after = run(integrator(**settings), pushes @ rot_yaw.T, orientation=turned(yaw, quaternion))
    np.testing.assert_allclose(positions(after), positions(before) @ rot_yaw.T, atol=1e-12)
    np.testing.assert_allclose(velocities(after), velocities(before) @ rot_yaw.T, atol=1e-12)
    assert [s.stationary for s in after] == [s.stationary for s in before]
    covariances = [
        np.reshape(states[-1].position_covariance, (3, 3)) for states in (before, after)
    ]
    np.testing.assert_allclose(covariances[1], rot_yaw @ covariances[0] @ rot_yaw.T, atol=1e-12)


@pytest.mark.parametrize('method', METHODS)
def test_shifting_the_time_shifts_nothing_else(method):
    stamps = irregular(300)
    before = run(integrator(method=method), wandering(), stamps)
    after = run(integrator(method=method), wandering(), stamps - START_NS + 1)
    assert [row[1:] for row in plain(before)] == [row[1:] for row in plain(after)]


@pytest.mark.parametrize('method', METHODS)
def test_scaling_push_and_window_scales_the_path(method):
    """By a power of two, so not one bit differs."""
    narrow = integrator(method=method, window_minimum=-0.05, window_maximum=0.05)
    wide = integrator(method=method, window_minimum=-0.2, window_maximum=0.2)
    before, after = run(narrow, wandering()), run(wide, 4.0 * wandering())
    np.testing.assert_array_equal(positions(after), 4.0 * positions(before))
    np.testing.assert_array_equal(velocities(after), 4.0 * velocities(before))


def test_same_input_gives_the_same_bits():
    assert plain(run(integrator(), wandering())) == plain(run(integrator(), wandering()))


# The discrimination window ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ('value', 'counts'),
    [
        (0.2, False),
        (math.nextafter(0.2, 1.0), True),
        (-0.1, False),
        (math.nextafter(-0.1, -1.0), True),
        (0.15, False),
        (-0.15, True),
        (0.0, False),
    ],
)
def test_window_is_inclusive_at_both_ends_and_need_not_be_symmetric(value, counts):
    estimator = integrator(window_minimum=-0.1, window_maximum=0.2)
    states = run(estimator, [0.0, value, value])
    assert (states[-1].velocity[0] != 0.0) is counts


def test_what_passes_the_window_passes_whole():
    states = run(integrator(window_minimum=-0.1, window_maximum=0.1), [0.0, 1.0])
    assert states[-1].velocity[0] == pytest.approx(0.5 * DT)


def test_window_looks_along_the_axes_of_the_sensor():
    """0.06 m/s² between two axes of the sensor is 0.042 along each, inside ± 0.05."""
    push = np.full(20, 0.06)
    along = run(integrator(), push)
    between = run(integrator(), push, orientation=quaternion_from_euler(0.0, 0.0, math.pi / 4))
    assert along[-1].velocity[0] == pytest.approx(0.06 * 19 * DT)
    assert between[-1].velocity == ZERO


def test_axis_of_the_window_turns_with_the_sensor():
    """Only the component along the sensor's x axis is outside the window."""
    quaternion = quaternion_from_euler(0.0, 0.0, math.radians(30.0))
    rot_ws = matrix_from_quaternion(quaternion)
    push = rotate(rot_ws, (1.0, 0.04, 0.0))
    states = run(integrator(), np.tile(push, (20, 1)), orientation=quaternion)
    expected = np.multiply(rotate(rot_ws, (1.0, 0.0, 0.0)), 19 * DT)
    assert states[-1].velocity == pytest.approx(expected, abs=1e-12)


# The movement-end check -------------------------------------------------------------------------


def quiet_after_push(quiet, push=10):
    return np.concatenate((np.ones(push), np.zeros(quiet)))


@pytest.mark.parametrize('samples', [1, 25, 40])
def test_movement_ends_with_the_last_quiet_sample_asked_for(samples):
    estimator = integrator(movement_end_samples=samples)
    states = run(estimator, quiet_after_push(samples + 5))
    ended = 10 + samples - 1
    assert [state.stationary for state in states] == [False] * ended + [True] * 6
    assert all(state.velocity[0] > 0.0 for state in states[1:ended])
    assert all(state.velocity == ZERO for state in states[ended:])
    assert states[-1].position == states[ended].position


def test_twenty_five_samples_by_default():
    states = run(integrator(), quiet_after_push(25))
    assert [state.stationary for state in states] == [False] * 34 + [True]


def test_one_sample_outside_starts_the_count_anew():
    accelerations = quiet_after_push(24 + 1 + 25)
    accelerations[34] = 1.0
    stationary = [state.stationary for state in run(integrator(), accelerations)]
    assert stationary == [False] * 59 + [True]


def test_tremor_is_rest_and_moves_next_to_nothing():
    """8 Hz, half of its samples outside the window: a centimetre a minute is what may stay."""
    tremor = 0.15 * np.sin(2 * np.pi * 8.0 * 0.01 * np.arange(6000))
    states = run(integrator(), tremor)
    assert not states[23].stationary
    assert all(state.stationary for state in states[60:])
    assert abs(states[-1].position[0]) < 0.01
    assert states[-1].position_covariance[0] < 1.0


@pytest.mark.parametrize(
    ('accelerations', 'why'),
    [
        (0.5 * np.sin(2 * np.pi * 8.0 * 0.01 * np.arange(200)), 'it shakes'),
        (0.06 + 0.1 * np.sin(2 * np.pi * 8.0 * 0.01 * np.arange(200)), 'it speeds up'),
    ],
    ids=lambda value: value if isinstance(value, str) else '',
)
def test_what_moves_is_no_rest(accelerations, why):
    assert not any(state.stationary for state in run(integrator(), accelerations)), why


def test_movement_out_of_a_tremor_loses_nothing():
    """The first samples outside the window are integrated, though they still pass for tremor."""
    rest = 0.15 * np.sin(2 * np.pi * 8.0 * 0.01 * np.arange(200))
    push = np.linspace(0.0, 1.0, 51)
    before, after = (
        run(integrator(movement_end=end), np.concatenate((rest, push)))[-1].velocity[0]
        for end in ('off', 'all')
    )
    assert after == pytest.approx(before, abs=0.005)


def test_a_huge_value_leaves_nothing_behind():
    accelerations = np.concatenate(([9e5], np.zeros(200)))
    assert run(integrator(), accelerations)[-1].stationary


def test_rest_from_the_start_is_found():
    stationary = [state.stationary for state in run(integrator(), np.zeros(30))]
    assert stationary == [False] * 24 + [True] * 6


def test_movement_starts_again_at_once():
    states = run(integrator(), np.concatenate((np.zeros(30), np.ones(5))))
    assert [state.stationary for state in states[29:]] == [True] + [False] * 5
    assert states[-1].velocity[0] == pytest.approx(4.5 * DT)


def two_axes():
    """Push x and y; then x rests, y goes on."""
    pushes = np.zeros((80, 3))
    pushes[:10, 0] = 1.0
    pushes[:, 1] = 1.0
    return pushes


def test_all_waits_for_all_axes():
    states = run(integrator(movement_end='all'), two_axes())
    assert states[-1].velocity[0] == pytest.approx(9.5 * DT)
    assert not any(state.stationary for state in states)


def test_each_ends_the_movement_axis_by_axis():
    states = run(integrator(movement_end='each'), two_axes())
    velocity = velocities(states)
    assert (velocity[1:34, 0] > 0.0).all()
    assert (velocity[34:, 0] == 0.0).all()
    assert velocity[-1, 1] == pytest.approx(79 * DT)
    assert not any(state.stationary for state in states)
    pushes = np.concatenate((two_axes(), np.zeros((25, 3))))
    assert run(integrator(movement_end='each'), pushes)[-1].stationary


def test_each_looks_along_the_axes_of_the_sensor():
    quaternion = quaternion_from_euler(0.3, 0.2, 1.0)
    rot_ws = np.reshape(matrix_from_quaternion(quaternion), (3, 3))
    pushes = two_axes() @ rot_ws.T
    states = run(integrator(movement_end='each'), pushes, orientation=quaternion)
    velocity_s = velocities(states) @ rot_ws
    assert velocity_s[33, 0] == pytest.approx(9.5 * DT)
    np.testing.assert_allclose(velocity_s[34:, 0], 0.0, atol=1e-12)
    assert velocity_s[-1, 1] == pytest.approx(79 * DT)


def test_off_lets_the_velocity_run_on():
    states = run(integrator(movement_end='off'), quiet_after_push(200))
    assert states[-1].velocity[0] == pytest.approx(9.5 * DT)
    assert not any(state.stationary for state in states)


def test_stationary_state_says_how_still_it_may_be():
    states = run(integrator(stationary_deviation=0.02), np.zeros(30))
    assert np.sqrt(states[-1].velocity_covariance[::4]) == pytest.approx([0.02] * 3, rel=1e-3)


@pytest.mark.parametrize('rate', [10, 100])
def test_position_grows_no_more_uncertain_while_it_is_held(rate):
    stamps = START_NS + np.arange(60 * rate) * (10**9 // rate)
    states = run(integrator(), np.zeros(60 * rate), stamps)
    assert states[24].stationary
    assert states[-1].position_covariance == states[24].position_covariance


def test_position_grows_uncertain_again_once_it_moves():
    states = run(integrator(), np.concatenate((np.zeros(30), np.ones(2))))
    held, first, second = (state.position_covariance[0] for state in states[-3:])
    assert held < first < second


def test_check_without_a_window_is_refused():
    with pytest.raises(SettingsError, match=r'integrator\.window_maximum'):
        IntegratorSettings(window_minimum=0.0, window_maximum=0.0)
    IntegratorSettings(**BARE)


# Axes -----------------------------------------------------------------------------------------


def test_axes_that_do_not_move_are_held_at_zero():
    states = run(bare(axes=('x',)), np.tile([1.0, 2.0, 3.0], (50, 1)))
    assert states[-1].velocity == (pytest.approx(49 * DT), 0.0, 0.0)
    assert states[-1].position == (pytest.approx(0.5 * (49 * DT) ** 2), 0.0, 0.0)


def test_axes_are_those_of_the_sensor():
    """The sensor's x axis points to the world's y."""
    estimator = bare(axes=('x',))
    quaternion = quaternion_from_euler(0.0, 0.0, math.pi / 2)
    states = run(estimator, np.tile([1.0, 2.0, 3.0], (50, 1)), orientation=quaternion)
    assert states[-1].velocity == pytest.approx((0.0, 2.0 * 49 * DT, 0.0), abs=1e-12)


def test_rest_asks_only_the_axes_that_move():
    pushes = np.zeros((30, 3))
    pushes[:, 2] = 5.0
    assert run(integrator(axes=('y', 'x')), pushes)[-1].stationary
    assert not run(integrator(), pushes)[-1].stationary


# Gaps -----------------------------------------------------------------------------------------


def gap_of(seconds, count=50):
    stamps = START_NS + STEP_NS * np.arange(2 * count)
    stamps[count:] += round(seconds * 1e9) - STEP_NS
    return stamps


def test_gap_holds_position_and_velocity():
    estimator = bare(max_gap=0.5)
    states = run(estimator, np.ones(100), gap_of(0.500000001))
    before, after = states[49], states[50]
    assert (after.position, after.velocity) == (before.position, before.velocity)
    assert estimator.gaps == 1
    assert states[51].velocity[0] == pytest.approx(after.velocity[0] + DT)


def test_longest_gap_that_is_integrated():
    estimator = bare(max_gap=0.5)
    states = run(estimator, np.ones(100), gap_of(0.5))
    assert states[50].velocity[0] == pytest.approx(states[49].velocity[0] + 0.5)
    assert estimator.gaps == 0


def test_uncertainty_grows_over_a_gap():
    """What the body had in speed, and what it may have done meanwhile."""
    states = run(bare(gap_acceleration=2.0), np.ones(100), gap_of(3.0))
    before, after = states[49], states[50]
    speed = before.velocity[0]
    grown = np.subtract(after.position_covariance, before.position_covariance)[::4]
    assert (grown >= (speed * 3.0) ** 2 + (0.5 * 2.0 * 9.0) ** 2).all()
    grown = np.subtract(after.velocity_covariance, before.velocity_covariance)[::4]
    assert grown == pytest.approx([36.0] * 3)


def test_quiet_before_a_gap_does_not_count_after_it():
    states = run(integrator(), np.zeros(100), gap_of(3.0, count=50))
    assert states[49].stationary
    assert [state.stationary for state in states[50:]] == [False] * 24 + [True] * 26


# Restart and reset ------------------------------------------------------------------------------


def test_stamps_that_go_back_far_start_all_over():
    estimator = integrator()
    run(estimator, wandering())
    again = run(estimator, wandering(), START_NS - 10**10 + STEP_NS * np.arange(300))
    fresh = run(integrator(), wandering(), START_NS - 10**10 + STEP_NS * np.arange(300))
    assert plain(again) == plain(fresh)
    assert estimator.restarts == 1


def test_reset_returns_to_the_origin():
    estimator = integrator()
    run(estimator, wandering())
    estimator.reset()
    again = run(estimator, wandering(), START_NS + 1 + STEP_NS * np.arange(300))
    fresh = run(integrator(), wandering(), START_NS + 1 + STEP_NS * np.arange(300))
    assert plain(again) == plain(fresh)
    assert estimator.restarts == 0


# Errors ---------------------------------------------------------------------------------------


def doubtful(now, variance):
    acceleration, imu = pair(now, ZERO)
    return dataclasses.replace(acceleration, covariance=(*UNKNOWN[:8], variance)), imu


BAD = [
    (lambda now: pair(now, (NAN, 0.0, 0.0)), NotFiniteError),
    (lambda now: pair(now, (0.0, INF, 0.0)), NotFiniteError),
    (lambda now: pair(now, (0.0, INF, -INF)), NotFiniteError),
    (lambda now: doubtful(now, NAN), NotFiniteError),
    (lambda now: doubtful(now, INF), NotFiniteError),
    (lambda now: pair(now, ZERO, (NAN, 0.0, 0.0, 1.0)), NotFiniteError),
    (lambda now: pair(now, ZERO, (0.0, 0.0, 0.0, 0.0)), NotFiniteError),
    (lambda now: pair(now, ZERO, noise=(NAN,) * 9), NotFiniteError),
    (lambda now: pair(now, ZERO, noise=(INF, *UNKNOWN[1:])), NotFiniteError),
    (lambda now: pair(now, ZERO, attitude=(*UNKNOWN[:8], NAN)), NotFiniteError),
    (lambda now: pair(now, ZERO, rate=(NAN, 0.0, 0.0)), NotFiniteError),
    (lambda now: pair(now, ZERO, None), MissingAttitudeError),
    (lambda now: pair(0, ZERO), ZeroStampError),
    (lambda now: pair(now - STEP_NS, ZERO), RepeatedStampError),
    (lambda now: pair(now - STEP_NS - 1, ZERO), LateSampleError),
    (lambda now: pair(now - 10**9, ZERO), LateSampleError),
]


@pytest.mark.parametrize(('bad', 'error'), BAD)
@pytest.mark.parametrize('calibrating', [False, True])
def test_bad_sample_is_refused_and_leaves_no_trace(bad, error, calibrating):
    at = 110
    stamps = START_NS + STEP_NS * np.arange(300)
    undisturbed, disturbed = integrator(), integrator()
    if calibrating:
        run(undisturbed, np.zeros(1), [START_NS - 1])
        run(disturbed, np.zeros(1), [START_NS - 1])
        undisturbed.calibrate()
        disturbed.calibrate()
    expected = plain(run(undisturbed, wandering(), stamps))
    states = run(disturbed, wandering()[:at], stamps[:at])
    with pytest.raises(SampleError) as caught:
        disturbed.update(*bad(int(stamps[at])))
    assert caught.type is error
    states += run(disturbed, wandering()[at:], stamps[at:])
    assert plain(states) == expected
    assert disturbed.offset == undisturbed.offset


def test_quaternion_of_another_length_is_brought_to_one():
    longer = tuple(2.0 * part for part in quaternion_from_euler(0.3, 0.2, 1.0))
    states = run(bare(), np.ones(20), orientation=longer)
    assert states[-1].velocity == pytest.approx((19 * DT, 0.0, 0.0), abs=1e-12)
    assert math.hypot(*states[-1].attitude) == pytest.approx(1.0)


@pytest.mark.parametrize('noise', [UNKNOWN, (-1.0, *UNKNOWN[1:])])
def test_noise_that_the_imu_does_not_say_is_the_one_that_is_set(noise):
    """Covariance −1: the attitude comes from a device that measures no acceleration."""
    quiet = CommonSettings(attitude_deviation=0.0, noise_deviation=0.1)
    estimator = Integrator(IntegratorSettings(**BARE, offset_deviation=0.0), quiet)
    for step in range(101):
        state = estimator.update(*pair(START_NS + step * STEP_NS, ZERO, noise=noise))
    assert state.velocity_covariance[0] == pytest.approx(100 * (0.1 * DT) ** 2, rel=1e-3)


@pytest.mark.parametrize('method', [*METHODS, 'kalman'])
@pytest.mark.parametrize('axes', [('x', 'y', 'z'), ('z',)])
def test_what_noise_and_attitude_do_not_explain_is_gravity(method, axes):
    """It lasts, so it grows as ½·σ·t², and only upwards."""
    estimator = bare(method=method, axes=axes, offset_deviation=0.0, scale_deviation=0.0)
    quaternion = quaternion_from_euler(0.0, 0.1, 0.5)
    rot_ws = np.reshape(matrix_from_quaternion(quaternion), (3, 3))
    attitude, noise = np.diag([1e-12, 1e-12, 1e-12]), np.diag([0.01, 0.02, 0.03])
    covariance = rot_ws @ noise @ rot_ws.T + np.diag([0.0, 0.0, 0.03**2])
    for step in range(501):
        acceleration, imu = pair(
            START_NS + step * STEP_NS, ZERO, quaternion, tuple(noise.ravel()),
            tuple(attitude.ravel()),
        )  # fmt: skip
        acceleration = dataclasses.replace(acceleration, covariance=tuple(covariance.ravel()))
        state = estimator.update(acceleration, imu)
    variances = np.array(state.position_covariance[::4])
    along = np.cos(0.1) if axes == ('z',) else 1.0  # what of gravity the axis sees, and climbs
    white = 0.03 * DT * 5.0**3 / 3.0
    assert variances[2] == pytest.approx((0.5 * 0.03 * along**2 * 25.0) ** 2 + white, rel=0.05)
    assert (variances[:2] < 1.1 * white).all()


def test_acceleration_of_another_device_says_nothing_of_gravity():
    acceleration, imu = pair(START_NS, ZERO, noise=(-1.0, *UNKNOWN[1:]))
    estimator = bare()
    for step in range(101):
        now = START_NS + step * STEP_NS
        state = estimator.update(
            dataclasses.replace(acceleration, stamp_ns=now, covariance=(0.04,) * 9),
            dataclasses.replace(imu, stamp_ns=now),
        )
    assert math.sqrt(state.position_covariance[8]) < 0.01


# Calibration ----------------------------------------------------------------------------------


def test_calibration_takes_the_residual_offset_out():
    """In the sensor's axes: after it has turned, the offset turns with it."""
    offset_s = (0.2, -0.1, 0.05)
    estimator = bare(calibration_duration=0.5)
    quaternion = quaternion_from_euler(0.0, 0.0, 1.0)
    pushes = np.tile(rotate(matrix_from_quaternion(quaternion), offset_s), (51, 1))
    future = estimator.calibrate()
    assert not future.done()
    run(estimator, pushes, orientation=quaternion)
    assert future.result(timeout=0) == 'offset along x, y, z: 0.2000, -0.1000, 0.0500 m/s²'
    assert estimator.offset == pytest.approx(offset_s)
    estimator.reset()
    other = quaternion_from_euler(0.5, -0.4, -2.0)
    pushes = np.tile(rotate(matrix_from_quaternion(other), offset_s), (100, 1))
    states = run(estimator, pushes, orientation=other)
    assert states[-1].velocity == pytest.approx(ZERO, abs=1e-12)


def test_calibration_starts_from_the_whole_offset_each_time():
    estimator = bare(calibration_duration=0.5)
    for start in (0, 100):
        estimator.calibrate()
        run(estimator, np.full(60, 0.2), START_NS + STEP_NS * (start + np.arange(60)))
        assert estimator.offset == pytest.approx((0.2, 0.0, 0.0))


def test_calibration_in_motion_fails_and_keeps_the_offset():
    estimator = bare(calibration_duration=0.5)
    estimator.calibrate()
    run(estimator, np.full(60, 0.2))
    future = estimator.calibrate()
    pushes = np.resize([1.0, -1.0], 60)
    run(estimator, pushes, START_NS + STEP_NS * (100 + np.arange(60)))
    assert isinstance(future.exception(timeout=0), NotAtRestError)
    assert estimator.offset == pytest.approx((0.2, 0.0, 0.0))


def test_asking_again_supersedes_the_first():
    estimator = bare()
    first, second = estimator.calibrate(), estimator.calibrate()
    assert isinstance(first.exception(timeout=0), SupersededError)
    run(estimator, np.zeros(101))
    assert second.result(timeout=0)


def test_stamps_that_go_back_end_a_calibration():
    estimator = bare()
    run(estimator, np.zeros(10))
    future = estimator.calibrate()
    run(estimator, np.zeros(10), START_NS + 10**9 + STEP_NS * np.arange(10))
    run(estimator, np.zeros(200), START_NS - 10**10 + STEP_NS * np.arange(200))
    assert isinstance(future.exception(timeout=0), NotAtRestError)


def test_reset_ends_a_calibration():
    estimator = bare()
    future = estimator.calibrate()
    estimator.reset()
    assert isinstance(future.exception(timeout=0), SupersededError)


def test_reset_keeps_the_offset():
    estimator = bare()
    estimator.calibrate()
    run(estimator, np.full(101, 0.2))
    estimator.reset()
    assert estimator.offset == pytest.approx((0.2, 0.0, 0.0))


# Changing settings while running ----------------------------------------------------------------


def test_change_takes_effect_with_the_next_sample_and_touches_no_state():
    estimator = integrator()
    before = run(estimator, quiet_after_push(10))[-1]
    estimator.configure(
        estimator.settings.changed(
            {'integrator.movement_end_samples': 11, 'integrator.window_maximum': 0.5}
        )
    )
    after = run(estimator, [0.4], [START_NS + 20 * STEP_NS])[-1]
    assert after.stationary
    assert after.position[0] > before.position[0] > 0.0
    estimator.configure(estimator.settings.changed({'integrator.movement_end': 'off'}))
    last = run(estimator, [0.4], [START_NS + 21 * STEP_NS])[-1]
    assert not last.stationary
    assert last.position == after.position


def test_what_may_change_while_running_says_so():
    mutable = {declared.name for declared in IntegratorSettings.parameters() if declared.mutable}
    assert mutable == {
        'window_minimum',
        'window_maximum',
        'movement_end',
        'movement_end_samples',
        'movement_end_deviation',
    }
