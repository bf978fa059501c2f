"""Headings remembered for what is known only later."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import NotFiniteError
from dead_reckoning.core.headings import HeadingHistory
from dead_reckoning.core.rotation import isotropic, quaternion_from_euler
from dead_reckoning.core.samples import UNKNOWN, ImuSample

START_NS = 1_700_000_000_000_000_000
SECOND = 1_000_000_000


def sample(seconds, yaw=0.0, roll=0.0, pitch=0.0, covariance=UNKNOWN):
    orientation = quaternion_from_euler(roll, pitch, yaw)
    stamp_ns = START_NS + round(seconds * SECOND)
    return ImuSample(
        stamp_ns,
        'imu_link',
        (0.0, 0.0, 0.0),
        orientation=orientation,
        orientation_covariance=covariance,
    )


def history(*samples):
    made = HeadingHistory(0.1)
    for each in samples:
        made.add(each)
    return made


def yaw_at(made, seconds, within=1.0):
    heading = made.at(START_NS + round(seconds * SECOND), round(within * SECOND))
    return None if heading is None else math.atan2(heading.y, heading.x)


@given(st.floats(-3.1, 3.1), st.floats(-1.4, 1.4), st.floats(-3.1, 3.1))
def test_heading_is_where_the_x_axis_points(roll, pitch, yaw):
    assert yaw_at(history(sample(0.0, yaw, roll, pitch)), 0.0) == pytest.approx(yaw, abs=1e-9)


@pytest.mark.parametrize('pitch', [-math.pi / 2, math.pi / 2, 1.5])
def test_upright_x_axis_has_no_heading(pitch):
    assert yaw_at(history(sample(0.0, 1.0, 0.0, pitch)), 0.0) is None


def test_device_with_its_y_axis_up_has_a_heading():
    assert yaw_at(history(sample(0.0, 1.0, math.pi / 2)), 0.0) == pytest.approx(1.0)


def test_nearest_heading_is_taken_and_only_a_near_one():
    made = history(*(sample(0.1 * k, 0.1 * k) for k in range(20)))
    assert yaw_at(made, 0.52) == pytest.approx(0.5)
    assert yaw_at(made, 0.58) == pytest.approx(0.6)
    assert yaw_at(made, -0.5) == pytest.approx(0.0)
    assert yaw_at(made, 2.4) == pytest.approx(1.9)
    assert yaw_at(made, 2.4, within=0.4) is None
    assert yaw_at(HeadingHistory(0.1), 0.0) is None


def test_variance_is_the_samples_or_the_fallback():
    known = history(sample(0.0, covariance=(0.1, 0, 0, 0, 0.2, 0, 0, 0, 0.3)))
    assert known.at(START_NS, SECOND).variance == 0.3
    assert history(sample(0.0)).at(START_NS, SECOND).variance == pytest.approx(0.01)
    broken = history(sample(0.0, covariance=isotropic(math.nan)))
    assert broken.at(START_NS, SECOND).variance == pytest.approx(0.01)


def test_late_heading_finds_its_place():
    random = np.random.default_rng(1)
    times = np.arange(0.0, 1.0, 0.05)
    made = history(*(sample(t, t) for t in random.permutation(times)))
    for t in times:
        assert yaw_at(made, t) == pytest.approx(t, abs=1e-9)


def test_jump_back_starts_anew():
    made = history(*(sample(0.1 * k, 1.0) for k in range(30)), sample(0.5, 2.0))
    assert yaw_at(made, 0.5) == pytest.approx(2.0)
    assert yaw_at(made, 2.9) is None


def test_memory_is_two_minutes_and_bounded():
    made = history(*(sample(0.01 * k, 0.01 * k) for k in range(30_000)))
    for time in (299.9, 240.0, 179.0):
        assert yaw_at(made, time) == pytest.approx(math.remainder(time, math.tau), abs=0.02)
    assert yaw_at(made, 140.0) is None


def test_sample_without_orientation_says_nothing():
    assert yaw_at(history(ImuSample(START_NS, 'imu_link', (0.0, 0.0, 9.8))), 0.0) is None


def test_orientation_that_is_no_rotation_is_refused():
    with pytest.raises(NotFiniteError):
        history(ImuSample(START_NS, 'i', (0.0,) * 3, orientation=(0.0, 0.0, 0.0, math.nan)))
