"""What is known at rest, update by update, against what it says in docs/navigation.md."""

from contextlib import suppress

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_walks import START_NS, UP, filtered, navigator, walk

from dead_reckoning.core.errors import NotLevelledError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.rotation import composed, quaternion_from_turn
from dead_reckoning.core.samples import ImuSample
from dead_reckoning.tools.presets import values_of

DT = 0.005
REST = walk(strides=1).block()


def aligned(**settings):
    """Return a navigator that has just aligned, without a detector that looks ahead."""
    found = navigator(look_ahead=0.0, **settings)
    for index in range(101):
        try:
            found.update(REST.sample(index))
        except NotLevelledError:
            assert not found.aligned
    return found


def take(found, count, rests=True, statistic=0.0, rate=(0.0, 0.0, 0.0), force=None):
    """Let the filter take samples at rest; return its states."""
    rows = np.zeros((count, layout.ROW))
    rows[:, 0], rows[:, 1:4], rows[:, 4:7] = DT, REST.specific_force[0], rate
    if force is not None:
        rows[:, 1:4] = force
    verdicts = np.tile([statistic, 1.0, float(rests)], (count, 1))
    return filtered(found._rules, found._state, rows, verdicts)[0]


def covariance(found):
    return found._state[layout.COVARIANCE : layout.COVARIANCE + 256].reshape(16, 16)


@pytest.mark.parametrize('seconds', [1.0, 4.0])
@pytest.mark.parametrize('dt', [DT, 2.0 * DT])
def test_a_rest_bounds_the_angle(seconds, dt):
    """Information on the bias about the vertical is T²/(2 σ_s²), whatever the rate of samples."""
    sway, prior = 1e-3, 0.05
    found = aligned(sway=sway, rate_bias=prior, rate_noise=1e-9, rate_walk=0.0, still_window=0.05)
    up = Rotation.from_quat(found._state[13:17]).inv().apply([0.0, 0.0, 1.0])
    rests = found.counts['zero_rate'] * DT
    rows = round(seconds / dt)
    samples = np.zeros((rows, layout.ROW))
    samples[:, 0], samples[:, 1:4] = dt, REST.specific_force[0]
    filtered(found._rules, found._state, samples, np.tile([0.0, 1.0, 1.0], (rows, 1)))
    age = rests + seconds + 0.05
    expected = 1.0 / (1.0 / prior**2 + (age**2 - 0.05**2) / (2.0 * sway**2))
    found_variance = up @ covariance(found)[9:12, 9:12] @ up
    assert found_variance == pytest.approx(expected, rel=0.03)


def test_a_rest_shows_the_bias():
    found = aligned()
    bias = np.array([0.004, -0.002, 0.003])
    take(found, 1000, rate=bias)
    np.testing.assert_allclose(found._state[6:9], bias, atol=5e-4)


def test_a_tilt_and_a_bias_that_hide_each_other_do_not_carry_the_position_away():
    """After a minute of rest the ways along the floor are as sure as the height."""
    found = aligned()
    take(found, round(60.0 / DT))
    p = covariance(found)
    assert p[12, 12] > 0.4**2  # the bias is as unknown as it was
    np.testing.assert_allclose(np.diag(p)[:2], p[2, 2], rtol=0.05)
    assert np.abs(p[:3, 12:15]).max() < 0.01 * np.sqrt(p[2, 2] * p[12, 12])


def test_a_turning_stance_shows_none():
    found = aligned()
    before = found.counts['zero_rate']
    turning = 0.03 * np.sin(np.arange(400) * 0.05)[:, None] * [1.0, 0.0, 1.0]
    take(found, 400, rate=turning)
    assert found.counts['zero_rate'] < before + 40


