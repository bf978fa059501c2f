"""ZSTAR: greeted, set to its range and polled, whatever happens on the way."""

import pickle
from dataclasses import fields
from math import inf

import pytest
from conversation import Conversation, errors, measured, readings
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.errors import BoardError, CutError, FrameError, SettingsError
from dead_reckoning.sources.driver import serial_receiver
from dead_reckoning.sources.serial.protocols import Reading
from dead_reckoning.sources.serial.protocols.zstar import ZstarBoard, ZstarDecoder, ZstarSettings

LEVEL = (130.0, 126.0, 190.0)


def pair(**settings):
    """Return a decoder and a board, both of the same settings."""
    chosen = ZstarSettings(**settings)
    return ZstarDecoder(chosen), ZstarBoard(chosen)


def polled(**settings):
    """Return a decoder that has just polled, by the bytes of the reference manual."""
    made = ZstarDecoder(ZstarSettings(**settings))
    digit = (1.5, 2.0, 4.0, 6.0).index(made.range_g)
    said = []
    for answer in (b'N', b'%d' % digit):
        said.append(made.due(inf))
        assert made.feed(answer) == []
    assert said == [b'R', b'G']
    assert made.due(0.1) == settings.get('request', 'v').encode()
    return made


@pytest.mark.parametrize(
    ('request_', 'answer', 'values'),
    [
        ('V', b'x\x80y\x81z\xbe', (128.0, 129.0, 190.0)),
        ('v', b'x\x80y\x81z\xbeb\x02', (128.0, 129.0, 190.0)),
        ('V', b'x\x00y\xffz\x0a', (0.0, 255.0, 10.0)),
        ('V', b'xyyzzx', (121.0, 122.0, 120.0)),
        ('V', b'xxyyzz', (120.0, 121.0, 122.0)),
        ('v', b'xxyyzzbb', (120.0, 121.0, 122.0)),
    ],
)
def test_answers_of_the_manual(request_, answer, values):
    assert polled(request=request_).feed(answer) == [Reading(values, 2)]


@pytest.mark.parametrize('value', [b'2', b'\x02'])
def test_a_g_select_comes_as_a_digit_or_as_a_number(value):
    made = ZstarDecoder(ZstarSettings(range_g=4.0))
    made.due(inf)
    made.feed(b'N')
    made.due(inf)
    assert made.feed(value) == []
    assert made.due(inf) == b'v'


@given(
    st.lists(st.tuples(*[st.integers(0, 255).map(float)] * 3), min_size=30, max_size=30),
    st.lists(st.integers(1, 9), min_size=1, max_size=5),
    st.sampled_from(['V', 'v']),
)
def test_what_the_board_measures_is_read_however_it_is_cut(values, sizes, request_):
    talk = Conversation(*pair(request=request_, poll_rate=100.0), sizes)
    assert readings(talk.run(0.3, values.__getitem__)) == values[1:]
    assert errors(talk.events) == []


def test_the_range_is_set_after_a_greeting_and_verified():
    talk = Conversation(*pair(range_g=4.0))
    talk.run(1.0, LEVEL)
    assert talk.told[:5] == [b'R', b'G', b'g2', b'G', b'v']
    assert set(readings(talk.events)) == {LEVEL}
    assert errors(talk.events) == []


def test_a_board_that_has_its_range_is_told_none():
    talk = Conversation(*pair())
    talk.run(3.0, LEVEL)
    assert set(talk.told) == {b'R', b'G', b'v'}


@pytest.mark.parametrize('range_g', [1.5, 2.0, 4.0, 6.0])
def test_values_are_those_of_the_range(range_g):
    """The board starts at ±1.5 g, and says values of that until it has its range."""
    decoder, board = pair(range_g=range_g)
    board.measure(measured((128.0, 128.0, 140.0)))
    before = board.hear(b'V')
    talk = Conversation(decoder, board)
    talk.run(1.0, (128.0, 128.0, 140.0))
    assert set(readings(talk.events)) == {(128.0, 128.0, 140.0)}
    assert (before == board.hear(b'V')) is (range_g == 1.5)


def test_while_the_radio_is_down_no_channel_is_selected():
    decoder, board = pair(range_g=6.0)
    waited = inf
    for _ in range(1000):
        told = decoder.due(waited)
        assert told in (b'', b'R')
        assert board.hear(told) == b''
        waited = 0.0 if told else waited + 0.01
    assert board.channel is None
    board.hear(b'B')
    assert board.channel == 11


