"""One axis alone: the body carries its speed along as it turns, as on the mbed page."""

import math

import numpy as np
import pytest

from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import (
    matrix_from_quaternion,
    quaternion_from_euler,
    quaternion_from_matrix,
    yaw_from_quaternion,
)
from dead_reckoning.core.samples import (
    IDENTITY_QUATERNION,
    UNKNOWN,
    ImuSample,
    LinearAcceleration,
)
from dead_reckoning.sources import motions

START_NS = 1_700_000_000_000_000_000
DT = 0.01
BARE = {
    'window_minimum': 0.0,
    'window_maximum': 0.0,
    'movement_end': 'off',
    'heading_deviation': 0.0,
}
METHODS = ['trapezoid', 'euler']


def integrator(method='trapezoid', axes=('x',), common=None, **settings):
    return Integrator(
        IntegratorSettings(method=method, axes=axes, **(BARE | settings)),
        CommonSettings(**(common or {})),
    )


def run(estimator, accelerations, quaternions, dt=DT, attitude=UNKNOWN, noise=UNKNOWN):
    """Feed accelerations in the world, shape (n, 3), and n attitudes; return the states."""
    states = []
    for k, (acceleration, quaternion) in enumerate(zip(accelerations, quaternions, strict=True)):
        stamp_ns = START_NS + round(k * dt * 1e9)
        x, y, z = np.asarray(acceleration).tolist()
        imu = ImuSample(
            stamp_ns,
            'imu_link',
            (x, y, z + GRAVITY),
            noise,
            orientation=quaternion,
            orientation_covariance=attitude,
        )
        states.append(estimator.update(LinearAcceleration(stamp_ns, 'odom', (x, y, z)), imu))
    return states


def positions(states):
    return np.array([state.position for state in states])


def velocities(states):
    return np.array([state.velocity for state in states])


def yaws(angles):
    return [quaternion_from_euler(0.0, 0.0, float(angle)) for angle in angles]


def driven(rate, seconds=None, **settings):
    """Return truth and attitudes of the figure of eight, with time steps of 1/rate."""
    motion = motions.motion_class('vehicle')
    motion = motion(motion.Settings(**settings))
    time = np.arange(0.0, seconds or motion.duration + 2.0, 1.0 / rate)
    truth = motion.at(time)
    attitudes = [quaternion_from_matrix(tuple(r.ravel().tolist())) for r in truth.rotation]
    return truth, attitudes


# Following a curve ------------------------------------------------------------------------------


@pytest.mark.parametrize('method', METHODS)
def test_curve_of_a_vehicle_is_followed(method):
    """244 m in curves, 8.5 m/s at most: 0.1 % of the way with the default window and check."""
    truth, attitudes = driven(100)
    estimator = integrator(method, window_minimum=-0.05, window_maximum=0.05, movement_end='all')
    states = run(estimator, truth.acceleration, attitudes)
    error = np.linalg.norm(positions(states) - truth.position, axis=1)
    way = np.linalg.norm(truth.velocity, axis=1).sum() * DT
    assert way == pytest.approx(243.9, abs=0.1)
    assert error.max() < 0.1
    assert states[-1].stationary


@pytest.mark.parametrize(('method', 'order'), [('trapezoid', 2), ('euler', 1)])
def test_error_falls_with_the_order_of_the_method(method, order):
    errors = []
    for rate in (25, 50, 100):
        truth, attitudes = driven(rate, 12.0)
        states = run(integrator(method), truth.acceleration, attitudes, 1.0 / rate)
        errors.append(np.linalg.norm(positions(states)[-1] - truth.position[-1]))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert ratios == pytest.approx([2.0**order] * 2, rel=0.1)


@pytest.mark.parametrize('method', METHODS)
def test_speed_goes_on_round_a_circle(method):
    """Pushed to 1 m/s within a second, then a circle of 1 m radius without any push."""
    time = DT * np.arange(1100)
    angles = np.maximum(0.0, time - 1.0)
    push = np.where(time < 1.0 - DT / 2, 1.0, 0.0)
    accelerations = push[:, np.newaxis] * [1.0, 0.0, 0.0]
    states = run(integrator(method), accelerations, yaws(angles))
    ahead = np.transpose([np.cos(angles), np.sin(angles), np.zeros(1100)])
    np.testing.assert_allclose(velocities(states)[100:], ahead[100:], atol=0.006)
    centre = positions(states)[100] + [0.0, 1.0, 0.0]
    radius = np.linalg.norm(positions(states)[100:] - centre, axis=1)
    assert radius == pytest.approx(np.ones(1000), abs=0.02)


