"""The covariance must grow as the errors do: closed forms, Monte Carlo, and the contract."""

import math

import numpy as np
import pytest

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.bias_growth import FLOOR, BiasGrowth
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import (
    isotropic,
    matrix_from_quaternion,
    quaternion_from_euler,
)
from dead_reckoning.core.samples import IDENTITY, IDENTITY_QUATERNION, UNKNOWN, ImuSample

START_NS = 1_700_000_000_000_000_000
DT = 0.01
LEVEL = (0.0, 0.0, GRAVITY)
DEGREE = math.radians(1.0)


def array(matrix):
    return np.reshape(matrix, (3, 3))


def at_rest(growth, seconds, attitude=0.0, noise=0.0, rot_ws=IDENTITY, force_w=LEVEL):
    attitude, noise = isotropic(attitude), isotropic(noise)
    for _ in range(round(seconds / DT)):
        growth.step(DT, rot_ws, force_w, attitude, noise)
    return growth


def deviations(growth):
    return [np.sqrt(np.diag(array(covariance))) for covariance in growth.covariances()]


# Closed forms ---------------------------------------------------------------------------------


def test_nothing_is_ever_certain():
    """A covariance of zeros would read as unknown."""
    for covariance in BiasGrowth(0.0).covariances():
        np.testing.assert_array_equal(array(covariance), FLOOR * np.eye(3))


@pytest.mark.parametrize('seconds', [1.0, 5.0, 10.0, 60.0])
def test_tilt_at_rest_grows_as_half_g_sigma_t_squared(seconds):
    position, velocity = deviations(at_rest(BiasGrowth(0.0), seconds, attitude=DEGREE))
    assert position[:2] == pytest.approx([0.5 * GRAVITY * DEGREE * seconds**2] * 2, rel=1e-6)
    assert velocity[:2] == pytest.approx([GRAVITY * DEGREE * seconds] * 2, rel=1e-6)
    assert position[2] == pytest.approx(math.sqrt(FLOOR))


@pytest.mark.parametrize('seconds', [1.0, 10.0])
def test_offset_grows_as_half_b_t_squared(seconds):
    position, velocity = deviations(at_rest(BiasGrowth(0.02), seconds))
    assert position == pytest.approx([0.5 * 0.02 * seconds**2] * 3, rel=1e-4)
    assert velocity == pytest.approx([0.02 * seconds] * 3, rel=1e-4)


@pytest.mark.parametrize('count', [1, 2, 200])
def test_white_noise_is_that_of_samples_held_for_a_step(count):
    """p = Σ (n − k − ½) dt² a_k, v = Σ dt a_k, every a_k on its own."""
    growth = at_rest(BiasGrowth(0.0), count * DT, noise=0.3)
    weights = (np.arange(count) + 0.5) * DT**2
    position, velocity = (
        array(covariance) - FLOOR * np.eye(3) for covariance in growth.covariances()
    )
    np.testing.assert_allclose(position, 0.09 * (weights**2).sum() * np.eye(3), atol=1e-15)
    np.testing.assert_allclose(velocity, 0.09 * count * DT**2 * np.eye(3), atol=1e-15)


def test_wrong_gravity_lifts_however_the_body_turns():
    growth = BiasGrowth(0.0)
    for step in range(1000):
        rot_ws = matrix_from_quaternion(quaternion_from_euler(0.01 * step, 0.0, 0.0))
        growth.step(DT, rot_ws, LEVEL, UNKNOWN, UNKNOWN, gravity_variance=0.02**2)
    position, velocity = deviations(growth)
    assert position[2] == pytest.approx(0.5 * 0.02 * 100.0, rel=1e-4)
    assert velocity[2] == pytest.approx(0.02 * 10.0, rel=1e-4)
    assert position[:2] == pytest.approx([math.sqrt(FLOOR)] * 2)


def test_offset_averages_out_where_the_body_turns():
    """Half the time upside down, and the offset along x has pushed back as far as forth."""
    forth = matrix_from_quaternion(IDENTITY_QUATERNION)
    back = matrix_from_quaternion(quaternion_from_euler(0.0, 0.0, math.pi))
    growth = at_rest(BiasGrowth(0.02), 5.0, rot_ws=forth)
    _, velocity = deviations(at_rest(growth, 5.0, rot_ws=back))
    assert velocity[:2] == pytest.approx([math.sqrt(FLOOR)] * 2)
    assert velocity[2] == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize('dt', [0.001, 0.01, 0.1])