class DeafBoard(ZstarBoard):
    """It takes no g-select."""

    def _select(self, range_):
        return b''


def test_a_range_that_is_not_taken_is_said_and_told_again_and_nothing_is_read():
    settings = ZstarSettings(range_g=6.0)
    talk = Conversation(ZstarDecoder(settings), DeafBoard(settings))
    talk.run(5.0, LEVEL)
    assert readings(talk.events) == []
    assert len(talk.events) == talk.told.count(b'g3') - 1 >= 5
    for error in talk.events:
        assert isinstance(error, BoardError)
        for named in ('g-select 0', '1.5 g', '6 g', 'driver.serial.zstar.range_g'):
            assert named in str(error)


def test_a_sensor_that_was_switched_off_and_on_gets_its_range_back():
    settings = ZstarSettings(range_g=2.0)
    talk = Conversation(ZstarDecoder(settings), ZstarBoard(settings))
    talk.run(2.0, LEVEL)
    talk.board = ZstarBoard(settings)
    (error,) = errors(talk.run(3.0, LEVEL))
    assert isinstance(error, BoardError)
    assert set(readings(talk.run(2.0, LEVEL))) == {LEVEL}
    assert errors(talk.events) == [error]


def test_a_stick_that_was_reset_is_greeted_again_once_it_is_silent():
    settings = ZstarSettings()
    talk = Conversation(ZstarDecoder(settings), ZstarBoard(settings))
    talk.run(1.0, LEVEL)
    silent, told = talk.board.measure, len(talk.told)
    talk.board.measure = lambda measurement: b''
    talk.board.hear = lambda data: b''
    assert talk.run(5.0, LEVEL) == []
    assert talk.told[told:].count(b'R') > 10
    assert not set(talk.told[-10:]) - {b'R'}
    del talk.board.hear
    talk.board.measure = silent
    assert set(readings(talk.run(1.0, LEVEL))) == {LEVEL}


@given(st.integers(0, 200), st.sampled_from(['lost', 'doubled', 'noise']), st.integers(1, 7))
def test_damage_costs_the_reading_it_hits(at, kind, size):
    talk = Conversation(*pair(range_g=4.0, poll_rate=100.0), [size])
    sent = 0

    def damage(data):
        nonlocal sent
        begin, sent = sent, sent + len(data)
        hit = at - begin
        if not 0 <= hit < len(data):
            return data
        put = {'lost': b'', 'doubled': data[hit : hit + 1] * 2, 'noise': b'\xfe\xfe'}[kind]
        return data[:hit] + put + data[hit + 1 :]

    talk.damage = damage
    talk.run(4.0, LEVEL)
    assert set(readings(talk.events)) == {LEVEL}
    assert len(errors(talk.events)) <= 2
    assert all(isinstance(error, FrameError) for error in errors(talk.events))
    late = talk.run(0.5, LEVEL)
    assert len(readings(late)) >= 48
    assert errors(late) == []


def test_bytes_before_an_answer_do_not_hide_it_and_are_said():
    made = polled(request='V')
    assert made.feed(b'\xffx\x80y\x81z\xbe') == [Reading((128.0, 129.0, 190.0), 3)]
    assert made.due(0.5) == b'V'
    error, reading = made.feed(b'x\x80y\x81z\xbe')
    assert isinstance(error, FrameError)
    assert reading == Reading((128.0, 129.0, 190.0), 9)


def test_an_answer_that_nobody_asked_for_is_no_reading():
    made = polled(request='V')
    assert len(made.feed(b'x\x80y\x81z\xbe' * 2)) == 1
    assert made.feed(b'x\x80y\x81z\xbe') == []


@pytest.mark.parametrize('text', [b'0', b'N0', b'1.5\r\n', b'NN', b'RX 200\r\n', b'N' * 40])
def test_text_is_not_taken_for_an_answer(text):
    """The debug mode talks unasked, and the greeting ends it."""
    made = ZstarDecoder(ZstarSettings())
    made.due(inf)
    made.feed(text)
    assert made.due(inf) == b'R'
    assert [type(event) for event in made.feed(b'N')] == [FrameError]
    assert made.due(inf) == b'G'
    made.feed(b'0' + text)
    assert made.due(inf) == b'R'