@pytest.mark.parametrize('method', METHODS)
def test_what_pushes_sideways_moves_nothing(method):
    """In a curve the centripetal acceleration is real, and no change of speed."""
    truth, attitudes = driven(100, 10.0)
    along = np.einsum('nij,nj->ni', truth.rotation.transpose(0, 2, 1), truth.acceleration)
    along[:, 1:] = 0.0
    pushed = np.einsum('nij,nj->ni', truth.rotation, along)
    with_all = run(integrator(method), truth.acceleration, attitudes)
    with_one = run(integrator(method), pushed, attitudes)
    np.testing.assert_allclose(positions(with_all), positions(with_one), atol=1e-9)


@pytest.mark.parametrize('method', METHODS)
@pytest.mark.parametrize('axis', ['x', 'y', 'z'])
def test_constant_heading_equals_the_free_integration(method, axis):
    """With an attitude that stays, carried along or not is the same."""
    random = np.random.default_rng(3)
    quaternion = quaternion_from_euler(0.2, -0.4, 2.0)
    rotation = np.reshape(matrix_from_quaternion(quaternion), (3, 3))
    pushes = np.zeros((300, 3))
    pushes[:, 'xyz'.index(axis)] = random.normal(0.0, 1.0, 300)
    pushes[100:140] = 0.01
    settings = {'window_minimum': -0.05, 'window_maximum': 0.05, 'movement_end': 'all'}
    alone = run(integrator(method, (axis,), **settings), pushes @ rotation.T, [quaternion] * 300)
    free = run(
        integrator(method, ('x', 'y', 'z'), **settings), pushes @ rotation.T, [quaternion] * 300
    )
    np.testing.assert_allclose(positions(alone), positions(free), atol=1e-12)
    np.testing.assert_allclose(velocities(alone), velocities(free), atol=1e-12)
    assert [s.stationary for s in alone] == [s.stationary for s in free]


@pytest.mark.parametrize('method', METHODS)
def test_two_axes_carry_nothing_along(method):
    """A mouse slides sideways as well as ahead: turning it turns no velocity."""
    accelerations = np.zeros((300, 3))
    accelerations[:100, 0] = 1.0
    angles = np.linspace(0.0, 2.0, 300)
    states = run(integrator(method, ('x', 'y')), accelerations, yaws(angles))
    assert velocities(states)[-1] == pytest.approx(velocities(states)[101], abs=1e-12)


