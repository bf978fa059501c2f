"""The Kalman filter: what it shares with the open loop, what rest teaches it, its consistency."""

import builtins
import dataclasses
import math
import subprocess
import sys

import numpy as np
import pytest

from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import DependencyError, NotFiniteError
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import (
    isotropic,
    matrix_from_quaternion,
    quaternion_from_euler,
)
from dead_reckoning.core.samples import (
    IDENTITY_QUATERNION,
    UNKNOWN,
    ImuSample,
    LinearAcceleration,
)
from dead_reckoning.sources import motions
from dead_reckoning.sources.paths import Path

START_NS = 1_700_000_000_000_000_000
DT = 0.01
BARE = {'window_minimum': 0.0, 'window_maximum': 0.0, 'movement_end': 'off'}
SUBSETS = [('x', 'y', 'z'), ('x', 'y'), ('z', 'x'), ('y',)]


def integrator(method='kalman', common=None, **settings):
    return Integrator(
        IntegratorSettings(method=method, **settings), CommonSettings(**(common or {}))
    )


def pair(stamp_ns, acceleration, quaternion=IDENTITY_QUATERNION, attitude=UNKNOWN, noise=UNKNOWN):
    x, y, z = acceleration
    force = (x, y, z + GRAVITY)
    imu = ImuSample(
        stamp_ns,
        'imu_link',
        force,
        noise,
        orientation=quaternion,
        orientation_covariance=attitude,
    )
    return LinearAcceleration(stamp_ns, 'odom', (x, y, z)), imu


def run(estimator, accelerations, quaternions=None, start_ns=START_NS, dt=DT, **given):
    """Feed accelerations, shape (n, 3) or along x (n,); return the states."""
    accelerations = np.asarray(accelerations, dtype=float)
    if accelerations.ndim == 1:
        accelerations = np.outer(accelerations, [1.0, 0.0, 0.0])
    if quaternions is None:
        quaternions = [IDENTITY_QUATERNION] * len(accelerations)
    return [
        estimator.update(*pair(start_ns + round(k * dt * 1e9), tuple(a), q, **given))
        for k, (a, q) in enumerate(zip(accelerations.tolist(), quaternions, strict=True))
    ]


def plain(states):
    return [dataclasses.astuple(state) for state in states]


def matrix(covariance):
    return np.reshape(covariance, (3, 3))


def positions(states):
    return np.array([state.position for state in states])


def velocities(states):
    return np.array([state.velocity for state in states])


def slide(distance=0.5, duration=1.0, rests=1.0, dt=DT):
    """Return the acceleration along x of a slide between two rests, shape (n,)."""
    path = Path([rests, rests + duration], [[0.0], [distance]])
    return path.at(np.arange(0.0, duration + 2.0 * rests, dt))[2][:, 0]


def wandering(count=300, seed=8):
    random = np.random.default_rng(seed)
    pushes = random.normal(0.0, 1.0, (count, 3))
    pushes[60:100] = pushes[200:240] = 0.01
    return pushes


def waving(count):
    return [quaternion_from_euler(0.2 * math.sin(k / 50), 0.1, k / 100) for k in range(count)]


# Without rests it is the open loop -------------------------------------------------------------


@pytest.mark.parametrize('axes', SUBSETS, ids=''.join)
def test_without_zero_velocity_updates_it_is_the_trapezoid_and_its_covariance(axes):
    """Prior, Jacobians and noise are the same; only rests teach it anything."""
    tilt = (0.01, 0.002, 0.0, 0.002, 0.02, 0.0, 0.0, 0.0, 0.1)
    states = [
        run(
            integrator(method, axes=axes, bias_walk=0.0, **BARE),
            wandering(),
            waving(300),
            attitude=tilt,
            noise=isotropic(0.001),
        )
        for method in ('trapezoid', 'kalman')
    ]
    for open_loop, kalman in zip(*states, strict=True):
        assert kalman.position == pytest.approx(open_loop.position, abs=1e-9)
        assert kalman.velocity == pytest.approx(open_loop.velocity, abs=1e-9)
        for quantity in ('position_covariance', 'velocity_covariance'):
            expected = np.array(getattr(open_loop, quantity))
            atol = 1e-3 * np.abs(expected).max() + 1e-9
            np.testing.assert_allclose(getattr(kalman, quantity), expected, atol=atol)


