"""Frames of an MIT Wocket: golden frames, cuts, garbage, and what a false lock costs."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import CutError, FrameError
from dead_reckoning.sources.serial.protocols import Measurement, Reading
from dead_reckoning.sources.serial.protocols.wockets import (
    LENGTH,
    WocketsBoard,
    WocketsDecoder,
    WocketsSettings,
)

count = st.integers(0, 1023)
counts = st.lists(st.tuples(count, count, count), min_size=1, max_size=12)

GOLDEN = bytes([0x96, 0x55, 0x62, 0x2D, 0x7F])
"""Sensor 5; x 10 1010 1011, y 10 0010 0101, z 10 1111 1111 in bits."""


def decoder(**settings):
    return WocketsDecoder(WocketsSettings(**settings))


def sent(many, number=-1):
    """Return the frames of a board for many counts."""
    board = WocketsBoard(WocketsSettings(id=number))
    nothing = (0.0, 0.0, 0.0)
    return [
        board.measure(Measurement({'counts': v}, 0.0, nothing, (0.0, 0.0, 0.0, 1.0), nothing))
        for v in many
    ]


def test_golden_frame_both_ways():
    values = (0b1010101011, 0b1000100101, 0b1011111111)
    assert decoder().feed(GOLDEN) == [Reading(tuple(map(float, values)), 0)]
    assert sent([values], 5) == [GOLDEN]


def test_a_board_keeps_counts_within_ten_bits():
    assert sent([(-3.0, 1024.0, 511.6)]) == sent([(0, 1023, 512)])


@given(counts, st.integers(1, 12), st.integers(0, 7))
def test_what_was_sent_is_read_at_any_cut(many, length, number):
    data = b''.join(sent(many, number))
    made = decoder(id=number)
    events = [e for at in range(0, len(data), length) for e in made.feed(data[at : at + length])]
    assert [event.values for event in events] == many
    assert [event.start for event in events] == [LENGTH * k for k in range(len(many))]


def test_frames_of_another_sensor_are_passed_over():
    (mine,), (other,) = sent([(1, 2, 3)], 2), sent([(4, 5, 6)], 3)
    assert [e.values for e in decoder(id=2).feed(other + mine + other)] == [(1.0, 2.0, 3.0)]
    assert len(decoder().feed(other + mine + other)) == 3


@given(st.binary(max_size=40), counts)
def test_after_any_garbage_the_next_frame_is_read(garbage, many):
    events = decoder().feed(garbage + b''.join(sent(many)))
    assert [event.values for event in events[-len(many) :]] == many


@pytest.mark.parametrize('place', range(LENGTH))
def test_a_lost_byte_costs_its_frame_alone(place):
    before, hit, after = sent([(1, 2, 3), (300, 400, 500), (600, 700, 800)])
    data = before + hit[:place] + hit[place + 1 :] + after
    first, error, last = decoder().feed(data)
    assert (first.values, last.values) == ((1.0, 2.0, 3.0), (600.0, 700.0, 800.0))
    assert isinstance(error, FrameError)
    assert 'driver.serial.baud' in str(error)


def test_garbage_is_said_once_until_the_next_frame():
    made = decoder()
    good = sent([(1, 2, 3)])[0]
    kinds = [type(e) for e in made.feed(good + b'\xff' * 1000 + b'\0' * 1000 + good + b'\xe0')]
    assert kinds == [Reading, FrameError, Reading, FrameError]


def test_what_comes_before_the_first_frame_was_cut():
    made = decoder()
    good = sent([(1, 2, 3)])[0]
    assert [type(e) for e in made.feed(good[2:] + good + good[:3])] == [CutError, Reading]
    assert [type(e) for e in made.restart()] == [CutError]
    assert made.restart() == []
    (cut, reading) = made.feed(good[3:] + good)
    assert isinstance(cut, CutError)
    assert reading == Reading((1.0, 2.0, 3.0), 11 + 2)