def test_growth_does_not_depend_on_the_rate(dt):
    growth = BiasGrowth(0.01)
    for _ in range(round(10.0 / dt)):
        growth.step(dt, IDENTITY, LEVEL, isotropic(DEGREE), UNKNOWN)
    position, _ = deviations(growth)
    assert position[0] == pytest.approx(math.hypot(0.5 * GRAVITY * DEGREE * 100.0, 0.5), rel=1e-6)


def test_attitude_that_becomes_better_known_shrinks_what_it_caused():
    """The error is one constant: who knows it better knows better how far it has carried."""
    growth = at_rest(BiasGrowth(0.0), 10.0, attitude=DEGREE)
    before, _ = deviations(growth)
    growth.step(DT, IDENTITY, LEVEL, isotropic(0.1 * DEGREE), UNKNOWN)
    after, _ = deviations(growth)
    assert after[0] == pytest.approx(0.1 * before[0], rel=0.01)


# Rest, reset, gaps ------------------------------------------------------------------------------


def test_stop_makes_the_velocity_known_and_keeps_the_position():
    growth = at_rest(BiasGrowth(0.02), 5.0, attitude=DEGREE, noise=0.1)
    before, _ = deviations(growth)
    growth.stop()
    position, velocity = deviations(growth)
    np.testing.assert_array_equal(position, before)
    assert velocity == pytest.approx([math.sqrt(FLOOR)] * 3)
    assert np.diag(array(growth.covariances(0.25)[1])) == pytest.approx([0.25] * 3)


def test_after_a_stop_growth_begins_anew_from_where_it_is():
    growth = at_rest(BiasGrowth(0.0), 5.0, attitude=DEGREE)
    growth.stop()
    position, velocity = deviations(at_rest(growth, 5.0, attitude=DEGREE))
    leg = 0.5 * GRAVITY * DEGREE * 25.0
    assert position[0] == pytest.approx(2.0 * leg, rel=1e-6), 'one and the same error, twice'
    assert velocity[0] == pytest.approx(GRAVITY * DEGREE * 5.0, rel=1e-6)


def test_stop_along_an_axis_makes_that_velocity_known():
    growth = at_rest(BiasGrowth(0.02), 5.0, attitude=DEGREE)
    _, before = (array(covariance) for covariance in growth.covariances())
    axis = np.array([0.6, 0.8, 0.0])
    growth.stop_along(tuple(axis))
    _, after = (array(covariance) for covariance in growth.covariances())
    assert axis @ after @ axis == pytest.approx(FLOOR, abs=1e-12)
    across = np.array([-0.8, 0.6, 0.0])
    assert across @ after @ across == pytest.approx(across @ before @ across)
    assert after[2, 2] == pytest.approx(before[2, 2])


def test_reset_forgets_all():
    growth = at_rest(BiasGrowth(0.02), 5.0, attitude=DEGREE, noise=0.1)
    growth.reset()
    for covariance in growth.covariances():
        np.testing.assert_array_equal(array(covariance), FLOOR * np.eye(3))


def test_gap_adds_what_it_may_hide():
    growth = BiasGrowth(0.0)
    growth.gap(2.0, speed=3.0, acceleration=0.5)
    position, velocity = deviations(growth)
    assert position == pytest.approx([math.hypot(6.0, 1.0)] * 3)
    assert velocity == pytest.approx([1.0] * 3)


def test_what_a_gap_hid_of_the_velocity_carries_on():
    """One unknown push of 0.5 m/s² for 2 s, then 3 s more at the speed it gave."""
    growth = BiasGrowth(0.0)
    growth.gap(2.0, speed=0.0, acceleration=0.5)
    growth.gap(3.0, speed=0.0, acceleration=0.0)
    position, velocity = deviations(growth)
    assert position == pytest.approx([1.0 + 3.0] * 3)
    assert velocity == pytest.approx([1.0] * 3)