def test_gap_is_that_of_the_open_loop():
    states = []
    for method in ('trapezoid', 'kalman'):
        estimator = integrator(method, bias_walk=0.0, **BARE)
        run(estimator, np.ones(101))
        states.append(estimator.update(*pair(START_NS + 4_000_000_000, (1.0, 0.0, 0.0))))
        assert estimator.gaps == 1
    open_loop, kalman = states
    assert kalman.position == pytest.approx(open_loop.position, abs=1e-12)
    assert kalman.velocity == pytest.approx(open_loop.velocity, abs=1e-12)
    for quantity in ('position_covariance', 'velocity_covariance'):
        expected = np.array(getattr(open_loop, quantity))
        np.testing.assert_allclose(getattr(kalman, quantity), expected, rtol=1e-3, atol=1e-6)


def test_one_axis_follows_a_curve():
    motion = motions.motion_class('vehicle')
    motion = motion(motion.Settings())
    truth = motion.at(np.arange(0.0, 19.0, DT))
    yaws = [quaternion_from_euler(0.0, 0.0, yaw) for yaw in truth.euler[:, 2]]
    states = run(integrator(axes=('x',)), truth.acceleration, yaws)
    error = np.linalg.norm(positions(states) - truth.position, axis=1)
    assert np.linalg.norm(truth.position, axis=1).max() > 15.0
    assert error.max() < 0.1
    assert states[-1].stationary


# What rest teaches -----------------------------------------------------------------------------


def test_rest_makes_the_velocity_known():
    states = run(integrator(), slide())
    rests = [k for k, state in enumerate(states) if state.stationary]
    assert rests == [*range(24, 103), *range(224, 300)]
    assert np.abs(velocities(states)[rests]).max() < 0.01
    assert np.sqrt([states[k].velocity_covariance[0] for k in rests]).max() < 0.01


def test_stop_that_nothing_explains_teaches_no_bias():
    """It ran on at 0.2 m/s and then stood: a shock, a clipped sample, a tilt on the way.

    The velocity is zero all the same, and the next slide is not spoilt.
    """
    accelerations = slide(rests=0.4)
    states = run(integrator(), np.concatenate((np.zeros(100), np.ones(20), np.zeros(100))))
    assert states[143].velocity[0] == pytest.approx(0.2, abs=0.02)
    assert np.abs(velocities(states)[150:]).max() < 0.005
    shocked = np.concatenate((np.zeros(100), np.ones(20), np.zeros(60), accelerations))
    states = run(integrator(), shocked)
    way = states[-1].position[0] - states[179].position[0]
    assert way == pytest.approx(0.5, abs=0.005)


def test_position_is_held_while_the_body_rests():
    random = np.random.default_rng(3)
    states = run(integrator(), random.normal(0.0, 0.01, (500, 3)))
    assert states[-1].stationary
    still = positions(states)[60:]
    assert np.abs(still - still[0]).max() < 1e-3
    assert np.sqrt(states[-1].position_covariance[::4]).max() < 0.02


def test_offset_is_learnt_at_rest_and_taken_off_in_motion():
    """0.03 m/s² hides in the window: the open loop is off by ½ b t², rest tells the filter."""
    accelerations = slide(duration=2.0, rests=3.0) + 0.03
    errors = {}
    for method in ('trapezoid', 'kalman'):
        last = run(integrator(method), accelerations)[-1]
        assert last.stationary
        errors[method] = abs(last.position[0] - 0.5)
    assert errors['trapezoid'] > 0.05
    assert errors['kalman'] < 0.005


def test_rest_after_the_motion_corrects_the_position():
    """The velocity left over at the end tells how far the same bias has carried the position."""
    accelerations = slide(duration=2.0, rests=0.3) + 0.03
    states = run(integrator(movement_end_samples=20), accelerations)
    ended = next(k for k in range(100, len(states)) if states[k].stationary)
    before, after = states[ended - 1], states[-1]
    assert abs(before.position[0] - 0.5) > 3.0 * abs(after.position[0] - 0.5)


