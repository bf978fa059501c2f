"""A window looks for rest; rest shows what is wrong with the input."""

import math

import numpy as np
import pytest

from dead_reckoning.core.errors import GravityError, MountingError, NotAtRestError
from dead_reckoning.core.rest import (
    GRAVITY,
    RestWindow,
    check_gravity,
    check_up_axis,
    level_variances,
)
from dead_reckoning.core.samples import UNKNOWN

STEP_NS = 10_000_000


def fill(window, vectors, start_ns=1, step_ns=STEP_NS):
    """Feed vectors until the window is full; return the rest and how many it took."""
    for index, vector in enumerate(vectors):
        rest = window.add(start_ns + index * step_ns, vector)
        if rest is not None:
            return rest, index + 1
    return None, len(vectors)


def test_mean_and_deviation_are_those_of_numpy():
    random = np.random.default_rng(1)
    vectors = random.normal([1.0, -2.0, 9.8], [0.01, 0.02, 0.03], (51, 3))
    rest, taken = fill(RestWindow(0.5, 1.0), [tuple(v) for v in vectors.tolist()])
    assert taken == rest.count == 51
    assert rest.mean == pytest.approx(vectors.mean(axis=0))
    assert rest.deviation == pytest.approx(vectors.std(axis=0))


def test_small_deviation_of_a_large_vector_is_not_lost_to_rounding():
    vectors = [(1e8 + (index % 2), 0.0, 0.0) for index in range(100)]
    rest, _ = fill(RestWindow(0.99, 1.0), vectors)
    assert rest.mean[0] == pytest.approx(1e8 + 0.5, abs=1e-6)
    assert rest.deviation[0] == pytest.approx(0.5)


def test_window_lasts_as_long_as_it_is_told():
    still = [(0.0, 0.0, GRAVITY)] * 100
    assert fill(RestWindow(0.5, 0.1), still)[1] == 51
    assert fill(RestWindow(0.25, 0.1), still)[1] == 26


def test_few_samples_are_no_rest_however_long_they_last():
    still = [(0.0, 0.0, GRAVITY)] * 10
    rest, taken = fill(RestWindow(0.5, 0.1), still, step_ns=10**9)
    assert taken == rest.count == 5


def independent(random, count):
    return random.normal(0.0, 0.1, count)


def alike(random, count, memory=0.8):
    """Return noise that resembles that of the samples before, for about ten of them."""
    value, values = 0.0, []
    for shake in random.normal(0.0, 0.1, count + 50):
        value = memory * value + shake
        values.append(value)
    return np.array(values[50:])


def tremor(random, count, waves=5):
    """Return what a hand does: waves between 6 and 12 Hz."""
    rates, phases = random.uniform(6.0, 12.0, waves), random.uniform(0.0, 2.0 * np.pi, waves)
    time = 0.01 * np.arange(count)[:, np.newaxis]
    return 0.1 * np.sin(2.0 * np.pi * rates * time + phases).sum(axis=1)


@pytest.mark.parametrize(
    ('process', 'low', 'high'),
    [(independent, 0.9, 1.1), (alike, 0.9, 1.3), (tremor, 0.55, 1.0)],
)
@pytest.mark.parametrize('count', [51, 201])
def test_mean_errs_as_its_covariance_says(process, low, high, count):
    """Noise at most as correlated as a window is long; other directions see other noise."""
    random = np.random.default_rng(4)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    means, covariances = [], []
    for _ in range(400):
        noise = np.transpose([scale * process(random, count) for scale in (1.0, 2.0, 0.5)])
        vectors = noise @ turn.T + [1.0, -2.0, 9.8]
        window = RestWindow(0.01 * (count - 1), 100.0)
        rest, _ = fill(window, [tuple(v) for v in vectors.tolist()])
        means.append(turn.T @ np.subtract(rest.mean, [1.0, -2.0, 9.8]))
        covariances.append(turn.T @ np.reshape(rest.mean_covariance, (3, 3)) @ turn)
    claimed = np.mean(covariances, axis=0)
    ratios = np.sqrt(np.mean(np.square(means), axis=0) / np.diag(claimed))
    assert (ratios > low).all()
    assert (ratios < high).all()
    across = claimed - np.diag(np.diag(claimed))
    assert np.abs(across).max() < 0.15 * claimed.max()


