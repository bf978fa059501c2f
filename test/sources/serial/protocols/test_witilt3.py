"""WiTilt v3: started through its menu, framed, counted."""

import pickle
from math import inf

import pytest
from conversation import Conversation, errors, measured, readings
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import BoardError, CutError, FrameError, SettingsError
from dead_reckoning.sources.serial.protocols import Reading
from dead_reckoning.sources.serial.protocols.witilt3 import (
    CHANNELS,
    MENU,
    Witilt3Board,
    Witilt3Decoder,
    Witilt3Settings,
)

LEVEL = (520.0, 500.0, 764.0)
GOLDEN = b'#@\x00\x01\x02\x08\x01\xf4\x02\xfc\x02\x00$'
numbers = st.integers(0, 1023)


def pair(**settings):
    """Return a decoder and a board, both of the same settings."""
    chosen = Witilt3Settings(**settings)
    return Witilt3Decoder(chosen), Witilt3Board(chosen)


def decoder(**settings):
    """Return a decoder alone."""
    return Witilt3Decoder(Witilt3Settings(**settings))


def frame(count, *values):
    """Return a frame."""
    raw = b''.join(value.to_bytes(2, 'big') for value in values)
    return b'#@' + count.to_bytes(2, 'big') + raw + b'$'


def stream(first, last):
    """Return frames with counts as the board counts, 0x0A left out."""
    counts = [n % 0x10000 for n in range(first, last + 1) if n & 0xFF != 0x0A]
    return [frame(count, 520, 500, 764, 512) for count in counts]


def clocks(events):
    """Return the clocks of readings."""
    return [event.clock for event in events if isinstance(event, Reading)]


def test_a_frame_of_13_bytes():
    assert len(GOLDEN) == 13
    assert decoder().feed(GOLDEN) == [Reading(LEVEL, 0, 1.0)]


@pytest.mark.parametrize('channels', CHANNELS)
def test_channels_make_the_length_of_a_frame(channels):
    values = {'x': 1, 'y': 2, 'z': 3, 'b': 700, 'r': 612}
    data = frame(1, *(values[channel] for channel in channels))
    assert len(data) == 5 + 2 * len(channels)
    settings = {'rate_axis': 'z', 'rate_scale': 0.01} if 'r' in channels else {}
    (reading,) = decoder(channels=channels, **settings).feed(data)
    assert reading.values == (1.0, 2.0, 3.0)
    assert reading.rate == (pytest.approx((0.0, 0.0, 1.0)) if 'r' in channels else None)


@pytest.mark.parametrize(
    ('axis', 'rate'), [('x', (-0.5, 0.0, 0.0)), ('y', (0.0, -0.5, 0.0)), ('-', None)]
)
def test_the_rate_is_about_one_axis_and_unused_unless_asked_for(axis, rate):
    made = decoder(rate_axis=axis, rate_zero=502.0, rate_scale=-0.05)
    assert made.feed(GOLDEN)[0].rate == (rate and pytest.approx(rate))


def test_a_rate_that_no_frame_holds_is_refused():
    with pytest.raises(SettingsError, match=r'driver\.serial\.witilt3\.rate_axis'):
        Witilt3Settings(channels='xyzb', rate_axis='z')


@given(
    st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=40),
    st.lists(st.integers(1, 40), min_size=1, max_size=5),
    st.sampled_from(CHANNELS),
)
def test_what_the_board_measures_is_read_however_it_is_cut(values, sizes, channels):
    talk = Conversation(*pair(channels=channels), sizes)
    talk.run(2.0, LEVEL)
    del talk.events[:]
    counts = [tuple(map(float, value)) for value in values]
    talk.run(len(counts) / 100.0, counts.__getitem__)
    got = readings(talk.run(0.02, LEVEL))
    assert readings(talk.events) == [*counts, *got]
    assert errors(talk.events) == []


def test_the_menu_is_gone_through_and_the_board_stopped_at_the_end():
    talk = Conversation(*pair())
    talk.run(3.0, LEVEL)
    assert talk.told == [b'A', b'x', b' ', b'1', b'S']
    assert {type(error) for error in errors(talk.events)} == {CutError}
    assert clocks(talk.events) == [float(n) for n in range(1, 180)]
    talk.board.hear(talk.decoder.goodbye())
    assert talk.board.measure(measured(LEVEL)) == b''