def test_it_is_no_worse_than_the_trapezoid_after_a_slide():
    """Noise, counts and a bias as levelling leaves it; 20 seeds."""
    errors = {'trapezoid': [], 'kalman': []}
    for seed in range(20):
        random = np.random.default_rng(seed)
        bias = random.normal(0.0, 0.01, 3)
        accelerations = np.outer(slide(), [1.0, 0.0, 0.0])
        accelerations += bias + random.normal(0.0, 0.01, accelerations.shape)
        accelerations = np.round(accelerations / 0.01) * 0.01
        for method, found in errors.items():
            last = run(integrator(method, movement_end_samples=40), accelerations)[-1]
            found.append(np.linalg.norm(np.subtract(last.position, [0.5, 0.0, 0.0])))
    assert np.median(errors['kalman']) < np.median(errors['trapezoid'])
    assert max(errors['kalman']) < max(errors['trapezoid'])
    assert np.median(errors['kalman']) < 0.003


def test_each_axis_can_rest_alone():
    """The other one goes on, and keeps its velocity."""
    pushes = np.zeros((250, 3))
    pushes[:200, 0] = slide(rests=0.5)
    pushes[100:, 1] = 1.0
    quaternion = quaternion_from_euler(0.3, 0.2, 1.0)
    rotation = matrix(matrix_from_quaternion(quaternion))
    states = run(integrator(movement_end='each'), pushes @ rotation.T, [quaternion] * 250)
    velocity_s = velocities(states) @ rotation
    assert velocity_s[100, 0] == pytest.approx(0.94, abs=0.02)
    assert velocity_s[-50:, 0] == pytest.approx(np.zeros(50), abs=0.01)
    assert velocity_s[-1, 1] == pytest.approx(149.5 * DT, abs=0.03)
    assert not any(state.stationary for state in states[100:])


def test_heading_error_shows_no_rest_across_the_motion():
    """Sensor turned against the attitude it claims: across its own axis it rests all the same."""
    yaw = (*UNKNOWN[:8], 0.01)
    pushes = np.zeros((120, 3))
    pushes[:100, 0] = 1.0
    states = run(
        integrator(movement_end='each', axes=('x', 'y'), offset_deviation=0.0),
        pushes,
        attitude=yaw,
    )
    deviation = np.sqrt(states[-1].velocity_covariance[4])
    assert deviation == pytest.approx(0.1 * states[-1].velocity[0], rel=0.05)


def test_axes_that_do_not_move_are_held_at_zero():
    states = run(integrator(axes=('x', 'y')), np.tile([1.0, 2.0, 3.0], (50, 1)))
    assert states[-1].velocity == (pytest.approx(49 * DT), pytest.approx(98 * DT), 0.0)
    assert states[-1].position[2] == 0.0


# Consistency -----------------------------------------------------------------------------------

TILT, OFFSET, NOISE = math.radians(0.2), 0.02, 0.02
TIME = np.arange(0.0, 3.8, DT)
JOURNEY = Path(
    [0.7, 1.5, 2.0, 3.2],
    [[0.0, 0.0, 0.0], [0.5, -0.3, 0.2], [0.5, -0.3, 0.2], [-1.0, 1.0, 0.4]],
)
TRUTH = JOURNEY.at(TIME)
MOMENTS = {'end of the first leg': 150, 'in the second': 260, 'end of it': 320, 'at rest': 379}


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


