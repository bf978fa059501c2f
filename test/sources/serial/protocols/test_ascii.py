"""Lines of text: what is a reading, and why a line is none."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import (
    ColumnError,
    CutError,
    GarbledError,
    NumberError,
    OverlongError,
    ReadingError,
    SettingsError,
)
from dead_reckoning.sources.serial.lines import LONGEST
from dead_reckoning.sources.serial.protocols import Reading
from dead_reckoning.sources.serial.protocols.ascii import AsciiDecoder, AsciiSettings

numbers = st.floats(-9e8, 9e8) | st.integers(-70_000, 70_000).map(float)
readings = st.tuples(numbers, numbers, numbers)
garbage = st.binary(max_size=400)


def decoder(**settings):
    """Return a decoder that is in step."""
    made = AsciiDecoder(AsciiSettings(**settings))
    assert made.feed(b'\n') == []
    return made


def read(line, **settings):
    """Return the one event of one line."""
    (event,) = decoder(**settings).feed(line)
    return event


@given(
    st.lists(readings, max_size=10),
    st.sampled_from([',', ';', ', ', ' ', '\t', '|', ':', ' ; ']),
    st.sampled_from(['\n', '\r', '\r\n', '\n\n', '\n\r']),
)
def test_what_was_written_is_read(values, separator, end):
    text = ''.join(separator.join(map(repr, line)) + end for line in values)
    events = decoder(separator=separator).feed(text.encode())
    assert [event.values for event in events] == values


@pytest.mark.parametrize('order', list(itertools.permutations('xyz')))
@pytest.mark.parametrize('places', [(0, 1, 2), (1, 2, 3), (0, 2, 4), (3, 4, 5)])
def test_columns_say_where_the_axes_stand(order, places):
    columns = ['-'] * (places[-1] + 1)
    fields = ['t7'] * len(columns)
    for axis, place in zip(order, places, strict=True):
        columns[place] = axis
        fields[place] = str('xyz'.index(axis) + 1)
    line = ','.join(fields).encode() + b'\n'
    assert read(line, columns=''.join(columns)).values == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ('line', 'settings'),
    [
        (b'512,498,830\n', {}),
        (b'  512 , 498,830  \r\n', {}),
        (b'+512,498.,830.0\n', {}),
        (b'5.12e2,4980e-1,830\n', {}),
        (b'512\t498\t830\n', {'separator': '\t'}),
        (b'512   498 \t 830\n', {'separator': ' '}),
        (b'X:512\tY:498\tZ:830\n', {'separator': '\t'}),
        (b'X: 512\tY: 498\tZ: 830\n', {'separator': '\t'}),
        (b'X:512 Y:498\tZ:830\n', {'separator': ' '}),
        (b'X = 512: Y = 498: Z = 830\n', {'separator': ':'}),
        (b'X = 512: Y = 498: Z = 830\r\n', {'separator': ':'}),
        (b'ax=512;ay=498;az=830\n', {'separator': ';'}),
        (b'acc_y:498\tacc_x:512\tacc_z:830\n', {'separator': '\t', 'columns': 'yxz'}),
        (b'a1=512,a2=498,a3=830\n', {}),
        (b'Z:7,X:512,Y:498,Z:830\n', {'columns': '-xyz'}),
        (b'1234.5,512,498,830,ok\n', {'columns': '-xyz-'}),
    ],
)
def test_formats_of_boards(line, settings):
    assert read(line, **settings).values == (512.0, 498.0, 830.0)


@pytest.mark.parametrize(
    ('line', 'error', 'named'),
    [
        (b'1,2\n', ColumnError, "'1,2' has 2 columns"),
        (b'1,2,3,4\n', ColumnError, '4 columns'),
        (b'1,2,3,\n', ColumnError, '4 columns'),
        (b'1;2;3\n', ColumnError, 'driver.serial.ascii.separator'),
        (b'1,2,x\n', NumberError, "'x'"),
        (b'x,y,z\n', NumberError, 'heading'),
        (b'1,,3\n', NumberError, "''"),
        (b'1,2,nan\n', NumberError, 'nan'),
        (b'1,2,inf\n', NumberError, 'inf'),
        (b'1,2,1e999\n', NumberError, '1e999'),
        (b'1,2,' + b'9' * 60 + b'\n', NumberError, '9' * 40),
        (b'1,2,0x3\n', NumberError, '0x3'),
        (b'1,2,1_0\n', NumberError, '1_0'),
        (b'1,2,3 4\n', NumberError, "'3 4'"),
        (b'Y:1,X:2,Z:3\n', ColumnError, "'Y:1' in 'Y:1,X:2,Z:3' is where"),
        (b'ax=1,ay=2,ax=3\n', ColumnError, "'xyz' has z"),
        (b'1,2,\xb2\n', GarbledError, 'driver.serial.baud'),
        ('1,2,٣\n'.encode(), GarbledError, 'no text'),
        (b'1,2,3\0\n', GarbledError, r'\x00'),
        (b'1' * 257 + b'\n', OverlongError, '256 bytes'),
    ],
)
def test_what_is_no_reading_says_why(line, error, named):
    event = read(line)
    assert type(event) is error
    assert named in str(event)


def test_first_line_may_lack_its_beginning_and_is_never_a_reading():
    made = AsciiDecoder(AsciiSettings())
    cut, good = made.feed(b'12,498,830\n512,498,830\n')
    assert isinstance(cut, CutError)
    assert good.values == (512.0, 498.0, 830.0)


def test_a_start_between_two_lines_loses_no_reading():
    made = AsciiDecoder(AsciiSettings())
    (good,) = made.feed(b'\r\n512,498,830\r\n')
    assert good.values == (512.0, 498.0, 830.0)


def test_a_line_that_was_cut_by_a_restart_is_no_reading_and_neither_is_the_rest():
    made = decoder()
    assert made.feed(b'512,4') == []
    (lost,) = made.restart()
    assert isinstance(lost, CutError)
    cut, good = made.feed(b'98,8,30\n1,2,3\n')
    assert isinstance(cut, CutError)
    assert good.values == (1.0, 2.0, 3.0)


def test_lines_that_run_into_one_another_are_no_reading():
    assert isinstance(read(b'512,498,8512,498,830\n'), ColumnError)


@given(garbage, readings)
def test_after_any_garbage_the_next_whole_line_is_read(noise, values):
    made = decoder()
    line = ','.join(map(repr, values)).encode() + b'\n'
    assert made.feed(noise + b'\n' + line)[-1].values == values


@given(st.lists(st.binary(max_size=LONGEST).filter(lambda b: not {10, 13} & set(b))))
def test_each_line_is_one_event_and_blank_ones_are_none(lines):
    made = decoder()
    events = made.feed(b''.join(line + b'\n' for line in lines))
    assert len(events) == sum(bool(line.strip()) for line in lines)


@given(garbage.map(lambda b: b + b'\n'), readings)
def test_a_reading_says_where_it_began(noise, values):
    made = AsciiDecoder(AsciiSettings())
    line = b'%r,%r,%r' % values
    (event,) = [e for e in made.feed(noise + line + b'\n') if isinstance(e, Reading)][-1:]
    assert event.start == len(noise)


def test_a_line_of_the_longest_length_is_read_and_a_longer_one_said_once():
    line = b'1,2,' + b'0' * (LONGEST - 5) + b'3'
    assert len(line) == LONGEST
    assert read(line + b'\n').values == (1.0, 2.0, 3.0)
    made = decoder()
    (error,) = made.feed(b'0' + line)
    assert isinstance(error, OverlongError)
    assert made.feed(line * 100) == []
    assert [type(event) for event in made.feed(b'\n1,2,3\n')] == [Reading]


@pytest.mark.parametrize(
    'columns', ['', 'xy', 'xyzz', 'xxyz', 'x,y,z', 'XYZ', '---', 'xyz ', 'axyz']
)
def test_columns_without_each_axis_once_are_refused(columns):
    with pytest.raises(SettingsError, match=r'driver\.serial\.ascii\.columns') as caught:
        AsciiSettings(columns=columns)
    assert repr(columns) in str(caught.value)


@pytest.mark.parametrize('separator', ['', '\\t', '.', '-', '+', '5', 'e', '_', '\n', ',\r'])
def test_a_separator_that_is_part_of_a_number_or_ends_a_line_is_refused(separator):
    with pytest.raises(SettingsError, match=r'driver\.serial\.ascii\.separator') as caught:
        AsciiSettings(separator=separator)
    assert repr(separator) in str(caught.value)


def test_every_error_is_a_reading_error_with_a_severity_that_the_log_knows():
    for kind in (ColumnError, CutError, GarbledError, NumberError, OverlongError):
        assert issubclass(kind, ReadingError)
        assert kind.severity == ('none' if kind is CutError else 'warning')
