"""Two streams of one moment find each other, and what gets lost is said."""

import weakref

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.pairing import StampPairs

END = 1_000_000


def interleave(pairs, left, right, turns):
    """Feed two streams in their own orders, the turns deciding whose it is; return the pairs."""
    left, right, found = list(left), list(right), []
    turns = iter(turns)
    while left or right:
        take_left = bool(left) and (not right or next(turns, True))
        stamp = (left if take_left else right).pop(0)
        side = pairs.left if take_left else pairs.right
        pair = side(stamp, f'left {stamp}' if take_left else f'right {stamp}')
        if pair is not None:
            found.append(pair)
    return found


def expected(stamps):
    return [(f'left {stamp}', f'right {stamp}') for stamp in stamps]


@given(st.lists(st.booleans(), max_size=100))
def test_any_interleaving_of_complete_streams_pairs_all(turns):
    pairs = StampPairs()
    stamps = range(1, 51)
    assert interleave(pairs, stamps, stamps, turns) == expected(stamps)
    assert pairs.collect_lost('a', 'b') is None


@given(
    st.sets(st.integers(1, 40)), st.sets(st.integers(1, 40)), st.lists(st.booleans(), max_size=80)
)
def test_what_both_streams_have_is_paired_and_the_rest_reported(left, right, turns):
    """A last pair, END, closes the case: nothing may still wait behind it."""
    pairs = StampPairs()
    found = interleave(pairs, [*sorted(left), END], [*sorted(right), END], turns)
    assert found == expected([*sorted(left & right), END])
    lost = pairs.collect_lost('a', 'b')
    alone = left ^ right
    if not alone:
        assert lost is None
    else:
        assert str(lost).startswith(f'{len(alone)} sample')
    assert pairs.collect_lost('a', 'b') is None


def test_lost_samples_are_reported_once_with_names_and_remedy():
    pairs = StampPairs()
    pairs.left(1, 'a')
    pairs.left(2, 'b')
    assert pairs.collect_lost('imu/linear_acceleration', 'imu/data') is None
    assert pairs.right(2, 'B') == ('b', 'B')
    said = str(pairs.collect_lost('imu/linear_acceleration', 'imu/data'))
    assert said.startswith('1 sample from stamp 1 ns on')
    assert 'imu/linear_acceleration and imu/data' in said
    assert 'qos_overrides' in said
    assert pairs.collect_lost('imu/linear_acceleration', 'imu/data') is None


def test_what_waits_on_the_side_that_completes_the_pair_is_let_go_too():
    pairs = StampPairs()
    pairs.right(1, 'A')
    pairs.left(2, 'b')
    assert pairs.right(2, 'B') == ('b', 'B')
    assert str(pairs.collect_lost('a', 'b')).startswith('1 sample from stamp 1 ns')


def test_stamps_that_start_over_pair_again():
    """A looped recording: what still waited from the first round is let go."""
    pairs = StampPairs()
    assert interleave(pairs, [8, 9], [8, 9], []) == expected([8, 9])
    pairs.left(10, 'left 10')
    assert interleave(pairs, [1, 2], [1, 2], []) == expected([1, 2])
    assert str(pairs.collect_lost('a', 'b')).startswith('1 sample from stamp 10 ns')


@pytest.mark.parametrize('side', ['left', 'right'])
def test_memory_is_bounded(side):
    class Sample:
        pass

    pairs = StampPairs(limit=10)
    alive = weakref.WeakSet()
    lost = 0
    for stamp in range(1, 1001):
        sample = Sample()
        alive.add(sample)
        assert getattr(pairs, side)(stamp, sample) is None
        del sample
        error = pairs.collect_lost('a', 'b')
        lost += int(str(error).split()[0]) if error else 0
    assert len(alive) == 10
    assert lost == 990


def test_a_partner_far_behind_is_waited_for():
    """A recording played as fast as it goes: one stream is ahead by seconds."""
    pairs = StampPairs()
    stamps = [stamp * 10_000_000 for stamp in range(1, 1001)]
    turns = [True] * 1000
    assert interleave(pairs, stamps, stamps, turns) == expected(stamps)
    assert pairs.collect_lost('a', 'b') is None


def test_what_begins_after_a_restart_is_not_taken_for_passed():
    pairs = StampPairs()
    second = 1_000_000_000
    assert pairs.right(second, 'anew') is None
    assert pairs.left(10 * second, 'of the round before') is None
    assert pairs.left(second, 'anew') == ('anew', 'anew')