def journey(random, turning):
    """Return errors (position, velocity) and their covariance, shape (6, 6), at the moments."""
    turn = random.normal(0.0, TILT, 3)
    offset = random.normal(0.0, OFFSET, 3)
    estimator = integrator(
        window_minimum=-0.25,
        window_maximum=0.25,
        offset_deviation=OFFSET,
        stationary_deviation=0.0005,
        scale_deviation=0.0,
        bias_walk=0.0,
    )
    seen = {}
    for k, time in enumerate(TIME):
        roll, yaw = (0.3 * math.sin(time), 1.5 * time) if turning else (0.1, 0.7)
        attitude = quaternion_from_euler(roll, 0.2, yaw)
        rotation = matrix(matrix_from_quaternion(attitude))
        force = rotation.T @ (TRUTH[2][k] + [0.0, 0.0, GRAVITY])
        force += offset + random.normal(0.0, NOISE, 3)
        wrong = turned(turn, attitude)
        accel_w = matrix(matrix_from_quaternion(wrong)) @ force - [0.0, 0.0, GRAVITY]
        stamp_ns = START_NS + round(time * 1e9)
        imu = ImuSample(
            stamp_ns,
            'imu_link',
            tuple(force.tolist()),
            isotropic(NOISE),
            orientation=wrong,
            orientation_covariance=isotropic(TILT),
        )
        state = estimator.update(LinearAcceleration(stamp_ns, 'odom', tuple(accel_w)), imu)
        for moment, at in MOMENTS.items():
            if k == at:
                error = np.subtract((state.position, state.velocity), (TRUTH[0][k], TRUTH[1][k]))
                seen[moment] = error.ravel(), estimator._integration._filter.P[:6, :6].copy()
    assert state.stationary
    return seen


def bounds(freedom, runs):
    """Return where the mean of that many χ² lies 95 % of the time (Wilson and Hilferty)."""
    n = 2.0 / (9.0 * freedom * runs)
    return [freedom * (1.0 - n + z * math.sqrt(n)) ** 3 for z in (-1.96, 1.96)]


@pytest.mark.parametrize('turning', [False, True])
def test_error_is_as_large_as_the_covariance_says(turning):
    """100 runs, all errors drawn from the prior: NEES within its 95 % bounds.

    At rest the velocity errs less than `stationary_deviation` allows for, so there the position
    alone is held against both bounds.
    """
    random = np.random.default_rng(21)
    runs = [journey(random, turning) for _ in range(100)]
    for moment in MOMENTS:
        size = 3 if moment == 'at rest' else 6
        nees = [
            e[:size] @ np.linalg.solve(p[:size, :size], e[:size])
            for e, p in (seen[moment] for seen in runs)
        ]
        low, high = bounds(size, 100)
        assert low < np.mean(nees) < high, moment
    velocity = [e[3:] @ np.linalg.solve(p[3:, 3:], e[3:]) for e, p in (s['at rest'] for s in runs)]
    assert np.mean(velocity) < 3.0


def test_covariance_stays_symmetric_and_positive():
    states = run(integrator(movement_end='each'), wandering(2000), waving(2000))
    for state in states:
        for covariance in (state.position_covariance, state.velocity_covariance):
            np.testing.assert_array_equal(matrix(covariance), matrix(covariance).T)
            assert np.linalg.eigvalsh(matrix(covariance)).min() > 0.0


def test_turning_the_world_turns_path_and_covariance():
    rot_yaw = matrix(matrix_from_quaternion(quaternion_from_euler(0.0, 0.0, 0.8)))
    cos, sin = math.cos(0.4), math.sin(0.4)
    quaternions = waving(300)
    after = [
        (cos * x - sin * y, cos * y + sin * x, cos * z + sin * w, cos * w - sin * z)
        for x, y, z, w in quaternions
    ]
    pushes = wandering()
    for movement_end in ('all', 'each'):
        first = run(integrator(movement_end=movement_end), pushes, quaternions)
        second = run(integrator(movement_end=movement_end), pushes @ rot_yaw.T, after)
        np.testing.assert_allclose(positions(second), positions(first) @ rot_yaw.T, atol=1e-9)
        before, rotated = (matrix(s[-1].position_covariance) for s in (first, second))
        np.testing.assert_allclose(rotated, rot_yaw @ before @ rot_yaw.T, atol=1e-9)


# The attitude's covariance changes -------------------------------------------------------------


def attitude_covariance(estimator):
    return np.diag(estimator._integration._filter.P)[6:9]


