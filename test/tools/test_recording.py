"""The lines of the node `recorder`, read back."""

import numpy as np
import pytest

from dead_reckoning.core.errors import RecordingError
from dead_reckoning.tools.demo.recording import Track, parse


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


TOPICS = ('odom', 'imu/linear_acceleration')


def test_times_count_from_the_first_truth():
    recording = parse(recorded(), TOPICS)
    estimate = recording.track('odom')
    np.testing.assert_allclose(recording.truth.time, np.arange(10.0))
    np.testing.assert_allclose(estimate.time, np.arange(2.0, 10.0))
    np.testing.assert_allclose(estimate.position[0], [1, 2, 3])
    np.testing.assert_allclose(estimate.velocity[0], [4, 5, 6])
    np.testing.assert_allclose(estimate.deviation[0], [7, 8, 9])
    acceleration = recording.series['imu/linear_acceleration']
    np.testing.assert_allclose(acceleration.time, np.arange(1.0, 10.0))
    np.testing.assert_allclose(acceleration.values[0], [1, 2, 3, 4, 5, 6])


def test_order_of_lines_does_not_matter():
    shuffled = recorded()
    np.random.default_rng(1).shuffle(shuffled)
    np.testing.assert_allclose(parse(shuffled, TOPICS).truth.time, np.arange(10.0))


def test_what_came_before_the_truth_is_left_out():
    early = [*recorded(), 'odom 0 1 2 3 4 5 6 7 8 9']
    assert parse(early, TOPICS).series['odom'].time[0] == 2.0


def test_topics_that_were_not_asked_for_are_left_out():
    assert set(parse(recorded(), ['odom']).series) == {'ground_truth/odom', 'odom'}


def test_a_track_between_its_times_is_a_straight_line():
    time = np.array([0.0, 2.0])
    rows = np.array([[0.0, 0.0, 0.0], [2.0, 4.0, -6.0]])
    middle = Track(time, rows, 10.0 * rows, 100.0 * rows).at(np.array([0.5, 2.0]))
    np.testing.assert_allclose(middle.time, [0.5, 2.0])
    np.testing.assert_allclose(middle.position, [[0.5, 1.0, -1.5], [2.0, 4.0, -6.0]])
    np.testing.assert_allclose(middle.velocity[0], [5.0, 10.0, -15.0])
    np.testing.assert_allclose(middle.deviation[0], [50.0, 100.0, -150.0])


@pytest.mark.parametrize('missing', ['truth', 'estimate', 'acceleration'])
def test_a_silent_topic_is_named(missing):
    names = {'truth': 'ground_truth/odom', 'estimate': 'odom', 'acceleration': 'imu/linear'}
    with pytest.raises(RecordingError, match=names[missing]):
        parse(recorded(**{missing: ()}), TOPICS)


def test_an_estimate_after_the_last_truth_is_left_out():
    recording = parse(recorded(estimate=range(12, 25)), TOPICS)
    assert recording.track('odom').time[-1] == 9.0


def test_estimates_only_outside_of_the_truth_are_an_error():
    with pytest.raises(RecordingError, match='odom while there was truth'):
        parse(recorded(estimate=range(30, 33)), TOPICS).track('odom')
