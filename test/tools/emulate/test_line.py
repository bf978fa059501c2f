"""The line of a board: when bytes arrive, and what becomes of them on the way."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.tools.emulate.faults import Faults
from dead_reckoning.tools.emulate.line import PAUSE, Line

BYTE = 0.001
MANY = bytes(range(256)) * 40


def line(seed=1, **faults):
    return Line(BYTE, Faults(**faults), seed)


def arrived(made):
    return made.take(float('inf'))


def test_bytes_arrive_one_after_the_other_at_the_rate_of_the_line():
    made = line()
    made.send(b'abc', 1.0)
    assert made.next == pytest.approx(1.001)
    assert [made.take(t) for t in (1.0005, 1.0011, 1.0032, 9.0)] == [b'', b'a', b'bc', b'']
    assert made.next == float('inf')


def test_bytes_wait_for_those_before_them():
    made = line()
    made.send(b'a' * 10, 1.0)
    made.send(b'b', 1.002)
    assert made.waiting(1.002) == pytest.approx(9.0)
    assert made.take(1.0105) == b'a' * 10
    assert made.take(1.0115) == b'b'
    assert made.waiting(2.0) == 0.0
    made.send(b'c', 3.0)
    assert made.next == pytest.approx(3.001)


@given(st.binary(max_size=200), st.integers(1, 50))
def test_without_faults_all_arrives_whenever_it_is_taken(data, steps):
    made = line()
    made.send(data, 0.0)
    assert b''.join(made.take(k * 0.2 / steps) for k in range(steps + 2)) == data


@pytest.mark.parametrize('fault', ['drop', 'flip', 'double'])
def test_a_fault_hits_as_many_bytes_as_it_says(fault):
    made = line(**{fault: 0.1})
    made.send(MANY, 0.0)
    got = arrived(made)
    if fault == 'flip':
        assert len(got) == len(MANY)
        turned = [(a ^ b).bit_count() for a, b in zip(MANY, got, strict=True)]
        assert set(turned) == {0, 1}
        assert len({a ^ b for a, b in zip(MANY, got, strict=True)}) == 9  # each bit, and none
        hit = sum(turned)
    else:
        hit = abs(len(got) - len(MANY))
        assert (len(got) < len(MANY)) == (fault == 'drop')
    assert hit == pytest.approx(0.1 * len(MANY), rel=0.15)


def test_a_lost_byte_takes_its_time_and_one_that_comes_twice_takes_it_twice():
    lost, twice = line(drop=1.0), line(double=1.0)
    lost.send(b'abc', 0.0)
    twice.send(b'abc', 0.0)
    assert arrived(lost) == b''
    assert lost.waiting(0.0) == pytest.approx(3.0)
    assert arrived(twice) == b'aabbcc'
    assert twice.waiting(0.0) == pytest.approx(6.0)


def test_a_pause_holds_what_comes_behind_it():
    made = line(pause=1.0)
    made.send(b'ab', 0.0)
    assert made.take(BYTE + 1e-9) == b'a'
    assert made.next == pytest.approx(2 * BYTE + PAUSE)


@given(st.lists(st.binary(max_size=60), max_size=10), st.integers(0, 9))
def test_faults_follow_from_the_seed_however_bytes_are_cut(parts, seed):
    some = {'drop': 0.1, 'flip': 0.1, 'double': 0.1, 'pause': 0.1}
    cut, whole = line(seed, **some), line(seed, **some)
    for part in parts:
        cut.send(part, 0.0)
    whole.send(b''.join(parts), 0.0)
    assert arrived(cut) == arrived(whole)
    assert cut.waiting(0.0) == pytest.approx(whole.waiting(0.0))


def test_another_seed_gives_other_faults():
    first, second = line(1, drop=0.1), line(2, drop=0.1)
    first.send(MANY, 0.0)
    second.send(MANY, 0.0)
    assert arrived(first) != arrived(second)


def test_what_was_under_way_is_lost_with_the_board():
    made = line()
    made.send(b'a' * 100, 0.0)
    made.clear()
    assert arrived(made) == b''
    assert made.waiting(0.0) == 0.0