def test_uncertain_velocity_carries_on_through_a_gap():
    growth = at_rest(BiasGrowth(0.0), 5.0, attitude=DEGREE)
    before, velocity = deviations(growth)
    growth.gap(2.0, speed=0.0, acceleration=0.0)
    after, _ = deviations(growth)
    assert after[0] == pytest.approx(before[0] + 2.0 * velocity[0])


# Axes that do not move --------------------------------------------------------------------------


def test_held_axes_do_not_grow():
    growth = at_rest(BiasGrowth(0.02, (True, False, False)), 10.0, attitude=DEGREE)
    for deviation in deviations(growth):
        assert deviation[0] > 0.1
        assert deviation[1:] == pytest.approx([math.sqrt(FLOOR)] * 2)


def test_held_axes_are_those_of_the_sensor():
    quaternion = quaternion_from_euler(0.2, 0.3, 1.0)
    rot_ws = array(matrix_from_quaternion(quaternion))
    growth = at_rest(
        BiasGrowth(0.02, (True, False, True)),
        10.0,
        attitude=DEGREE,
        rot_ws=matrix_from_quaternion(quaternion),
    )
    for covariance in growth.covariances():
        along = np.diag(rot_ws.T @ array(covariance) @ rot_ws)
        assert along[1] == pytest.approx(FLOOR, abs=1e-12)
        assert along[0] > 1e-3
        assert along[2] > 1e-3


# The contract, through the whole chain ----------------------------------------------------------


def pipeline(integrator, attitude='rest', **common):
    values = {
        'gravity.attitude': attitude,
        'gravity.measure': False,
        'integrator.movement_end': 'off',
    }
    values.update({f'integrator.{name}': value for name, value in integrator.items()})
    values.update({f'common.{name}': value for name, value in common.items()})
    return Pipeline(Configuration(values))


def states_of(parts, samples):
    name = 'imu/data_raw' if parts.gravity.settings.attitude == 'rest' else 'imu/data'
    return [
        value
        for sample in samples
        for output, value in parts.chain.push(name, sample)
        if output == 'odom'
    ]


@pytest.mark.parametrize('method', ['trapezoid', 'euler'])
@pytest.mark.parametrize('rate', [10, 100])
def test_one_degree_of_tilt_is_8_6_m_after_10_s(method, rate):
    """Attitude taken from rest, one sigma of 1°, no zero-velocity updates."""
    parts = pipeline({'method': method}, attitude_deviation=DEGREE)
    step_ns = 10**9 // rate
    samples = [ImuSample(START_NS + k * step_ns, 'imu_link', LEVEL) for k in range(11 * rate)]
    states = states_of(parts, samples)
    assert not any(state.stationary for state in states)
    for seconds, metres in ((5, 8.6 / 4.0), (10, 8.6)):
        state = states[seconds * rate]
        assert state.stamp_ns - states[0].stamp_ns == seconds * 10**9
        deviation = np.sqrt(state.position_covariance[::4])
        assert deviation[:2] == pytest.approx([metres] * 2, rel=0.05)
        assert deviation[2] < 1.0


@pytest.mark.parametrize('method', ['trapezoid', 'euler'])
def test_one_degree_in_the_message_is_8_6_m_after_10_s(method):
    parts = pipeline({'method': method}, attitude='message')
    samples = [
        ImuSample(
            START_NS + k * 10**7,
            'imu_link',
            LEVEL,
            orientation=IDENTITY_QUATERNION,
            orientation_covariance=isotropic(DEGREE),
        )
        for k in range(1001)
    ]
    last = states_of(parts, samples)[-1]
    assert np.sqrt(last.position_covariance[::4])[:2] == pytest.approx([8.6] * 2, rel=0.05)


# Monte Carlo ----------------------------------------------------------------------------------