def test_a_velocity_beyond_the_gate_is_refused_until_patience_ends():
    found = aligned(patience=0.1)
    take(found, 200)
    before = found.counts
    found._state[3:6] = [3.0, -4.0, 0.0]
    out = take(found, 15)
    assert found.counts['zero_velocity'] == before['zero_velocity']
    assert found.counts['zero_velocity_refused'] == before['zero_velocity_refused'] + 15
    assert np.linalg.norm(out[-1, 3:6]) == pytest.approx(5.0, rel=1e-3)
    take(found, 30)
    assert found.counts['zero_velocity'] > before['zero_velocity']
    take(found, 200)
    believed = found.counts['zero_velocity']
    found._state[3:6] = [3.0, -4.0, 0.0]
    take(found, 15)  # its patience is whole again
    assert found.counts['zero_velocity'] == believed


def test_a_rolling_foot_moves_with_its_height_above_the_pivot():
    found = aligned(height=0.2, pivot=0.0, stance_velocity=1e-4, gate=1e9, acceleration_bias=0.0)
    body = Rotation.from_quat(found._state[13:17])
    turning_w = np.array([0.0, 0.5, 0.0])
    out = take(found, 1, statistic=0.5, rate=body.inv().apply(turning_w))
    assert out[0, 3] == pytest.approx(0.5 * 0.2, rel=0.02)  # pitching down goes ahead


def test_a_stance_counts_the_same_at_any_rate_of_samples():
    """The error of the velocity is a density: two samples of half the step say as much."""
    spreads = []
    for dt in (DT, 0.5 * DT):
        found = aligned(stance_velocity=0.05, acceleration_noise=0.01)
        covariance(found)[:] = np.diag(np.full(16, 1e-12))
        covariance(found)[3:6, 3:6] = np.eye(3)
        rows = round(0.1 / dt)
        samples = np.zeros((rows, layout.ROW))
        samples[:, 0], samples[:, 1:4] = dt, REST.specific_force[0]
        filtered(found._rules, found._state, samples, np.tile([0.0, 1.0, 1.0], (rows, 1)))
        spreads.append(covariance(found)[3, 3])
    assert spreads[0] == pytest.approx(0.05**2 * 0.15 / 0.1, rel=0.05)
    assert spreads[1] == pytest.approx(spreads[0], rel=0.05)


BIAS = np.array([0.005, -0.006, 0.004])
HELD = {
    name.removeprefix('navigator.'): value
    for name, value in values_of('inertial').items()
    if name.startswith('navigator.')
}


def held(turning, askew, seed=0, **settings):
    """Return errors of the inclination and their sigmas [°], and the navigator at the end.

    For a minute, after a rest, a body is shaken and turned at random, ``turning`` rad/s an axis;
    its gyro has a bias, and ``askew`` of the rate is wrong, shape (3, 3).
    """
    time = np.arange(0.0, 62.0, 0.01)
    swing = np.clip(time - 2.0, 0.0, 1.0)[:, None]
    knots = np.arange(0.0, 63.0, 0.5)
    drawn = np.random.default_rng(seed).normal(0.0, turning, (3, len(knots)))
    rate = swing * np.stack([np.interp(time - 0.005, knots, axis) for axis in drawn], axis=1)
    attitudes = [(0.0, 0.0, 0.0, 1.0)]
    for turn in (0.01 * rate[1:]).tolist():
        attitudes.append(composed(attitudes[-1], quaternion_from_turn(tuple(turn))))
    attitude = Rotation.from_quat(attitudes)
    shaken = swing * np.sin(time[:, None] * [6.0, 7.0, 9.0]) * [2.0, -1.5, 1.0]
    force = attitude.inv().apply(shaken + UP)
    rate = rate + rate @ np.transpose(askew) + BIAS
    found = navigator(**{**HELD, **settings})
    states = []
    for k in range(len(time)):
        imu = ImuSample(
            START_NS + k * 10_000_000,
            'imu_link',
            tuple(force[k].tolist()),
            angular_velocity=tuple(rate[k].tolist()),
        )
        with suppress(NotLevelledError):
            states += found.update(imu)
    states = states[1000:]
    found_s = Rotation.from_quat([s.attitude for s in states]).inv().apply([0.0, 0.0, 1.0])
    true_s = attitude[-len(states) :].inv().apply([0.0, 0.0, 1.0])
    errors = np.arcsin(np.linalg.norm(np.cross(found_s, true_s), axis=1))
    variances = [s.attitude_covariance[0] + s.attitude_covariance[4] for s in states]
    return np.degrees(errors), np.degrees(np.sqrt(variances)), found


