"""Steps along a heading: where they lead, and how well that is known."""

import math

import numpy as np
import pytest
from scipy.stats import chi2

from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import MissingAttitudeError
from dead_reckoning.core.pedometer import PedometerSettings, PedometerState
from dead_reckoning.core.rotation import quaternion_from_euler, yaw_from_quaternion
from dead_reckoning.core.samples import UNKNOWN, UNMEASURED_VARIANCE, ImuSample, NavigationState
from dead_reckoning.core.step_odometry import StepOdometry

START_NS = 1_700_000_000_000_000_000
DURATION = 0.5
STEP_NS = 500_000_000
LENGTH = 0.7


def odometry(**settings):
    return StepOdometry(PedometerSettings(**settings), CommonSettings())


def oriented(stamp_ns, yaw, variance=None):
    level = (0.1, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
    covariance = UNKNOWN if variance is None else (*level, variance)
    return ImuSample(
        stamp_ns,
        'imu_link',
        (0.0, 0.0, 9.8),
        orientation=quaternion_from_euler(0.0, 0.0, yaw),
        orientation_covariance=covariance,
    )


def navigated(stamp_ns, yaw, variance):
    """Return a state of an inertial navigator."""
    return NavigationState(
        stamp_ns,
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        quaternion_from_euler(0.0, 0.0, yaw),
        attitude_covariance=(0.1, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, variance),
    )


def step(number, length=LENGTH, duration=DURATION):
    return PedometerState(
        START_NS + number * STEP_NS, number, number * length, length, 2.0, duration
    )


def walk(made, yaws, variance=0.0):
    """Walk steps, each with a heading in its middle; return the states."""
    states = []
    for number, yaw in enumerate(yaws, 1):
        if yaw is not None:
            middle_ns = START_NS + number * STEP_NS - STEP_NS // 2
            made.take_orientation(oriented(middle_ns, yaw, variance))
        states.append(made.update(step(number)))
    return states


def position_covariance(state):
    return np.reshape(state.position_covariance, (3, 3))[:2, :2]


def test_steps_lead_along_the_heading():
    end = walk(odometry(), [0.3] * 10)[-1]
    assert end.position == pytest.approx((7.0 * math.cos(0.3), 7.0 * math.sin(0.3), 0.0))
    assert end.stamp_ns == START_NS + 10 * STEP_NS
    assert yaw_from_quaternion(end.attitude) == pytest.approx(0.3)
    speed = LENGTH / DURATION
    assert end.velocity == pytest.approx((speed * math.cos(0.3), speed * math.sin(0.3), 0.0))


def test_square_comes_back():
    yaws = [quarter * math.pi / 2 for quarter in range(4) for _ in range(5)]
    states = walk(odometry(), yaws)
    assert states[9].position == pytest.approx((3.5, 3.5, 0.0))
    assert states[-1].position == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)