def test_debug_mode_is_ended():
    decoder, board = pair()
    board.measure(measured(LEVEL))
    board.hear(b'U')
    assert board.measure(measured(LEVEL)) != b''
    talk = Conversation(decoder, board)
    talk.run(2.0, LEVEL)
    assert set(readings(talk.events)) == {LEVEL}
    assert board.measure(measured(LEVEL)) == b''


@given(
    st.lists(
        st.binary(max_size=8) | st.sampled_from([b'N', b'0', b'3', b'x\x80y\x81z\xbe']),
        max_size=40,
    )
)
def test_whatever_comes_no_channel_is_selected(answers):
    """A digit is told only behind a g, and that only to a board that has answered with its own."""
    decoder = ZstarDecoder(ZstarSettings(range_g=4.0))
    told, last = [b''], b''
    for answer in answers:
        told.append(decoder.due(inf))
        assert told[-1] in (b'R', b'G', b'v', b'g2')
        if told[-1] == b'g2':
            assert told[-2] == b'G'
            assert last in (b'0', b'1', b'3', b'\0', b'\1', b'\3')
        last = answer
        decoder.feed(answer)


@pytest.mark.parametrize('poll_rate', [1.0, 7.0, 30.0, 40.0, 50.0, 100.0])
def test_it_is_polled_as_often_as_asked_and_its_range_once_a_second(poll_rate):
    """Though it can be told something only each hundredth of a second."""
    talk = Conversation(*pair(poll_rate=poll_rate))
    talk.run(20.0, LEVEL)
    assert talk.told.count(b'v') == pytest.approx(20.0 * poll_rate, abs=3.0)
    assert 10 <= talk.told.count(b'G') <= 21


def test_an_answer_that_never_comes_is_asked_for_again():
    made = polled()
    assert made.due(0.19) == b''
    assert [made.due(0.2) for _ in range(4)] == [b'v', b'v', b'v', b'R']


def test_an_answer_that_stops_half_way_is_asked_for_again_sooner():
    made = polled()
    made.feed(b'x\x80y')
    assert made.due(0.04) == b''
    assert made.due(0.05) == b'v'


def test_a_restart_forgets_the_answer_that_has_begun_and_greets():
    made = polled()
    made.feed(b'x\x80')
    (cut,) = made.restart()
    assert isinstance(cut, CutError)
    assert made.due(inf) == b'R'
    assert made.feed(b'y\x81z\xbe') == []
    assert made.goodbye() == b''


def test_answers_beside_the_readings():
    board = ZstarBoard(ZstarSettings())
    board.measure(measured((-5.0, 300.0, 127.5)))
    assert board.hear(b'V') == b'x\x00y\xffz\x80'
    assert board.hear(b'v') == b'x\x00y\xffz\x80b\x00'
    assert board.hear(b'K') == b'X\x80\xbeY\x80\xbeZ\x80\xbe'
    assert board.hear(b'rI')[:6] == b'ZZSTAR'
    assert board.hear(b'g7G') == b'0'


def test_two_ranges_of_one_board_are_refused():
    values = {'driver.serial.protocol': 'zstar', 'driver.range_g': 2.0, 'driver.adc_bits': 8}
    with pytest.raises(SettingsError, match=r'driver\.serial\.zstar\.range_g.*1\.5.*2;'):
        serial_receiver(Configuration(values))
    serial_receiver(Configuration({**values, 'driver.serial.zstar.range_g': 2}))
    assert 'range_g' in {field.name for field in fields(ZstarSettings)}


@given(
    st.lists(
        st.lists(
            st.binary(max_size=12)
            | st.sampled_from(
                [b'N', b'0', b'\0', b'x\x80y\x81z\xbeb\0', b'x\x80y\x81', b'x' * 30]
            ),
            max_size=4,
        ),
        max_size=12,
    ),
    st.integers(1, 20),
)
def test_answers_give_the_same_however_they_are_cut(answers, size):
    whole, cut = (ZstarDecoder(ZstarSettings()) for _ in range(2))
    for decoder in (whole, cut):
        for answer in (b'N', b'0'):
            decoder.due(inf)
            decoder.feed(answer)
    for parts in answers:
        assert cut.due(inf) == whole.due(inf)
        data = b''.join(parts)
        events = []
        for at in range(0, len(data), size):
            events += cut.feed(data[at : at + size])
        assert list(map(repr, events)) == list(map(repr, whole.feed(data)))
        assert len(pickle.dumps(cut)) < 2048