@pytest.mark.parametrize('method', METHODS)
def test_turning_the_world_turns_the_path_and_its_covariance(method):
    truth, attitudes = driven(50, 12.0)
    rot_yaw = np.reshape(matrix_from_quaternion(yaws([0.7])[0]), (3, 3))
    turned = [
        quaternion_from_matrix(tuple((rot_yaw @ r).ravel().tolist())) for r in truth.rotation
    ]
    before = run(integrator(method), truth.acceleration, attitudes, 0.02)
    after = run(integrator(method), truth.acceleration @ rot_yaw.T, turned, 0.02)
    np.testing.assert_allclose(positions(after), positions(before) @ rot_yaw.T, atol=1e-9)
    for quantity in ('position_covariance', 'velocity_covariance'):
        plain, other = (np.reshape(getattr(s[-1], quantity), (3, 3)) for s in (before, after))
        np.testing.assert_allclose(other, rot_yaw @ plain @ rot_yaw.T, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize('method', METHODS)
def test_slope_is_climbed_as_the_attitude_says(method):
    """The axis points 10° up: the speed goes that way."""
    pitch = math.radians(-10.0)
    quaternion = quaternion_from_euler(0.0, pitch, 0.0)
    rotation = np.reshape(matrix_from_quaternion(quaternion), (3, 3))
    accelerations = np.tile(rotation @ [1.0, 0.0, 0.0], (101, 1))
    last = run(integrator(method), accelerations, [quaternion] * 101)[-1]
    expected = np.array([math.cos(pitch), 0.0, -math.sin(pitch)])
    assert np.array(last.velocity) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize('method', METHODS)
def test_velocity_turns_with_the_body_over_a_gap(method):
    estimator = integrator(method)
    run(estimator, [[1.0, 0.0, 0.0]] * 101, [IDENTITY_QUATERNION] * 101)
    stamp_ns = START_NS + 10_000_000_000
    (quaternion,) = yaws([math.pi / 2])
    imu = ImuSample(stamp_ns, 'imu_link', (0.0, 0.0, GRAVITY), orientation=quaternion)
    state = estimator.update(LinearAcceleration(stamp_ns, 'odom', (0.0, 0.0, 0.0)), imu)
    assert state.velocity == pytest.approx((0.0, 1.0, 0.0), abs=1e-9)
    assert state.position[0] == pytest.approx(0.5, abs=0.01)
    assert estimator.gaps == 1


# Covariance -----------------------------------------------------------------------------------


def only_yaw(deviation):
    return (*UNKNOWN[:8], deviation**2)


QUIET = {'noise_deviation': 0.0}
SURE = (1e-12, 0.0, 0.0, 0.0, 1e-12, 0.0, 0.0, 0.0, 1e-12)


@pytest.mark.parametrize('method', METHODS)
def test_heading_error_times_distance(method):
    """Half a metre a second along x for 100 s, heading known to 0.02 rad: 1 m to the side."""
    accelerations = np.zeros((10_101, 3))
    accelerations[:101, 0] = 0.5 / 1.005
    states = run(
        integrator(method, offset_deviation=0.0, scale_deviation=0.0, common=QUIET),
        accelerations,
        [IDENTITY_QUATERNION] * 10_101,
        attitude=only_yaw(0.02),
    )
    last = states[-1]
    assert last.position[0] == pytest.approx(50.25, abs=0.3)
    deviations = np.sqrt(last.position_covariance[::4])
    assert deviations[1] == pytest.approx(0.02 * last.position[0], rel=1e-3)
    assert deviations[[0, 2]] == pytest.approx([0.0, 0.0], abs=1e-4)
    assert np.sqrt(last.velocity_covariance[4]) == pytest.approx(0.02 * 0.5, rel=0.01)


@pytest.mark.parametrize('method', METHODS)
def test_one_heading_error_cancels_where_the_way_closes(method):
    """A constant turn of the compass turns the whole path: back at the start it is no error."""
    truth, attitudes = driven(100)
    states = run(
        integrator(method, offset_deviation=0.0, scale_deviation=0.0, common=QUIET),
        truth.acceleration,
        attitudes,
        attitude=only_yaw(0.1),
    )
    for state in states[::500]:
        x, y, _ = state.position
        deviations = np.sqrt(np.array(state.position_covariance)[::4])
        assert deviations[:2] == pytest.approx([0.1 * abs(y), 0.1 * abs(x)], abs=0.03)


@pytest.mark.parametrize('method', METHODS)
def test_heading_error_that_changes_with_the_heading_does_not_cancel(method):
    truth, attitudes = driven(100, 80.0)
    known = {'offset_deviation': 0.0, 'scale_deviation': 0.0, 'heading_deviation': 0.04}
    states = run(
        integrator(method, common=QUIET, **known), truth.acceleration, attitudes, attitude=SURE
    )
    home = np.linalg.norm(truth.position[4000:6000], axis=1).argmin() + 4000
    deviations = np.sqrt(np.array(states[home].position_covariance)[::4])
    assert (deviations[:2] > 0.2).all()
    assert (deviations[:2] < 0.04 * 122.0).all()
    assert deviations[2] < 0.01


def test_iron_near_the_compass_errs_as_the_covariance_says():
    """Iron of its own in each of 40 drives, two rounds: what it bends all along adds up."""
    truth, attitudes = driven(10, 50.0, start=1.0, loop_time=20.0, length=20.0, width=10.0)
    yaw = np.array([yaw_from_quaternion(quaternion) for quaternion in attitudes])
    known = {'offset_deviation': 0.0, 'scale_deviation': 0.0, 'heading_deviation': 0.04}
    random = np.random.default_rng(4)
    off, said = [], []
    for x, y in random.normal(0.0, 0.04, (40, 2)):
        turn = x * np.cos(yaw) + y * np.sin(yaw)
        accel_x, accel_y, _ = truth.acceleration.T
        bent = np.column_stack(
            [
                np.cos(turn) * accel_x - np.sin(turn) * accel_y,
                np.sin(turn) * accel_x + np.cos(turn) * accel_y,
                np.zeros(len(turn)),
            ]
        )
        estimator = integrator(common=QUIET, **known)
        states = run(estimator, bent, yaws(yaw + turn), dt=0.1, attitude=only_yaw(0.04))
        off.append(np.subtract(states[-1].position, truth.position[-1])[:2])
        said.append(np.sqrt(np.array(states[-1].position_covariance)[[0, 4]]))
    ratio = np.sqrt(np.mean((np.array(off) / said) ** 2, axis=0))
    assert (ratio > 0.5).all()
    assert (ratio < 1.25).all()


@pytest.mark.parametrize('method', METHODS)
def test_at_rest_it_grows_as_half_g_sigma_t_squared_along_the_axis(method):
    degree = math.radians(1.0)
    states = run(
        integrator(
            method,
            offset_deviation=0.0,
            scale_deviation=0.0,
            common=QUIET | {'attitude_deviation': degree},
        ),
        np.zeros((1001, 3)),
        yaws([math.pi / 2] * 1001),
    )
    deviations = np.sqrt(states[-1].position_covariance[::4])
    assert deviations[1] == pytest.approx(0.5 * GRAVITY * degree * 100.0, rel=1e-3)
    assert deviations[[0, 2]] == pytest.approx([0.0, 0.0], abs=1e-4)


def turned(turn, quaternion):
    """Turn an attitude by a small rotation vector about the axes of the world."""
    angle = np.linalg.norm(turn)
    (x, y, z), w = np.sin(angle / 2.0) * turn / angle, math.cos(angle / 2.0)
    qx, qy, qz, qw = quaternion
    return (
        w * qx + x * qw + y * qz - z * qy,
        w * qy - x * qz + y * qw + z * qx,
        w * qz + x * qy - y * qx + z * qw,
        w * qw - x * qx - y * qy - z * qz,
    )


TILT, YAW, OFFSET, NOISE = 0.003, 0.03, 0.02, 0.1
ATTITUDE = (TILT**2, 0.0, 0.0, 0.0, TILT**2, 0.0, 0.0, 0.0, YAW**2)
SHAKE = (NOISE**2, 0.0, 0.0, 0.0, NOISE**2, 0.0, 0.0, 0.0, NOISE**2)


def one_drive(method, truth, attitudes, random, dt):
    """Return the states of a drive with drawn errors of attitude, offset and noise."""
    turn = random.normal(0.0, [TILT, TILT, YAW])
    offset = random.normal(0.0, OFFSET, 3)
    estimator = integrator(method, offset_deviation=OFFSET)
    states = []
    for k, quaternion in enumerate(attitudes):
        rotation = truth.rotation[k]
        force_s = rotation.T @ (truth.acceleration[k] + [0.0, 0.0, GRAVITY])
        force_s += offset + random.normal(0.0, NOISE, 3)
        wrong = turned(turn, quaternion)
        accel_w = np.reshape(matrix_from_quaternion(wrong), (3, 3)) @ force_s
        stamp_ns = START_NS + round(k * dt * 1e9)
        x, y, z = accel_w.tolist()
        imu = ImuSample(
            stamp_ns,
            'imu_link',
            tuple(force_s.tolist()),
            SHAKE,
            orientation=wrong,
            orientation_covariance=ATTITUDE,
        )
        acceleration = LinearAcceleration(stamp_ns, 'odom', (x, y, z - GRAVITY))
        states.append(estimator.update(acceleration, imu))
    return states


@pytest.mark.parametrize('method', METHODS)
def test_error_is_as_large_as_the_covariance_says(method):
    """A drive round a curve, seen on the way and at its end; 150 draws of all errors."""
    truth, attitudes = driven(25, 12.0, start=1.0, loop_time=30.0, length=20.0, width=10.0)
    random = np.random.default_rng(12)
    nees = {('position', 150): [], ('velocity', 150): [], ('position', 299): []}
    for _ in range(150):
        states = one_drive(method, truth, attitudes, random, 0.04)
        for (quantity, at), values in nees.items():
            error = np.array(getattr(states[at], quantity)) - getattr(truth, quantity)[at]
            covariance = np.reshape(getattr(states[at], f'{quantity}_covariance'), (3, 3))
            values.append(error[:2] @ np.linalg.solve(covariance[:2, :2], error[:2]))
    for values in nees.values():
        assert np.mean(values) / 2.0 == pytest.approx(1.0, abs=0.25)