def test_a_held_body_keeps_its_inclination():
    """A bound of the velocity is what points to the vertical."""
    errors, _, found = held(0.5, np.zeros((3, 3)))
    assert np.sqrt(np.mean(errors**2)) < 0.3
    np.testing.assert_allclose(found._state[6:8], BIAS[:2], atol=1e-3)


@pytest.mark.parametrize('turning', [0.5, 6.0])
def test_a_gyro_whose_scale_and_axes_are_wrong_knows_how_wrong_it_is(turning):
    """Errors of 0.25 % of the rate are drawn."""

    def ratio(**settings):
        random = np.random.default_rng(3)
        runs = [held(turning, random.normal(0.0, 0.0025, (3, 3)), i, **settings) for i in range(4)]
        return np.sqrt(np.mean([(errors / sigmas) ** 2 for errors, sigmas, _ in runs]))

    assert 0.3 < ratio() < 1.6
    if turning > 1.0:
        assert ratio(rate_scale=0.0) > 5.0


def fresh(found):
    """Let the navigator forget how still the sensor was; return the samples of its window."""
    found._state[layout.STILL_COUNT], found._state[layout.NOISE] = 0.0, -1.0
    found._state[layout.HELD] = 0.0
    return round(0.4 / DT)


def test_rest_is_known_from_a_whole_window_and_taken_from_its_middle():
    found = aligned()
    window = fresh(found)
    before = found.counts['zero_rate']
    rates = np.random.default_rng(0).normal(0.0, 1e-3, (window, 3))
    take(found, window - 1, rate=rates[:-1])
    assert found.counts['zero_rate'] == before
    row = np.array([[DT, *REST.specific_force[0], *rates[-1], 0.0]])
    bias = found._state[6:9].copy()
    _, _, log = filtered(found._rules, found._state, row, np.array([[0.0, 1.0, 1.0]]))
    assert found.counts['zero_rate'] == before + 1
    measured = log[log[:, 3 + layout.ERRORS + layout.RATE_BIAS :][:, :3].any(axis=1)]
    assert len(measured) == 3
    np.testing.assert_allclose(measured[:, 2], rates[window // 2] - bias, atol=2e-5)


def test_the_noise_of_the_sensor_is_no_motion():
    found = aligned()
    random = np.random.default_rng(1)
    noisy = random.normal(0.0, 0.007, (2000, 3))  # above still_deviation
    window = fresh(found)
    before = found.counts['zero_rate']
    take(found, 2000, rate=noisy)
    assert found.counts['zero_rate'] == before + 2000 - window + 1
    take(found, 400, rate=3.0 * random.normal(0.0, 0.007, (400, 3)))
    assert found.counts['zero_rate'] < before + 2000 + 40


def test_biases_wander_over_a_gap_as_over_samples():
    found = aligned(rate_walk=1e-3, acceleration_walk=2e-3)
    before = np.diag(covariance(found)).copy()
    row = np.array([[50.0, *REST.specific_force[0], 0.0, 0.0, 0.0, 0.0]])
    filtered(found._rules, found._state, row, np.zeros((1, 3)))
    grown = np.diag(covariance(found)) - before
    np.testing.assert_allclose(grown[9:12], 50.0 * 1e-3**2, rtol=1e-6)
    np.testing.assert_allclose(grown[12:15], 50.0 * 2e-3**2, rtol=1e-6)


def test_after_a_gap_the_window_fills_anew():
    found = aligned()
    take(found, 100)
    before = found.counts['zero_rate']
    row = np.array([[2.0, *REST.specific_force[0], 0.0, 0.0, 0.0, 0.0]])
    filtered(found._rules, found._state, row, np.array([[0.0, 1.0, 1.0]]))
    take(found, 78)  # with the sample after the gap one less than the window
    assert found.counts['zero_rate'] == before
    take(found, 1)
    assert found.counts['zero_rate'] == before + 1