def test_quiet_rest_leaves_no_doubt():
    rest, _ = fill(RestWindow(0.5, 0.1), [(0.1, 0.2, GRAVITY)] * 51)
    assert rest.mean == (0.1, 0.2, GRAVITY)
    assert rest.mean_covariance == UNKNOWN


def test_gravity_is_known_along_the_force_and_tilt_across():
    random = np.random.default_rng(5)
    up = np.array([0.6, 0.0, 0.8])
    levels = []
    for _ in range(300):
        along, across = random.normal(0.0, 0.2, 51), random.normal(0.0, 0.02, (51, 3))
        vectors = (GRAVITY + along)[:, np.newaxis] * up + across
        rest, _ = fill(RestWindow(0.5, 1.0), [tuple(v) for v in vectors.tolist()])
        levels.append(level_variances(rest))
    gravity, tilt = np.sqrt(np.mean(levels, axis=0))
    assert gravity == pytest.approx(0.2 / np.sqrt(51), rel=0.1)
    assert tilt == pytest.approx(0.02 / np.sqrt(51) / GRAVITY, rel=0.1)


@pytest.mark.parametrize('axis', [0, 1, 2])
def test_motion_on_any_axis_is_no_rest(axis):
    vectors = np.zeros((51, 3))
    vectors[::2, axis] = 1.0
    with pytest.raises(NotAtRestError, match='hold the device still'):
        fill(RestWindow(0.5, 0.4), [tuple(v) for v in vectors.tolist()])


def test_window_starts_anew_after_it_failed():
    window = RestWindow(0.5, 0.1)
    with pytest.raises(NotAtRestError):
        fill(window, [(float(index % 2), 0.0, 0.0) for index in range(51)])
    rest, taken = fill(window, [(3.0, 4.0, 5.0)] * 51, start_ns=10**9)
    assert taken == 51
    assert rest.mean == (3.0, 4.0, 5.0)
    assert rest.deviation == (0.0, 0.0, 0.0)


def test_gravity_is_the_magnitude_from_any_side():
    assert check_gravity((0.0, 0.0, 9.8)) == pytest.approx(9.8)
    assert check_gravity((-6.0, 0.0, 8.0)) == pytest.approx(10.0)


@pytest.mark.parametrize('share', [0.901, 1.0, 1.099])
def test_ten_percent_are_allowed(share):
    assert check_gravity((share * GRAVITY, 0.0, 0.0)) == pytest.approx(share * GRAVITY)


@pytest.mark.parametrize(
    ('magnitude', 'cause'),
    [
        (0.0, 'gravity is removed already'),
        (0.05, 'gravity is removed already'),
        (1.0, 'the unit is g'),
        (1.008, 'the unit is g'),
        (1000.0, 'the unit is mg'),
        (0.899 * GRAVITY, "the sensor's range, supply or scale is set wrong"),
        (1.101 * GRAVITY, "the sensor's range, supply or scale is set wrong"),
        (2.0 * GRAVITY, "the sensor's range, supply or scale is set wrong"),
        (4.0, "the sensor's range, supply or scale is set wrong"),
        (5000.0, "the sensor's range, supply or scale is set wrong"),
    ],
)
def test_likeliest_cause_comes_first_and_all_are_named(magnitude, cause):
    with pytest.raises(GravityError) as caught:
        check_gravity((0.0, magnitude, 0.0))
    said = str(caught.value)
    assert f'{magnitude:.4g} m/s²' in said
    assert f'most likely {cause}' in said
    for words in ('removed already', 'g instead of', 'mg instead of', 'driver.range_g'):
        assert words in said


def tilted(angle):
    return (GRAVITY * math.sin(math.radians(angle)), 0.0, GRAVITY * math.cos(math.radians(angle)))


@pytest.mark.parametrize('angle', [0.0, 30.0, 59.0, -59.0])
def test_tilt_of_a_mounting_passes(angle):
    check_up_axis(tilted(angle))


@pytest.mark.parametrize('angle', [61.0, -61.0, 90.0, 180.0])
def test_far_from_up_names_the_causes(angle):
    with pytest.raises(MountingError) as caught:
        check_up_axis(tilted(angle))
    said = str(caught.value)
    assert f'{abs(angle):.0f}° off the up axis' in said
    for words in ('mounted that way', 'sign is turned', 'upside down', 'NED'):
        assert words in said
