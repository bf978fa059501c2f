"""Roll and pitch of a rest, held; yaw from a compass where there is one."""

import math
from contextlib import suppress

import numpy as np
import pytest

from dead_reckoning.core.attitude.held import HeldAttitude
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.compass_yaw import CompassYaw
from dead_reckoning.core.errors import NotLevelledError, StaleCompassError
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest import GRAVITY, Rest
from dead_reckoning.core.rest_search import Stillness
from dead_reckoning.core.rotation import (
    matrix_from_quaternion,
    quaternion_from_euler,
    rotate,
    rotate_back,
)
from dead_reckoning.core.samples import ZERO, ImuSample

START_NS = 1_700_000_000_000_000_000
LEVEL = (0.0, 0.0, GRAVITY)


def imu(step, force=LEVEL):
    return ImuSample(START_NS + step * 10_000_000, 'imu_link', force)


def heading(step, yaw, variance=0.0025):
    covariance = (1e6, 0.0, 0.0, 0.0, 1e6, 0.0, 0.0, 0.0, variance)
    return ImuSample(
        START_NS + step * 10_000_000,
        'compass_link',
        ZERO,
        orientation=quaternion_from_euler(0.0, 0.0, yaw),
        orientation_covariance=covariance,
    )


def rest(removal, first=0, force=LEVEL):
    """Feed 51 samples of rest; return what the last one gave."""
    for step in range(first, first + 51):
        with suppress(NotLevelledError):
            last = removal.update(imu(step, force))
    return last


def removal_at_rest(force=LEVEL, turn_deviation=0.2, **settings):
    removal = GravityRemoval(
        GravitySettings(attitude='rest', **settings),
        CommonSettings(turn_deviation=turn_deviation),
        FrameSettings(),
    )
    rest(removal, 0, force)
    return removal


def force_at(roll, pitch):
    rot_ws = matrix_from_quaternion(quaternion_from_euler(roll, pitch, 0.0))
    return rotate_back(rot_ws, LEVEL)


def test_source_knows_nothing_before_it_is_levelled():
    source = HeldAttitude(CommonSettings(), CompassYaw(1.0, 0.2, 0.01))
    source.advance(imu(0), None)
    assert source.attitude is None
    said = source.level(Stillness(Rest(force_at(0.1, -0.2), ZERO, 50), None), START_NS)
    assert said == 'roll 5.730°, pitch -11.459°'
    assert source.attitude == pytest.approx(quaternion_from_euler(0.1, -0.2, 0.0))
    source.reset()
    assert source.attitude is None


@pytest.mark.parametrize(('roll', 'pitch'), [(0.0, 0.0), (0.3, -0.2), (-0.5, 0.4)])
def test_yaw_is_that_of_the_compass(roll, pitch):
    force = force_at(roll, pitch)
    removal = removal_at_rest(force)
    removal.follow_compass(heading(51, 1.2))
    given_back = removal.update(imu(52, force))
    assert given_back.imu.orientation == pytest.approx(quaternion_from_euler(roll, pitch, 1.2))
    assert given_back.acceleration.acceleration == pytest.approx(ZERO, abs=1e-12)


def test_without_a_compass_yaw_is_zero_and_known_as_well_as_the_tilt():
    covariance = removal_at_rest().update(imu(51)).imu.orientation_covariance
    assert covariance == pytest.approx(tuple((0.0175**2 * np.eye(3)).ravel()))


def test_compass_says_how_well_the_yaw_is_known():
    removal = removal_at_rest()
    removal.follow_compass(heading(51, 1.2, 0.04))
    covariance = np.reshape(removal.update(imu(52)).imu.orientation_covariance, (3, 3))
    assert covariance == pytest.approx(np.diag([0.0175**2, 0.0175**2, 0.04]))


def test_compass_that_speaks_before_the_rest_is_heard():
    removal = GravityRemoval(GravitySettings(), CommonSettings(), FrameSettings())
    removal.follow_compass(heading(0, 0.7))
    orientation = rest(removal).imu.orientation
    assert orientation == pytest.approx(quaternion_from_euler(0.0, 0.0, 0.7))


def test_acceleration_turns_with_the_compass():
    removal = removal_at_rest()
    for step, yaw in enumerate(np.linspace(0.0, 6.0, 40).tolist(), 51):
        removal.follow_compass(heading(step, yaw))
        given_back = removal.update(imu(step, (1.0, 0.0, GRAVITY)))
        rot_ws = matrix_from_quaternion(quaternion_from_euler(0.0, 0.0, yaw))
        expected = rotate(rot_ws, (1.0, 0.0, 0.0))
        assert given_back.acceleration.acceleration == pytest.approx(expected, abs=1e-12)


def test_silent_compass_is_said_once_and_the_yaw_grows_uncertain():
    removal = removal_at_rest(compass_timeout=0.5, turn_deviation=0.1)
    removal.follow_compass(heading(51, 1.0))
    hidden = []
    for step in range(52, 400):
        covariance = removal.update(imu(step)).imu.orientation_covariance
        hidden.append(math.sqrt(covariance[8] - 0.0025))
    (finding,) = removal.findings
    assert isinstance(finding, StaleCompassError)
    assert 'no compass/data for 0.5 s' in str(finding)
    assert hidden[49] == 0.0
    assert hidden[-1] == pytest.approx(0.1 * (3.48 - 0.5))
    removal.follow_compass(heading(400, 1.1))
    covariance = removal.update(imu(401)).imu.orientation_covariance
    assert covariance[8] == pytest.approx(0.0025)
    for step in range(402, 500):
        removal.update(imu(step))
    assert len(removal.findings) == 2, 'silent again, said again'


def test_reset_forgets_the_compass():
    removal = removal_at_rest()
    removal.follow_compass(heading(51, 1.0))
    removal.reset()
    assert rest(removal, 60).imu.orientation == (0.0, 0.0, 0.0, 1.0)


def test_levelling_again_keeps_the_yaw():
    removal = removal_at_rest()
    removal.follow_compass(heading(51, 1.0))
    future = removal.level()
    last = rest(removal, 52, force_at(0.2, 0.1))
    assert future.done()
    assert last.imu.orientation == pytest.approx(quaternion_from_euler(0.2, 0.1, 1.0))
