"""The latest yaw of a compass is held, and believed for a while."""

import math

import pytest

from dead_reckoning.core.compass_yaw import CompassYaw
from dead_reckoning.core.errors import (
    LateSampleError,
    MissingAttitudeError,
    NotFiniteError,
    RepeatedStampError,
    SampleError,
    ZeroStampError,
)
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.samples import UNKNOWN, ZERO, ImuSample

START_NS = 1_700_000_000_000_000_000


def compass_yaw(timeout=1.0, turn_deviation=0.2, deviation=0.1):
    return CompassYaw(timeout, turn_deviation, deviation)


def heading(seconds, yaw, variance=0.01, tilt=(0.0, 0.0)):
    covariance = (1e6, 0.0, 0.0, 0.0, 1e6, 0.0, 0.0, 0.0, variance)
    return ImuSample(
        at(seconds),
        'compass_link',
        ZERO,
        orientation=quaternion_from_euler(*tilt, yaw),
        orientation_covariance=covariance,
    )


def at(seconds):
    return START_NS + round(seconds * 1e9)


def test_without_a_message_there_is_no_yaw():
    assert compass_yaw().at(at(0.0)) is None
    assert compass_yaw().age(at(0.0)) is None
    assert not compass_yaw().stale(at(100.0))


@pytest.mark.parametrize('yaw', [0.0, 1.0, -3.0, 3.1])
@pytest.mark.parametrize('tilt', [(0.0, 0.0), (0.3, -0.5)])
def test_yaw_is_held_until_the_next_message(yaw, tilt):
    held = compass_yaw()
    held.take(heading(0.0, yaw, 0.04, tilt))
    for seconds in (0.0, 0.02, 0.9, 1.0):
        assert held.at(at(seconds)) == (pytest.approx(yaw), 0.04)
        assert not held.stale(at(seconds))
    held.take(heading(1.0, 0.5, 0.01))
    assert held.at(at(1.0)) == (pytest.approx(0.5), 0.01)
    assert held.interval == 1.0


def test_message_may_come_before_the_samples_of_its_time():
    held = compass_yaw()
    held.take(heading(0.05, 0.5, 0.01))
    assert held.at(at(0.0)) == (pytest.approx(0.5), 0.01)
    assert held.age(at(0.0)) == 0.0


def test_deviation_grows_once_the_compass_is_silent():
    held = compass_yaw(timeout=1.0, turn_deviation=0.2)
    held.take(heading(0.0, 0.5, 0.01))
    assert held.stale(at(1.1))
    yaw, variance = held.at(at(4.0))
    assert yaw == pytest.approx(0.5)
    assert variance == pytest.approx(0.01 + (0.2 * 3.0) ** 2)
    held.take(heading(4.0, 0.6, 0.01))
    assert not held.stale(at(4.0))


def test_variance_that_the_message_does_not_give_is_the_one_that_is_set():
    held = compass_yaw(deviation=0.1)
    orientation = quaternion_from_euler(0.0, 0.0, 0.5)
    held.take(ImuSample(at(0.0), 'compass_link', ZERO, orientation=orientation))
    assert held.at(at(0.0))[1] == pytest.approx(0.01)


def test_stamps_of_samples_that_go_back_find_no_yaw_from_their_future():
    """A bag in a loop: the yaw is of the end of the last round."""
    held = compass_yaw()
    held.take(heading(100.0, 0.5))
    assert held.at(at(0.0)) is None
    assert held.at(at(99.5)) is not None
    held.take(heading(0.1, 0.7))
    assert held.at(at(0.2))[0] == pytest.approx(0.7)
    assert held.interval is None


def test_reset_forgets_the_yaw():
    held = compass_yaw()
    held.take(heading(0.0, 0.5))
    held.reset()
    assert held.at(at(0.0)) is None
    held.take(heading(0.0, 0.5))


BAD = [
    (ImuSample(at(1.1), 'compass_link', ZERO), MissingAttitudeError),
    (ImuSample(at(1.1), 'compass_link', ZERO, orientation=(math.nan,) * 4), NotFiniteError),
    (ImuSample(at(1.1), 'compass_link', ZERO, orientation=(0.0,) * 4), NotFiniteError),
    (heading(1.1, 0.0, math.nan), NotFiniteError),
    (heading(1.1, 0.0, math.inf), NotFiniteError),
    (heading(1.1, 0.0, -1.0), NotFiniteError),
    (heading(1.0, 0.0), RepeatedStampError),
    (heading(0.9, 0.0), LateSampleError),
    (ImuSample(0, 'compass_link', ZERO, UNKNOWN, orientation=(0, 0, 0, 1.0)), ZeroStampError),
]


@pytest.mark.parametrize(('bad', 'error'), BAD)
def test_bad_message_is_refused_and_the_last_yaw_stays(bad, error):
    held = compass_yaw()
    held.take(heading(1.0, 0.5))
    with pytest.raises(SampleError) as caught:
        held.take(bad)
    assert caught.type is error
    assert held.at(at(1.05)) == (pytest.approx(0.5), 0.01)
    held.take(heading(1.1, 0.6))
    assert held.interval == pytest.approx(0.1)
