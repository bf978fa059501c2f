"""Headings become yaw: from north and clockwise to from east and left-hand."""

import math

import pytest

from dead_reckoning.core.compass import Compass, CompassSettings
from dead_reckoning.core.rotation import yaw_from_quaternion
from dead_reckoning.core.samples import NOT_MEASURED


def sample(heading, **settings):
    compass = Compass(CompassSettings(**settings), 'imu_link')
    return compass.sample(5, math.radians(heading))


@pytest.mark.parametrize(
    ('heading', 'yaw'), [(0.0, 90.0), (90.0, 0.0), (180.0, -90.0), (270.0, 180.0), (45.0, 45.0)]
)
def test_north_is_y_and_east_is_x(heading, yaw):
    found = math.degrees(yaw_from_quaternion(sample(heading).orientation))
    assert (found - yaw + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=1e-9)


def test_declination_east_turns_headings_east():
    """Where magnetic north lies 10° east, what it calls north is 10° east."""
    found = yaw_from_quaternion(sample(0.0, declination=math.radians(10.0)).orientation)
    assert math.degrees(found) == pytest.approx(80.0)


def test_only_the_yaw_is_measured():
    found = sample(30.0)
    x, y, z, _ = found.orientation
    assert (x, y) == (0.0, 0.0)
    assert z != 0.0
    assert found.orientation_covariance[0] == found.orientation_covariance[4] == 1e6
    assert found.specific_force_covariance == NOT_MEASURED
    assert found.angular_velocity is None
    assert (found.stamp_ns, found.frame_id) == (5, 'imu_link')


def test_variance_adds_noise_rounding_and_what_stays():
    settings = {'noise': 0.01, 'resolution': 0.02, 'deviation': 0.03}
    covariance = sample(0.0, **settings).orientation_covariance
    assert covariance[8] == pytest.approx(0.01**2 + 0.02**2 / 12.0 + 0.03**2)
    assert covariance[1:4] == covariance[5:8] == (0.0, 0.0, 0.0)
