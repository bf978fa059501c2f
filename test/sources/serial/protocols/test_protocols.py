"""Laws that every protocol keeps, whatever bytes come: any, and those of its board, damaged."""

import math
import pickle
from collections import deque
from copy import deepcopy

import pytest
from conversation import Conversation, measured
from hypothesis import example, given
from hypothesis import strategies as st

from dead_reckoning.configuration import DRIVER
from dead_reckoning.core.accelerometer import UNITS
from dead_reckoning.core.errors import ReadingError
from dead_reckoning.sources.serial import protocols
from dead_reckoning.sources.serial.protocols import Position, Reading

NAMES = protocols.names()
MOST_MEMORY = 4096
"""Bytes that a decoder may take, pickled, after any input."""

COUNTS = (130.0, 126.0, 190.0)
"""What the boards measure."""

OTHER = 4
"""Bytes of the longest message that is no reading, once they come: a greeting, a range."""


def decoder(name):
    found = protocols.decoder_class(name)
    return found(found.Settings())


def begun(name):
    """Return a conversation of a decoder and its board, in which readings come."""
    board = protocols.board_class(name)(protocols.decoder_class(name).Settings())
    talk = Conversation(decoder(name), board)
    talk.run(1.5, COUNTS)
    assert isinstance(talk.events[-1], (Reading, Position))
    return talk


BEGUN = {name: begun(name) for name in NAMES}
MESSAGES = {name: [data for _, data in BEGUN[name].sent] for name in NAMES}

LINES = [
    b'\n',
    b'\r',
    b'1,2,3\n',
    b'-4.5,6e2,.7\r\n',
    b',',
    b'1',
    b' ',
    b'\xff',
    b'\0',
    b'X:',
    b'e',
]
SENT = {data for sent in MESSAGES.values() for data in (*sent[:3], *sent[-3:])}
fragments = st.sampled_from(LINES + sorted(SENT))
pieces = fragments | st.builds(
    lambda data, k: data[k % len(data) :], fragments, st.integers(0, 30)
)
nearly_good = st.lists(pieces, max_size=40).map(b''.join)
streams = st.binary(max_size=600) | nearly_good
chunks = st.lists(st.binary(max_size=80) | nearly_good, max_size=12)
changes = st.lists(
    st.tuples(
        st.integers(0, 99),
        st.integers(0, 9),
        st.none() | st.integers(1, 255) | st.binary(max_size=40),
    ),
    min_size=1,
    max_size=3,
)
"""Where a message is changed, how many bytes, and what they become: None for twice the same, a
number for the bits that are turned in the first of them."""


def changed(data, how):
    """Return a message with some bytes lost, turned, doubled or put in."""
    for place, length, instead in how:
        at = place % (len(data) + 1)
        old = data[at : at + length]
        if instead is None:
            instead = 2 * old
        elif isinstance(instead, int):
            instead = bytes(byte ^ instead for byte in old[:1]) + old[1:]
        data = data[:at] + instead + data[at + length :]
    return data


def seen(events):
    """Return events so that equal ones compare equal."""
    return [e if isinstance(e, Reading) else (type(e), str(e)) for e in events]


@pytest.mark.parametrize('name', NAMES)
def test_settings_have_the_prefix_of_the_protocol_and_are_the_drivers(name):
    settings = protocols.decoder_class(name).Settings
    assert settings.prefix == f'driver.serial.{name}'
    assert settings in DRIVER
    assert decoder(name).unit in UNITS


@pytest.mark.parametrize('name', NAMES)
@given(chunks)
@example([b'1,2,3\n4,', b'5,6\n'])
@example([b'x' * 256, b'x', b'\n1,2,3\n'])
def test_however_the_bytes_are_cut_the_events_are_the_same(name, parts):
    cut, whole, single = decoder(name), decoder(name), decoder(name)
    events = seen([event for part in parts for event in cut.feed(part)])
    data = b''.join(parts)
    assert events == seen(whole.feed(data))
    assert events == seen(e for byte in data for e in single.feed(bytes([byte])))


@pytest.mark.parametrize('name', NAMES)
@given(st.lists(changes | st.just([]), min_size=1, max_size=12), st.integers(1, 12))
def test_however_a_damaged_conversation_is_cut_it_is_the_same(name, damages, size):
    said = []
    for sizes in ([10_000], [1], [size, 3]):
        talk, left = deepcopy(BEGUN[name]), iter(damages)
        talk.damage = lambda data, left=left: changed(data, next(left, []))
        talk.sizes = deque(sizes)
        talk.run(0.5, COUNTS)
        assert len(pickle.dumps(talk.decoder)) < MOST_MEMORY
        said.append((talk.told, [repr(event) for event in talk.events]))
    assert said[0] == said[1] == said[2]


@pytest.mark.parametrize('name', NAMES)
@given(st.lists(changes, min_size=1, max_size=3))
def test_from_the_third_message_after_damage_on_all_are_read(name, damages):
    """With the values that the board measured, as soon as the one behind has come."""
    talk, left = deepcopy(BEGUN[name]), iter(damages)
    talk.damage = lambda data: changed(data, next(left, []))
    del talk.sent[:], talk.events[:]
    talk.run(1.0, COUNTS)
    whole = [(at, data) for at, data in talk.sent[len(damages) + 2 : -1] if len(data) > OTHER]
    assert len(whole) > 15
    found = {event.start: event for event in talk.events if not isinstance(event, ReadingError)}
    for at, data in whole:
        (event,) = [found[start] for start in range(at, at + len(data)) if start in found]
        if isinstance(event, Reading):
            assert event.values == pytest.approx(measured(COUNTS).values[talk.decoder.unit])


@pytest.mark.parametrize('name', NAMES)
@given(st.lists(streams, max_size=4), st.booleans())
def test_any_bytes_give_finite_readings_and_errors_with_words(name, parts, restart):
    read = decoder(name)
    events = []
    for part in parts:
        read.due(math.inf)
        events += read.feed(part)
        events += read.restart() if restart else []
    for event in events:
        if isinstance(event, ReadingError):
            assert 10 < len(str(event)) < 400
            assert str(event).isprintable()
            continue
        values = event.values if isinstance(event, Reading) else (event.x, event.y)
        assert len(values) == (3 if isinstance(event, Reading) else 2)
        assert all(type(value) is float and math.isfinite(value) for value in values)
    starts = [event.start for event in events if not isinstance(event, ReadingError)]
    assert starts == sorted(set(starts))
    assert all(0 <= start < sum(map(len, parts)) for start in starts)


FILLINGS = [b'1', b',', b'\xff', b' ', b'\n', b'1,2,3\n', b'\r\n']


@pytest.mark.parametrize('name', NAMES)
def test_memory_is_bounded(name):
    """Of a message too that comes for ever, or of which only the beginning does."""
    message = MESSAGES[name][-1]
    for filling in (*FILLINGS, message, message[:-1]):
        read = decoder(name)
        for _ in range(30):
            read.due(math.inf)
            read.feed(filling * (10_000 // len(filling)))
            assert len(pickle.dumps(read)) < MOST_MEMORY


@pytest.mark.parametrize('name', NAMES)
def test_nothing_comes_of_nothing(name):
    read = decoder(name)
    assert read.feed(b'') == []
    assert read.restart() == []
    assert read.feed(b'') == []
