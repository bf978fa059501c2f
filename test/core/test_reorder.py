"""Samples in the order of their stamps, from a stream that is not."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import LateSampleError, RepeatedStampError, ZeroStampError
from dead_reckoning.core.reorder import StampOrder

START_NS = 1_700_000_000_000_000_000
STEP_NS = 10_000_000
HOLD = 0.1


def released(order, stamps):
    return [stamp for given in stamps for stamp, _ in order.add(given, None)]


def regular(count, start=START_NS):
    return [start + STEP_NS * k for k in range(count)]


def test_sample_is_held_back_for_its_time():
    order = StampOrder(HOLD)
    for k, stamp in enumerate(regular(30)):
        handed = order.add(stamp, k)
        assert handed == ([(stamp - 10 * STEP_NS, k - 10)] if k >= 10 else [])


def test_nothing_is_held_back_for_no_time():
    order = StampOrder(0.0)
    for k, stamp in enumerate(regular(10)):
        assert order.add(stamp, k) == [(stamp, k)]


@given(st.lists(st.integers(-4, 4), min_size=60, max_size=60), st.randoms())
def test_jitter_within_the_hold_is_put_in_order(jitter, random):
    stamps = [stamp + 1_000_000 * j for stamp, j in zip(regular(60), jitter, strict=True)]
    arrivals = sorted(stamps, key=lambda stamp: stamp + random.uniform(0.0, 0.99e8))
    handed = released(StampOrder(HOLD), arrivals)
    assert handed == sorted(stamps)[: len(handed)]
    assert len(handed) >= 60 - 12


def test_later_than_the_hold_is_refused_and_changes_nothing():
    order, other = StampOrder(HOLD), StampOrder(HOLD)
    stamps = regular(60)
    assert released(order, stamps[:30]) == released(other, stamps[:30])
    with pytest.raises(LateSampleError, match=r'0\.100000 s older than a sample that was used'):
        order.add(stamps[9] + 1, None)
    assert released(order, stamps[30:]) == released(other, stamps[30:])


@pytest.mark.parametrize('back', [0, 1, 5, 10])
def test_repeated_stamp_is_refused_waiting_or_handed_on(back):
    order = StampOrder(HOLD)
    stamps = regular(30)
    released(order, stamps)
    with pytest.raises(RepeatedStampError):
        order.add(stamps[29 - back], None)
    assert order.restarts == 0


def test_stamp_zero_is_refused():
    with pytest.raises(ZeroStampError):
        StampOrder(HOLD).add(0, None)


def test_a_second_back_is_a_restart_and_less_is_not():
    order = StampOrder(0.9)
    order.add(START_NS, 'newest')
    order.add(START_NS - 899_999_999, 'late')
    assert order.restarts == 0
    assert order.add(START_NS - 1_000_000_000, 'anew') == []
    assert order.restarts == 1
    assert order.add(START_NS, 'later') == [(START_NS - 1_000_000_000, 'anew')]


def test_no_more_than_the_limit_wait():
    order = StampOrder(0.9, limit=5)
    assert released(order, regular(12)) == regular(7)
    assert released(order, [regular(13)[-1]]) == [regular(8)[-1]]


def test_reset_forgets_stamps():
    order = StampOrder(HOLD)
    released(order, regular(30))
    order.reset()
    assert released(order, regular(15)) == regular(5)
    assert order.restarts == 0
