"""Lines AAAAXXXYYYZZZ: golden lines, whatever happens to them, and the running number."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import CutError, FrameError
from dead_reckoning.sources.serial.protocols import Measurement, Reading
from dead_reckoning.sources.serial.protocols.hex import HexBoard, HexDecoder, HexSettings

count = st.integers(0, 1023)
counts = st.lists(st.tuples(count, count, count), min_size=1, max_size=12)


def decoder():
    """Return a decoder that is in step."""
    made = HexDecoder(HexSettings())
    assert made.feed(b'\n') == []
    return made


def measured(values):
    """Return a measurement of counts."""
    nothing = (0.0, 0.0, 0.0)
    return Measurement({'counts': values}, 0.0, nothing, (0.0, 0.0, 0.0, 1.0), nothing)


def sent(many):
    """Return the lines of a board for many counts."""
    board = HexBoard(HexSettings())
    return [board.measure(measured(tuple(map(float, values)))) for values in many]


def test_golden_lines():
    events = decoder().feed(b'00FF1FF2003FA\r\n0100000001002\n0101abcDEf012\r')
    assert events == [
        Reading((511.0, 512.0, 1018.0), 1, clock=255.0),
        Reading((0.0, 1.0, 2.0), 16, clock=256.0),
        FrameErrorLike(),
    ]


class FrameErrorLike:
    """Equal to any FrameError."""

    def __eq__(self, other):
        return isinstance(other, FrameError)


def test_a_board_sends_what_is_read():
    assert sent([(511, 512, 1018), (0, 1, 2000)]) == [b'00001FF2003FA\r\n', b'00010000013FF\r\n']


@given(counts, st.integers(1, 40))
def test_what_was_sent_is_read_at_any_cut(many, length):
    data = b''.join(sent(many))
    made = decoder()
    events = [e for at in range(0, len(data), length) for e in made.feed(data[at : at + length])]
    assert [event.values for event in events] == many
    assert [event.clock for event in events] == [float(k) for k in range(len(many))]
    assert [event.start for event in events] == [1 + 15 * k for k in range(len(many))]


@pytest.mark.parametrize(
    'line',
    [
        b'00011FF2003F',
        b'00011FF2003FAA',
        b'00011FG2003FA',
        b'00014FF2003FA',
        b'1,2,3',
        b'+0011FF2003FA',
    ],
)
def test_what_is_no_line_of_thirteen_digits_with_counts_of_ten_bits_is_refused(line):
    (event,) = decoder().feed(line + b'\n')
    assert isinstance(event, FrameError)
    assert line[:6].decode() in str(event)


@given(st.binary(max_size=60), counts)
def test_after_any_garbage_the_next_whole_line_is_read(garbage, many):
    first, *rest = sent(many)
    events = decoder().feed(garbage + b'\n' + first + b''.join(rest))
    assert [event.values for event in events[-len(many) :]] == many


def test_the_running_number_is_unwrapped():
    numbers = [0xFFFE, 0xFFFF, 0, 1, 0x8000, 0, 0x7FFF, 0xFFFE, 0xFFFD]
    events = decoder().feed(b''.join(b'%04X000000000\n' % number for number in numbers))
    clocks = [event.clock for event in events]
    assert clocks[:4] == [65534.0, 65535.0, 65536.0, 65537.0]
    assert [int(clock) % 65536 for clock in clocks] == numbers
    steps = [b - a for a, b in pairwise(clocks)]
    assert all(-32768 <= step < 32768 for step in steps)


def test_a_disturbed_number_is_wrong_alone():
    events = decoder().feed(b''.join(b'%s000000000\n' % n for n in (b'0007', b'C008', b'0009')))
    assert (events[0].clock, events[2].clock) == (7.0, 9.0)


def test_the_number_runs_on_after_a_restart_which_costs_the_line_that_was_cut():
    made = decoder()
    (first,) = made.feed(b'00071FF2003FA\n0008')
    assert [type(event) for event in made.restart()] == [CutError]
    cut, good = made.feed(b'1FF2003FA\n00091FF2003FA\n')
    assert isinstance(cut, CutError)
    assert good.clock - first.clock == 2.0
