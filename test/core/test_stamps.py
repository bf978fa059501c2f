"""Time steps come from stamps alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import LateSampleError, RepeatedStampError, ZeroStampError
from dead_reckoning.core.stamps import Timeline

SECOND = 1_000_000_000


def test_first_stamp_has_no_step():
    assert Timeline().advance(5) is None


def test_step_is_measured_to_the_nanosecond():
    timeline = Timeline()
    timeline.advance(1_700_000_000 * SECOND + 1)
    assert timeline.advance(1_700_000_000 * SECOND + 3) == 2
    assert timeline.advance(1_700_000_060 * SECOND + 3) == 60 * SECOND


@given(st.lists(st.integers(1, 10 * SECOND), min_size=2, max_size=50, unique=True).map(sorted))
def test_steps_add_up_to_the_whole_time(stamps):
    timeline = Timeline()
    steps = [timeline.advance(stamp) for stamp in stamps]
    assert steps[0] is None
    assert sum(steps[1:]) == stamps[-1] - stamps[0]


@pytest.mark.parametrize(
    ('stamp', 'error', 'said'),
    [
        (0, ZeroStampError, 'let the driver stamp'),
        (20 * SECOND, RepeatedStampError, 'came twice'),
        (20 * SECOND - 1, LateSampleError, '0.000000 s older'),
        (19 * SECOND + 1, LateSampleError, '1.000000 s older'),
        (19 * SECOND + SECOND // 2, LateSampleError, '0.500000 s older'),
    ],
)
def test_refused_stamp_is_forgotten(stamp, error, said):
    timeline = Timeline()
    timeline.advance(20 * SECOND)
    with pytest.raises(error, match=said):
        timeline.advance(stamp)
    assert timeline.advance(21 * SECOND) == SECOND
    assert timeline.restarts == 0


def test_zero_is_no_time_at_the_first_sample_either():
    timeline = Timeline()
    with pytest.raises(ZeroStampError):
        timeline.advance(0)
    assert timeline.advance(7) is None


def test_going_back_by_more_than_a_second_is_a_restart():
    timeline = Timeline()
    timeline.advance(20 * SECOND)
    assert timeline.advance(19 * SECOND - 1) is None
    assert timeline.restarts == 1
    assert timeline.advance(19 * SECOND) == 1


def test_reset_forgets_the_stamp_but_not_the_count():
    timeline = Timeline()
    timeline.advance(20 * SECOND)
    timeline.advance(10 * SECOND)
    timeline.reset()
    assert timeline.advance(10 * SECOND) is None
    assert timeline.restarts == 1