def test_a_board_that_sends_already_is_stopped_and_started():
    decoder_, board = pair()
    board.hear(b' 1S')
    talk = Conversation(decoder_, board)
    talk.run(4.0, LEVEL)
    assert talk.told == [b'A', b'x', b' ', b'1', b'S']
    assert len(readings(talk.events)) > 250


def test_a_board_that_is_reset_is_started_again_and_its_clock_goes_back():
    talk = Conversation(*pair())
    talk.run(3.0, LEVEL)
    talk.board = Witilt3Board(Witilt3Settings())
    again = talk.run(4.0, LEVEL)
    assert talk.told == [b'A', b'x', b' ', b'1', b'S'] * 2
    assert clocks(again)[0] == 1.0
    assert len(readings(again)) > 130


def test_without_its_menu_the_board_is_told_nothing():
    made = decoder(menu=False)
    assert made.due(inf) == made.goodbye() == b''
    assert made.feed(GOLDEN) == [Reading(LEVEL, 0, 1.0)]
    assert made.due(100.0) == b''


def test_a_board_that_does_not_answer_is_told_again():
    made, waited, told = decoder(), inf, []
    for _ in range(1000):
        said = made.due(waited)
        told += [said] if said else []
        waited = 0.0 if said else waited + 0.01
    assert told[:10] == [b'A', b'x', b' ', b'1', b'S'] * 2
    assert 15 < len(told) < 30


def test_the_range_of_the_menu_is_compared():
    chosen = Witilt3Settings(range_g=4.0)
    talk = Conversation(decoder(), Witilt3Board(chosen), [3])
    said = [error for error in errors(talk.run(3.0, LEVEL)) if isinstance(error, BoardError)]
    assert said
    assert '±4 g' in str(said[0])
    assert 'driver.serial.witilt3.range_g ±1.5 g' in str(said[0])


def test_a_count_that_leaves_out_0a_is_neither_a_loss_nor_a_jump():
    made = decoder()
    events = made.feed(b''.join(stream(1, 0x20200)))
    assert errors(events) == []
    assert clocks(events) == [float(n + 1) for n in range(len(events))]


def test_a_count_that_does_not_is_as_good():
    data = b''.join(frame(n % 0x10000, 1, 2, 3, 4) for n in range(1, 0x10200))
    assert clocks(decoder().feed(data)) == [float(n) for n in range(1, 0x10200)]


@given(st.integers(1, 600), st.integers(0, 40))
def test_the_clock_counts_what_was_lost(at, lost):
    data = stream(1, 1000)
    events = decoder().feed(b''.join(data[:at] + data[at + lost :]))
    wanted = [float(n + 1) for n in range(len(data)) if not at <= n < at + lost]
    assert clocks(events) == wanted


@given(
    st.integers(0, 12),
    st.integers(0, 200),
    st.lists(st.integers(1, 40), min_size=1, max_size=5),
    st.sampled_from(['lost', 'doubled', 'flipped']),
)
def test_damage_costs_the_frame_it_hits(at, after, sizes, kind):
    """What a flipped bit makes of a number no one can tell."""
    good = stream(1, 250)
    hit = good[after]
    put = {'lost': b'', 'doubled': hit[at : at + 1] * 2, 'flipped': bytes([hit[at] ^ 0x80])}[kind]
    bad = hit[:at] + put + hit[at + 1 :]
    data, cuts = b''.join([*good[:after], bad, *good[after + 1 :]]), iter(sizes * 5000)
    made, events = decoder(), []
    while data:
        size = next(cuts)
        events += made.feed(data[:size])
        data = data[size:]
    right = [event for event in events if isinstance(event, Reading) and event.values == LEVEL]
    assert len(right) >= len(good) - 1
    assert len(errors(events)) <= 1


@given(st.binary(max_size=400).filter(lambda noise: b'#' not in noise), st.booleans())
def test_after_garbage_the_next_frame_is_read(noise, in_step):
    made = decoder()
    before = GOLDEN if in_step else b''
    made.feed(before)
    *_, reading = made.feed(noise + frame(2, 520, 500, 764, 512))
    assert reading.values == LEVEL
    assert reading.start == len(before) + len(noise)


def test_letters_of_the_frame_in_the_frame():
    """A count of 0x2340 reads #@, and numbers end in $."""
    data = b''.join(frame(n, 0x124, 0x223, 0x340, 0x24) for n in range(0x233E, 0x2345))
    events = decoder().feed(b'\x23' + data)
    assert [type(event) for event in events] == [CutError] + [Reading] * 7
    assert {event.values for event in events[1:]} == {(292.0, 547.0, 832.0)}


