"""A simulated compass: the true heading, and the faults it was given."""

import math

import numpy as np
import pytest

from dead_reckoning.core.chain import FAULT, Chain
from dead_reckoning.core.compass import CompassSettings
from dead_reckoning.core.errors import (
    CalibrationError,
    NotFiniteError,
    RestartError,
    SupersededError,
)
from dead_reckoning.core.rotation import quaternion_from_euler, yaw_from_quaternion
from dead_reckoning.core.samples import NavigationState
from dead_reckoning.core.stages import COMPASS, GROUND_TRUTH
from dead_reckoning.sources.simulated_compass import (
    SimulatedCompass,
    SimulatedCompassSettings,
    compass_stage,
)

START_NS = 1_700_000_000_000_000_000
PERFECT = {'noise': False, 'quantise': False, 'iron': (0.0, 0.0)}


def compass(settings=None, **simulated):
    settings = settings or CompassSettings()
    return SimulatedCompass(SimulatedCompassSettings(**(PERFECT | simulated)), settings)


def heading(source, yaw, roll=0.0, pitch=0.0):
    """Return the heading [°] it reads."""
    return math.degrees(source.read(START_NS, quaternion_from_euler(roll, pitch, yaw)))


def difference(a, b):
    return (a - b + 180.0) % 360.0 - 180.0


@pytest.mark.parametrize('yaw', np.radians([-170.0, -90.0, 0.0, 33.0, 90.0, 179.0]))
def test_perfect_one_reads_clockwise_from_north(yaw):
    assert difference(heading(compass(), yaw), 90.0 - math.degrees(yaw)) == pytest.approx(0.0)


def test_heading_is_from_zero_to_a_full_turn():
    read = [heading(compass(), yaw) for yaw in np.linspace(-4.0, 4.0, 200)]
    assert min(read) >= 0.0
    assert max(read) < 360.0


def test_magnetic_north_that_lies_east_makes_headings_smaller():
    assert heading(compass(declination=math.radians(10.0)), 0.0) == pytest.approx(80.0)


def test_iron_bends_headings_once_around():
    """Along x it shows where the field lies across: asin(iron) at the most."""
    source = compass(iron=(0.1, 0.0))
    yaws = np.radians(np.arange(0.0, 360.0, 1.0))
    errors = np.array([difference(heading(source, yaw), 90.0 - math.degrees(yaw)) for yaw in yaws])
    assert np.abs(errors).max() == pytest.approx(math.degrees(math.asin(0.1)), rel=1e-3)
    assert errors[90] == pytest.approx(0.0, abs=1e-9), 'facing north'
    assert errors[0] == pytest.approx(-math.degrees(math.atan(0.1))), 'facing east'
    assert errors[180] == pytest.approx(math.degrees(math.atan(0.1)), abs=1e-9)


def test_tilt_is_seen_as_a_wrong_heading_where_the_field_dips():
    assert heading(compass(dip=0.0), 0.0, pitch=0.1) == pytest.approx(90.0)
    rolled = heading(compass(dip=math.radians(60.0)), math.pi / 2.0, roll=0.1)
    expected = math.degrees(math.atan(-math.tan(math.radians(60.0)) * math.sin(0.1)))
    assert difference(rolled, 0.0) == pytest.approx(expected)
    assert abs(expected) > 9.0


def test_it_rounds_to_tenths_of_a_degree():
    source = compass(quantise=True)
    read = np.array([heading(source, yaw) for yaw in np.linspace(0.0, 6.0, 500)])
    np.testing.assert_allclose(read * 10.0, np.round(read * 10.0), atol=1e-6)
    assert (read < 360.0 - 1e-9).all()


def test_noise_is_as_large_as_set():
    source = compass(CompassSettings(noise=0.02), noise=True)
    read = np.radians([difference(heading(source, 0.3), 0.0) for _ in range(5000)])
    assert read.std() == pytest.approx(0.02, rel=0.05)


def test_seed_decides_the_noise():
    first, again, other = (
        [heading(source, 0.0) for _ in range(10)]
        for source in (compass(noise=True, seed=seed) for seed in (1, 1, 2))
    )
    assert first == again != other


def test_default_is_as_good_as_it_says():
    """Error over one sigma, all the way around, noise and iron as they are by default."""
    settings = CompassSettings()
    source = SimulatedCompass(SimulatedCompassSettings(), settings)
    states = (truth(k * 5e7, 2.0 * math.pi * k / 720) for k in range(720))
    ratios = []
    for state, sample in run(source, settings, states):
        error = yaw_from_quaternion(sample.orientation) - yaw_from_quaternion(state.attitude)
        error = math.remainder(error, 2.0 * math.pi)
        ratios.append(error / math.sqrt(sample.orientation_covariance[8]))
    assert 0.6 < np.sqrt(np.mean(np.square(ratios))) < 1.2
    assert np.abs(ratios).max() < 3.0


def test_attitude_that_is_none_is_refused():
    with pytest.raises(NotFiniteError):
        compass().read(START_NS, (0.0, 0.0, math.nan, 1.0))