def test_attitude_error_is_known_as_the_messages_say():
    """Without rests the variance of θ is that of the last message, whatever came before."""
    estimator = integrator(**BARE)
    for k, deviation in enumerate([0.01, 0.02, 0.1, 0.1, 0.005, 0.03]):
        attitude = isotropic(deviation)
        estimator.update(*pair(START_NS + k * 10**7, (0.0, 0.0, 0.0), attitude=attitude))
        assert attitude_covariance(estimator) == pytest.approx([deviation**2] * 3)


def test_another_attitude_has_to_be_learnt_anew():
    estimator = integrator()
    run(estimator, np.zeros(300), attitude=isotropic(0.02))
    learnt = attitude_covariance(estimator)[0]
    assert learnt < 0.02**2 / 4.0
    later = START_NS + 300 * 10**7
    estimator.update(*pair(later, (0.0, 0.0, 0.0), attitude=isotropic(0.2)))
    assert attitude_covariance(estimator)[0] > 0.19**2
    estimator.update(*pair(later + 10**7, (0.0, 0.0, 0.0), attitude=isotropic(0.02)))
    assert attitude_covariance(estimator)[0] == pytest.approx(0.02**2, rel=0.1)


# The life of an estimator ----------------------------------------------------------------------


def test_first_sample_only_sets_the_start():
    (state,) = run(integrator(), [5.0])
    assert (state.position, state.velocity) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert not state.stationary


def test_stamps_that_go_back_far_start_all_over():
    estimator = integrator()
    run(estimator, wandering())
    again = run(estimator, wandering(), start_ns=START_NS - 10**10)
    assert plain(again) == plain(run(integrator(), wandering(), start_ns=START_NS - 10**10))


def test_reset_returns_to_the_origin_and_forgets_what_was_learnt():
    estimator = integrator()
    run(estimator, wandering())
    estimator.reset()
    again = run(estimator, wandering(), start_ns=START_NS + 10**10)
    assert plain(again) == plain(run(integrator(), wandering(), start_ns=START_NS + 10**10))


def test_refused_sample_leaves_no_trace():
    undisturbed, disturbed = integrator(), integrator()
    expected = plain(run(undisturbed, wandering()))
    states = run(disturbed, wandering()[:100])
    with pytest.raises(NotFiniteError):
        disturbed.update(*pair(START_NS + 10**9, (math.nan, 0.0, 0.0)))
    states += run(disturbed, wandering()[100:], start_ns=START_NS + 10**9)
    assert plain(states) == expected


def test_zero_deviations_are_no_division_by_zero():
    common = {'attitude_deviation': 0.0, 'noise_deviation': 0.0}
    settings = {'offset_deviation': 0.0, 'stationary_deviation': 0.0, 'bias_walk': 0.0}
    states = run(integrator(common=common, **settings), np.concatenate((np.ones(9), np.zeros(40))))
    assert states[-1].stationary
    assert np.isfinite(positions(states)).all()


def test_light_methods_do_not_import_filterpy():
    script = (
        'import sys\n'
        'from dead_reckoning.core.common import CommonSettings\n'
        'from dead_reckoning.core.integration.settings import IntegratorSettings\n'
        'from dead_reckoning.core.integrator import Integrator\n'
        "Integrator(IntegratorSettings(method='euler'), CommonSettings())\n"
        "assert 'filterpy' not in sys.modules\n"
        "Integrator(IntegratorSettings(method='kalman'), CommonSettings())\n"
        "assert 'filterpy' in sys.modules\n"
    )
    subprocess.run([sys.executable, '-c', script], check=True)


def test_missing_filterpy_is_said_with_the_remedy(monkeypatch):
    def without_filterpy(name, *rest, original=builtins.__import__):
        if name.startswith('filterpy'):
            raise ImportError(name)
        return original(name, *rest)

    monkeypatch.delitem(sys.modules, 'dead_reckoning.core.integration.kalman', raising=False)
    monkeypatch.setattr(builtins, '__import__', without_filterpy)
    with pytest.raises(DependencyError, match='pip install filterpy'):
        integrator()