COUNT = 151
STEP = 0.02
TIME = np.arange(COUNT) * STEP
ACCELERATION = np.transpose(
    [2.0 * np.sin(3.0 * TIME), 1.5 * np.cos(2.0 * TIME), np.sin(4.0 * TIME)]
)
END_VELOCITY = np.array(
    [
        2.0 / 3.0 * (1.0 - math.cos(3.0 * TIME[-1])),
        0.75 * math.sin(2.0 * TIME[-1]),
        0.25 * (1.0 - math.cos(4.0 * TIME[-1])),
    ]
)
END_POSITION = np.array(
    [
        2.0 / 3.0 * (TIME[-1] - math.sin(3.0 * TIME[-1]) / 3.0),
        0.375 * (1.0 - math.cos(2.0 * TIME[-1])),
        0.25 * (TIME[-1] - math.sin(4.0 * TIME[-1]) / 4.0),
    ]
)
ATTITUDES = [
    quaternion_from_euler(0.3 * math.sin(t), 0.4 * math.sin(0.7 * t + 1.0), 0.8 * t) for t in TIME
]
ROTATIONS = [array(matrix_from_quaternion(quaternion)) for quaternion in ATTITUDES]
_root = np.array([[1.0, 0.0, 0.0], [0.5, 0.6, 0.0], [-0.3, 0.4, 2.0]]) * DEGREE
TILT = tuple((_root @ _root.T).ravel().tolist())
OFFSET, NOISE = 0.03, 0.2


def turned(turn, quaternion):
    """Turn an attitude by a small rotation vector about the axes of the world."""
    angle = np.linalg.norm(turn)
    x, y, z = np.sin(angle / 2.0) * turn / angle
    w = math.cos(angle / 2.0)
    qx, qy, qz, qw = quaternion
    return (
        w * qx + x * qw + y * qz - z * qy,
        w * qy - x * qz + y * qw + z * qx,
        w * qz + x * qy - y * qx + z * qw,
        w * qw - x * qx - y * qy - z * qz,
    )


def travelled(turn, offset, shakes):
    """Run a moving, turning body through the chain with one set of errors; return the states."""
    parts = pipeline(
        {'window_minimum': 0.0, 'window_maximum': 0.0, 'offset_deviation': OFFSET}, 'message'
    )
    samples = []
    for k in range(COUNT):
        force = ROTATIONS[k].T @ (ACCELERATION[k] + LEVEL) + offset + shakes[k]
        samples.append(
            ImuSample(
                START_NS + round(TIME[k] * 1e9),
                'imu_link',
                tuple(force.tolist()),
                isotropic(NOISE),
                orientation=turned(turn, ATTITUDES[k]),
                orientation_covariance=TILT,
            )
        )
    return states_of(parts, samples)


@pytest.fixture(scope='module')
def trials():
    """Return, of 300 runs, the end states."""
    random = np.random.default_rng(11)
    return [
        travelled(
            random.multivariate_normal(np.zeros(3), array(TILT)),
            random.normal(0.0, OFFSET, 3),
            random.normal(0.0, NOISE, (COUNT, 3)),
        )[-1]
        for _ in range(300)
    ]


@pytest.mark.parametrize(
    ('quantity', 'truth'), [('position', END_POSITION), ('velocity', END_VELOCITY)]
)
def test_error_is_as_large_as_the_covariance_says(trials, quantity, truth):
    errors = np.array([getattr(state, quantity) for state in trials]) - truth
    covariances = [array(getattr(state, f'{quantity}_covariance')) for state in trials]
    nees = [
        error @ np.linalg.solve(c, error) for error, c in zip(errors, covariances, strict=True)
    ]
    assert np.mean(nees) / 3.0 == pytest.approx(1.0, abs=0.15)
    ratios = errors / np.sqrt([np.diag(c) for c in covariances])
    assert np.sqrt((ratios**2).mean(axis=0)) == pytest.approx([1.0] * 3, abs=0.15)
    assert ratios.mean(axis=0) == pytest.approx([0.0] * 3, abs=0.2)


def test_covariance_stays_symmetric_and_positive():
    states = travelled(np.array([0.01, 0.0, 0.0]), np.zeros(3), np.zeros((COUNT, 3)))
    assert len(states) == COUNT
    for state in states:
        for covariance in (state.position_covariance, state.velocity_covariance):
            matrix = array(covariance)
            np.testing.assert_allclose(matrix, matrix.T, rtol=1e-12, atol=1e-15)
            assert np.linalg.eigvalsh(matrix).min() > 0.0