def test_heading_in_the_middle_of_the_step_counts():
    made = odometry()
    for number in range(11):
        made.take_orientation(oriented(START_NS + number * STEP_NS // 10, 0.1 * number))
    assert yaw_from_quaternion(made.update(step(1)).attitude) == pytest.approx(0.5)


def test_angle_between_device_and_walk_is_added():
    end = walk(odometry(heading_offset=math.pi / 2), [0.3] * 10)[-1]
    assert end.position == pytest.approx((-7.0 * math.sin(0.3), 7.0 * math.cos(0.3), 0.0))


def test_nothing_comes_without_a_heading():
    assert walk(odometry(), [None] * 5) == [None] * 5


def test_old_heading_is_none():
    made = odometry()
    made.take_orientation(oriented(START_NS, 0.0))
    assert made.update(step(2)) is not None
    assert made.update(step(4)) is None


def test_end_of_a_walk_is_no_step():
    made = odometry()
    made.take_orientation(oriented(START_NS, 0.0))
    assert made.update(step(1, duration=0.0)) is None
    assert made.update(step(1)).position == (LENGTH, 0.0, 0.0)


def test_reset_returns_to_the_origin_known_exactly():
    made = odometry()
    first = walk(made, [0.0])[0]
    walk(made, [0.0, None, 1.0])
    made.reset()
    again = walk(made, [0.0])[0]
    assert again.position == first.position
    assert again.position_covariance == first.position_covariance


# Sources of the heading -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ('choice', 'expected'),
    [
        ('any', 1.0),
        ('compass', 1.0),
        ('orientation', 2.0),
        ('navigator', 3.0),
        ('none', None),
    ],
)
def test_source_is_as_chosen(choice, expected):
    made = odometry(heading=choice)
    made.take_compass(oriented(START_NS + STEP_NS // 2, 1.0))
    made.take_orientation(oriented(START_NS + STEP_NS // 2, 2.0))
    if choice == 'navigator':
        made.take_navigator(navigated(START_NS + STEP_NS // 2, 3.0, 0.01))
    state = made.update(step(1))
    found = state and yaw_from_quaternion(state.attitude)
    assert found == (expected and pytest.approx(expected))


def test_orientation_stands_in_for_a_compass_that_falls_silent():
    made = odometry()
    made.take_compass(oriented(START_NS, 1.0))
    yaws = [yaw_from_quaternion(state.attitude) for state in walk(made, [2.0] * 5)]
    assert yaws == pytest.approx([1.0, 1.0, 2.0, 2.0, 2.0])


# Covariance -----------------------------------------------------------------------------------


def test_straight_walk_spreads_along_by_k_and_across_by_heading():
    settings = {'length_deviation': 0.06, 'heading_deviation': 0.1, 'step_deviation': 0.0}
    for count in (1, 10, 100):
        end = walk(odometry(**settings), [0.0] * count, variance=0.03)[-1]
        covariance = position_covariance(end)
        distance = LENGTH * count
        shorter = 0.75 * 0.04**2
        assert covariance[0, 0] == pytest.approx((0.06**2 + shorter) * distance**2)
        assert math.sqrt(covariance[1, 1]) == pytest.approx(math.sqrt(0.04) * distance)
        assert covariance[0, 1] == pytest.approx(0.0, abs=1e-12)


def test_single_steps_add_in_squares():
    settings = {'length_deviation': 0.0, 'heading_deviation': 0.0, 'step_deviation': 0.1}
    end = walk(odometry(**settings), [0.5] * 100)[-1]
    assert position_covariance(end) == pytest.approx(np.eye(2) * 100 * 0.07**2)


@pytest.mark.parametrize('yaws', [[0.4] * 20, list(np.linspace(0.0, 3.0, 20)), [0.0, 3.1] * 10])
def test_covariance_is_that_of_the_errors(yaws):
    """Monte Carlo: walk with a wrong k, a wrong heading and uneven steps."""
    random = np.random.default_rng(2)
    sigma_k, sigma_heading, sigma_step = 0.05, 0.08, 0.1
    ends = []
    for _ in range(4000):
        k, turn = 1.0 + sigma_k * random.normal(), sigma_heading * random.normal()
        headings = np.array(yaws) + turn
        ways = k * LENGTH * np.column_stack([np.cos(headings), np.sin(headings)])
        ends.append((ways + sigma_step * LENGTH * random.normal(size=ways.shape)).sum(axis=0))
    made = odometry(
        length_deviation=sigma_k, heading_deviation=sigma_heading, step_deviation=sigma_step
    )
    covariance = position_covariance(walk(made, yaws)[-1])
    np.testing.assert_allclose(
        np.cov(np.transpose(ends)), covariance, atol=0.1 * np.trace(covariance)
    )


def known_all_along(random, count):
    """Return errors of a compass, each with its variance: one bias for all."""
    return np.full(count, random.normal(0.0, 0.08)), np.full(count, 0.08**2)


def drifting(random, count, corrections=0):
    """Return errors of a yaw that a gyro carries, with the variances that its filter gives.

    The best estimate of a random walk, of which something is measured so often.
    """
    rate, noise = 0.014**2, 0.1**2
    error, variance = random.normal(0.0, 0.02), 0.02**2
    errors, variances = [], []
    for k in range(count):
        error, variance = error + random.normal(0.0, rate**0.5), variance + rate
        if corrections and k % (count // corrections) == 0:
            gain = variance / (variance + noise)
            error += gain * (random.normal(0.0, noise**0.5) - error)
            variance *= 1.0 - gain
        errors.append(error)
        variances.append(variance)
    return np.array(errors), np.array(variances)


def corrected(random, count):
    return drifting(random, count, corrections=10)


@pytest.mark.parametrize('heading', [known_all_along, drifting, corrected])
@pytest.mark.parametrize(
    'yaws',
    [
        np.zeros(100),
        np.repeat([0.0, np.pi], 50),  # there and back
        np.repeat([0.0, 1.5, 3.1, 4.7], 25),
        np.linspace(0.0, 4.0 * np.pi, 100),
    ],
    ids=['straight', 'back', 'square', 'circles'],
)
def test_error_is_as_large_as_the_covariance_says(heading, yaws):
    """ANEES: walks with the errors of k, mounting, heading and single steps that settings say."""
    random, walks = np.random.default_rng(21), 120
    settings = PedometerSettings(heading_deviation=0.05, heading='navigator')
    looks = (len(yaws) // 2, len(yaws) - 1)
    nees = np.zeros((walks, len(looks)))
    for walk_number in range(walks):
        made = StepOdometry(settings, CommonSettings())
        errors, variances = heading(random, len(yaws))
        k = 1.0 + settings.length_deviation * random.normal()
        offset = settings.heading_deviation * random.normal()
        true = np.array(yaws) - errors - offset
        ways = k * LENGTH * np.column_stack([np.cos(true), np.sin(true)])
        ways += settings.step_deviation * LENGTH * random.normal(size=ways.shape)
        truth = np.cumsum(ways, axis=0)
        for number, (yaw, variance) in enumerate(zip(yaws, variances, strict=True)):
            middle_ns = START_NS + (2 * number + 1) * STEP_NS // 2
            made.take_navigator(navigated(middle_ns, float(yaw), float(variance)))
            state = made.update(step(number + 1))
            if number in looks:
                error = np.array(state.position[:2]) - truth[number]
                inside = np.linalg.solve(position_covariance(state), error)
                nees[walk_number, looks.index(number)] = error @ inside
    low, high = chi2.interval(0.999, 2 * walks)
    for mean in nees.mean(axis=0):
        assert low / walks < mean < high / walks


def test_steps_without_a_heading_go_into_the_uncertainty():
    settings = {'length_deviation': 0.0, 'heading_deviation': 0.0, 'step_deviation': 0.0}
    made = odometry(**settings)
    states = walk(made, [0.0, None, None, None, None, None, 0.0])
    assert states[2] is not None, 'a heading of half a second ago is still one'
    lost = sum(state is None for state in states)
    assert lost > 0
    assert position_covariance(states[-1]) == pytest.approx(np.eye(2) * (lost * LENGTH) ** 2)


def test_what_is_not_known_says_so():
    end = walk(odometry(), [0.2] * 3)[-1]
    for covariance in (end.position_covariance, end.velocity_covariance):
        assert covariance[8] == UNMEASURED_VARIANCE
        assert np.linalg.eigvalsh(np.reshape(covariance, (3, 3))).min() > 0.0
    assert end.attitude_covariance[0] == end.attitude_covariance[4] == UNMEASURED_VARIANCE
    assert end.attitude_covariance[8] == pytest.approx(0.01)
    assert end.angular_velocity is None


def test_velocity_spreads_along_and_across():
    settings = {'length_deviation': 0.06, 'heading_deviation': 0.1, 'step_deviation': 0.0}
    end = walk(odometry(**settings), [math.pi / 2] * 3)[-1]
    covariance = np.reshape(end.velocity_covariance, (3, 3))
    speed = LENGTH / DURATION
    assert covariance[0, 0] == pytest.approx((0.1 * speed) ** 2)
    assert covariance[1, 1] == pytest.approx((0.06 * speed) ** 2)


@pytest.mark.parametrize(
    ('heading', 'compass', 'orientation'),
    [
        ('any', True, False),
        ('compass', True, False),
        ('orientation', False, True),
        ('none', False, False),
    ],
)
def test_what_has_to_give_the_heading_must_carry_one(heading, compass, orientation):
    made = odometry(heading=heading)
    bare = ImuSample(START_NS, 'imu_link', (0.0, 0.0, 9.8))
    for take, refused in ((made.take_compass, compass), (made.take_orientation, orientation)):
        if refused:
            with pytest.raises(MissingAttitudeError, match='carries no orientation'):
                take(bare)
        else:
            take(bare)