# Calibration ----------------------------------------------------------------------------------


def turn(source, angle, seconds=8.0, roll=0.0, start_ns=START_NS):
    """Turn by an angle [rad] at 20 headings a second."""
    count = round(20.0 * seconds)
    for number in range(count + 1):
        attitude = quaternion_from_euler(roll, 0.0, angle * number / count)
        source.read(start_ns + number * 50_000_000, attitude)


def test_full_turn_takes_the_iron_off():
    source = compass(iron=(0.2, -0.1), noise=True)
    future = source.calibrate()
    assert not future.done()
    turn(source, -7.0)
    assert source.offset == pytest.approx((0.2, -0.1), abs=0.01)
    assert future.result(timeout=0).startswith('iron adds +0.2')
    for yaw in (0.0, 1.0, 2.0, 3.0, 4.0):
        read = np.mean(
            [difference(heading(source, yaw), 90.0 - math.degrees(yaw)) for _ in 'abcd']
        )
        assert read == pytest.approx(0.0, abs=1.5)


def test_calibrating_again_gives_the_same():
    source = compass(iron=(0.2, -0.1))
    for _ in range(2):
        source.calibrate()
        turn(source, 7.0)
        assert source.offset == pytest.approx((0.2, -0.1))


def test_without_a_turn_it_fails_and_leaves_the_offset():
    source = compass(iron=(0.2, -0.1))
    source.calibrate()
    turn(source, 7.0)
    before = source.offset
    future = source.calibrate()
    turn(source, 1.0, seconds=16.0)
    error = future.exception(timeout=0)
    assert isinstance(error, CalibrationError)
    assert 'in 15 s: ask again and turn it level once around' in str(error)
    assert source.offset == before


def test_wobbling_turn_is_refused():
    source = compass(dip=math.radians(60.0))
    future = source.calibrate()
    for number in range(161):
        angle = 7.0 * number / 160
        attitude = quaternion_from_euler(0.0, 0.2 * math.sin(3.0 * angle), angle)
        source.read(START_NS + number * 50_000_000, attitude)
    assert 'drew no circle' in str(future.exception(timeout=0))


def test_asking_again_starts_over():
    source = compass()
    first = source.calibrate()
    turn(source, 5.0)
    second = source.calibrate()
    assert isinstance(first.exception(timeout=0), SupersededError)
    turn(source, 5.0)
    assert not second.done()


# As a stage -----------------------------------------------------------------------------------


def truth(since_ns, yaw=0.0):
    attitude = quaternion_from_euler(0.0, 0.0, yaw)
    return NavigationState(START_NS + round(since_ns), (0.0,) * 3, (0.0,) * 3, attitude)


def run(source, settings, states):
    """Yield state and sample for each state that has one."""
    chain = Chain([compass_stage(source, settings, 'imu_link')])
    for state in states:
        for name, value in chain.push(GROUND_TRUTH, state):
            assert name == COMPASS
            yield state, value


def stamps(rate_in, rate, seconds=2.0, first_ns=0):
    settings = CompassSettings(rate=rate)
    states = (truth(first_ns + k * 1e9 / rate_in) for k in range(int(seconds * rate_in)))
    return [sample.stamp_ns - START_NS for _, sample in run(compass(), settings, states)]


def test_it_reads_at_its_own_rate_in_moments_of_the_truth():
    found = stamps(100.0, 20.0)
    assert found == [k * 50_000_000 for k in range(40)]


def test_moments_do_not_depend_on_when_it_was_started():
    early, late = stamps(100.0, 20.0), stamps(100.0, 20.0, first_ns=330_000_000)
    assert set(late[1:]) & set(range(0, 2_000_000_000, 50_000_000)) <= set(early)
    assert [stamp for stamp in late[1:] if stamp < 2_000_000_000] == early[7:]


def test_slow_truth_gives_a_sample_each():
    assert stamps(10.0, 20.0) == [k * 100_000_000 for k in range(20)]


def test_yaw_of_the_sample_is_the_true_one():
    settings = CompassSettings()
    states = (truth(k * 5e7, 0.1 * k) for k in range(100))
    for state, sample in run(compass(), settings, states):
        assert sample.frame_id == 'imu_link'
        error = yaw_from_quaternion(sample.orientation) - yaw_from_quaternion(state.attitude)
        assert math.remainder(error, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_late_truth_is_a_fault_and_a_restart_is_said_once():
    source, settings = compass(), CompassSettings()
    chain = Chain([compass_stage(source, settings, 'imu_link')])
    assert len(chain.push(GROUND_TRUTH, truth(10e9))) == 1
    ((name, _),) = chain.push(GROUND_TRUTH, truth(9.9e9))
    assert name == FAULT
    future = source.calibrate()
    (name, error), (also, _) = chain.push(GROUND_TRUTH, truth(0.0))
    assert (name, also) == (FAULT, COMPASS)
    assert isinstance(error, RestartError)
    assert 'the stamps went back' in str(future.exception(timeout=0))
    assert [name for name, _ in chain.push(GROUND_TRUTH, truth(5e7))] == [COMPASS]
