"""The lines of the node `recorder`, read back."""

import numpy as np
import pytest

from dead_reckoning.core.errors import RecordingError
from dead_reckoning.tools.demo.recording import parse


def lines(stamps, topic, numbers):
    return [f'{topic} {stamp} {numbers}' for stamp in stamps]


def recorded(truth=range(10, 20), estimate=range(12, 20), acceleration=range(11, 20)):
    seconds = 10**9
    nine = '1 2 3 4 5 6 7 8 9'
    return [
        *lines([s * seconds for s in truth], 'ground_truth/odom', nine),
        *lines([s * seconds for s in acceleration], 'imu/linear_acceleration', '1 2 3 4 5 6'),
        *lines([s * seconds for s in estimate], 'odom', nine),
    ]


def test_times_count_from_the_first_truth():
    recording = parse(recorded())
    np.testing.assert_allclose(recording.truth.time, np.arange(10.0))
    np.testing.assert_allclose(recording.estimate.time, np.arange(2.0, 10.0))
    np.testing.assert_allclose(recording.estimate.position[0], [1, 2, 3])
    np.testing.assert_allclose(recording.estimate.velocity[0], [4, 5, 6])
    np.testing.assert_allclose(recording.estimate.deviation[0], [7, 8, 9])
    np.testing.assert_allclose(recording.acceleration[0], [1, 2, 3])


def test_order_of_lines_does_not_matter():
    shuffled = recorded()
    np.random.default_rng(1).shuffle(shuffled)
    np.testing.assert_allclose(parse(shuffled).truth.time, np.arange(10.0))


def test_truth_is_given_at_the_stamps_of_the_estimate():
    recording = parse(recorded(estimate=(13, 17)))
    np.testing.assert_allclose(recording.truth_at_estimate.time, [3.0, 7.0])


@pytest.mark.parametrize('missing', ['truth', 'estimate', 'acceleration'])
def test_a_silent_topic_is_named(missing):
    names = {'truth': 'ground_truth/odom', 'estimate': 'odom', 'acceleration': 'imu/linear'}
    with pytest.raises(RecordingError, match=names[missing]):
        parse(recorded(**{missing: ()}))


def test_an_estimate_without_its_truth_is_an_error():
    with pytest.raises(RecordingError, match='1 of 8 estimates'):
        parse(recorded(truth=[s for s in range(10, 20) if s != 15]))


def test_an_estimate_after_the_last_truth_is_left_out():
    assert parse(recorded(estimate=range(12, 25))).estimate.time[-1] == 9.0
