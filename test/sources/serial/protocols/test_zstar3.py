"""ZSTAR3: values of 16 bits in either order, with a sign or without."""

from math import inf

import pytest
from conversation import Conversation, errors, measured, readings
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import BoardError, FrameError
from dead_reckoning.sources.serial.protocols import Reading
from dead_reckoning.sources.serial.protocols.zstar3 import (
    Zstar3Board,
    Zstar3Decoder,
    Zstar3Settings,
)

LEVEL = (33_000.0, 32_500.0, 48_600.0)


def pair(**settings):
    """Return a decoder and a board, both of the same settings."""
    chosen = Zstar3Settings(**settings)
    return Zstar3Decoder(chosen), Zstar3Board(chosen)


@pytest.mark.parametrize(
    ('settings', 'values'),
    [
        ({}, (32769.0, 32767.0, 48640.0)),
        ({'signed': False}, (1.0, 65535.0, 15872.0)),
        ({'byte_order': 'little'}, (33024.0, 32767.0, 32830.0)),
        ({'byte_order': 'little', 'signed': False}, (256.0, 65535.0, 62.0)),
    ],
)
@pytest.mark.parametrize('request_', ['V', 'v'])
def test_order_and_sign_are_parameters(settings, values, request_):
    made = Zstar3Decoder(Zstar3Settings(request=request_, **settings))
    assert made.due(inf) == b'r'
    made.feed(b'z')
    assert made.due(inf) == b'G'
    made.feed(b'0')
    assert made.due(0.1) == request_.encode()
    more = b's\0t\x01\x02b\x03\x04' if request_ == 'v' else b''
    assert made.feed(b'x\x00\x01y\xff\xffz\x3e\x00' + more) == [Reading(values, 2)]
    assert made.goodbye() == b'R'


@given(
    st.lists(st.tuples(*[st.integers(0, 0xFFFF).map(float)] * 3), min_size=30, max_size=30),
    st.lists(st.integers(1, 18), min_size=1, max_size=5),
    st.sampled_from(['V', 'v']),
    st.sampled_from(['big', 'little']),
    st.booleans(),
)
def test_what_the_board_measures_is_read_however_it_is_cut(values, sizes, request_, order, sign):
    settings = {'byte_order': order, 'signed': sign, 'request': request_}
    talk = Conversation(*pair(poll_rate=100.0, **settings), sizes)
    assert readings(talk.run(0.3, values.__getitem__)) == values[1:]
    assert errors(talk.events) == []


def test_a_range_is_answered_and_verified_all_the_same():
    talk = Conversation(*pair(range_g=4.0))
    talk.run(1.0, LEVEL)
    assert talk.told[:5] == [b'r', b'G', b'g2', b'G', b'V']
    assert talk.board.hear(b'g2') == b'G2'
    assert set(readings(talk.events)) == {LEVEL}
    assert errors(talk.events) == []


def test_a_board_that_was_reset_to_8_bits_is_set_to_16_again():
    settings = Zstar3Settings(range_g=2.0)
    talk = Conversation(Zstar3Decoder(settings), Zstar3Board(settings))
    talk.run(0.9, LEVEL)
    talk.board = Zstar3Board(settings)
    talk.board.measure(measured(LEVEL))
    assert len(talk.board.hear(b'V')) == 6
    said = errors(talk.run(3.0, LEVEL))
    assert {type(error) for error in said} == {FrameError, BoardError}
    assert set(readings(talk.run(2.0, LEVEL))) == {LEVEL}
    assert set(readings(talk.events)) == {LEVEL}


def test_in_8_bits_it_sends_the_high_bytes():
    _, board = pair(signed=False)
    board.measure(measured(LEVEL))
    assert board.hear(b'V') == b'x\x80y\x7ez\xbd'
    assert board.hear(b'rV') == b'zx\x80\xe8y\x7e\xf4z\xbd\xd8'
    assert board.hear(b'RV') == b'Nx\x80y\x7ez\xbd'


@given(st.integers(0, 150), st.booleans(), st.integers(1, 18))
def test_a_byte_that_is_lost_or_doubled_costs_the_reading_it_hits(at, lost, size):
    talk = Conversation(*pair(poll_rate=100.0, request='v'), [size])
    sent = 0

    def damage(data):
        nonlocal sent
        hit = at - sent
        sent += len(data)
        if not 0 <= hit < len(data):
            return data
        return data[:hit] + (b'' if lost else data[hit : hit + 1] * 2) + data[hit + 1 :]

    talk.damage = damage
    talk.run(3.0, LEVEL)
    assert set(readings(talk.events)) == {LEVEL}
    assert len(errors(talk.events)) <= 2
    assert len(readings(talk.run(0.5, LEVEL))) >= 48