def test_a_false_lock_is_left():
    """The end of a frame that was cut, and the beginning of the next, look like one."""
    cut = frame(0x2340, 0x100, 0x101, 0x102, 0x103)[2:]
    events = decoder().feed(cut + b''.join(stream(0x2341, 0x2350)))
    assert len(readings(events)) == 16
    assert set(readings(events)) == {LEVEL}


@pytest.mark.parametrize('value', [1024, 0x8000, 0xFFFF])
def test_a_number_that_no_converter_of_10_bits_gives_makes_no_frame(value):
    made = decoder()
    made.feed(GOLDEN)
    events = made.feed(frame(2, value, 1, 2, 3) + b''.join(stream(3, 5)))
    assert [type(event) for event in events] == [FrameError] + [Reading] * 3


def test_a_frame_that_comes_twice_is_read_once():
    data = stream(1, 3)
    events = decoder().feed(data[0] + data[0] + data[1] + data[1] + data[2])
    assert clocks(events) == [1.0, 2.0, 3.0]
    assert len(errors(events)) == 2


@pytest.mark.parametrize('bit', [0x80, 0x40, 0x08, 0x01])
def test_a_disturbed_count_costs_its_frame_and_leaves_the_clock_alone(bit):
    data = stream(1, 60)
    data[50] = data[50][:2] + bytes([data[50][2] ^ bit]) + data[50][3:]
    events = decoder().feed(b''.join(data))
    assert clocks(events) == [float(n + 1) for n in range(59) if n != 50]
    assert len(errors(events)) == 1


def test_a_count_that_begins_anew_is_believed_with_its_second_frame():
    events = decoder().feed(b''.join(stream(1000, 1003) + stream(1, 3)))
    assert clocks(events)[-2:] == [2.0, 3.0]
    assert len(errors(events)) == 1


def test_other_channels_than_the_boards_are_said_once():
    made = decoder(channels='xyz')
    events = made.feed(b''.join(stream(1, 2000)))
    (error,) = events
    assert isinstance(error, FrameError)
    assert 'driver.serial.witilt3.channels' in str(error)


def test_the_menu_is_no_fault():
    made = decoder()
    made.feed(b'm' * (MENU - 40))
    assert [type(event) for event in made.feed(GOLDEN)] == [CutError, Reading]


def test_a_restart_in_a_frame_is_a_cut():
    made = decoder()
    made.feed(GOLDEN + GOLDEN[:5])
    (cut,) = made.restart()
    assert isinstance(cut, CutError)
    assert [type(e) for e in made.feed(GOLDEN[5:] + GOLDEN)] == [CutError, Reading]
    assert made.due(inf) == b'A'


def test_the_board_counts_from_1_and_leaves_out_0a():
    _, board = pair(channels='xyzbr', rate_axis='y', rate_scale=0.01)
    board.hear(b' 1S')
    sent = [board.measure(measured((-3.0, 2000.0, 511.5), (9.0, 1.0, 9.0))) for _ in range(12)]
    assert [data[3] for data in sent] == [1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13]
    assert sent[0][4:] == b'\x00\x00\x03\xff\x02\x00\x02\xbc\x02\x64$'


pieces = st.lists(
    st.binary(max_size=6)
    | st.sampled_from(
        [
            *stream(1, 4),
            *stream(0x233F, 0x2341),
            frame(0x2340, 0x23, 0x40, 0x24, 0x223),
            *(b'#', b'#@', b'$', b'm' * 600),
            *(b'Sensor Range (2g)', b'Range (1.5g)', b'Range (1.2.g)'),
        ]
    ),
    max_size=30,
)


@given(pieces, st.lists(st.integers(1, 40), min_size=1, max_size=5))
def test_a_disturbed_stream_gives_the_same_however_it_is_cut(parts, sizes):
    data = b''.join(parts)
    whole, cut = decoder(), decoder()
    wanted = whole.feed(data)
    events, at = [], 0
    for size in sizes * (len(data) + 1):
        events += cut.feed(data[at : at + size])
        at += size
        assert len(pickle.dumps(cut)) < 2048
        if at >= len(data):
            break
    assert list(map(repr, events)) == list(map(repr, wanted))
