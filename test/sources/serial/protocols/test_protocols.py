"""Laws that every protocol keeps, whatever bytes come."""

import math
import pickle

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from dead_reckoning.configuration import DRIVER
from dead_reckoning.core.accelerometer import UNITS
from dead_reckoning.core.errors import ReadingError
from dead_reckoning.sources.serial import protocols
from dead_reckoning.sources.serial.protocols import Reading

NAMES = protocols.names()
MOST_MEMORY = 4096
"""Bytes that a decoder may take, pickled, after any input."""

nearly_good = st.lists(
    st.sampled_from(
        [
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
            b'00FF1FF2003FA\r\n',
            b'\x86\x00\x22\x53\x7f',
        ]
    ),
    max_size=60,
).map(b''.join)
streams = st.binary(max_size=600) | nearly_good
chunks = st.lists(st.binary(max_size=80) | nearly_good, max_size=12)


def decoder(name):
    found = protocols.decoder_class(name)
    return found(found.Settings())


def seen(events):
    """Return events so that equal ones compare equal."""
    return [e if isinstance(e, Reading) else (type(e), str(e)) for e in events]


def test_ascii_is_found():
    assert 'ascii' in NAMES


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
@given(streams, st.booleans(), streams)
def test_any_bytes_give_finite_readings_and_errors_with_words(name, first, restart, second):
    read = decoder(name)
    events = read.feed(first)
    events += read.restart() if restart else []
    events += read.feed(second)
    for event in events:
        if isinstance(event, Reading):
            assert len(event.values) == 3
            assert all(type(v) is float and math.isfinite(v) for v in event.values)
        else:
            assert isinstance(event, ReadingError)
            assert 10 < len(str(event)) < 300
            assert str(event).isprintable()
    starts = [event.start for event in events if isinstance(event, Reading)]
    assert starts == sorted(set(starts))
    assert all(0 <= start < len(first + second) for start in starts)


@pytest.mark.parametrize('name', NAMES)
@pytest.mark.parametrize('filling', [b'1', b',', b'\xff', b' ', b'\n', b'1,2,3\n', b'\r\n'])
def test_memory_is_bounded(name, filling):
    read = decoder(name)
    for _ in range(100):
        read.feed(filling * (10_000 // len(filling)))
        assert len(pickle.dumps(read)) < MOST_MEMORY


@pytest.mark.parametrize('name', NAMES)
def test_nothing_comes_of_nothing(name):
    read = decoder(name)
    assert read.feed(b'') == []
    assert read.restart() == []
    assert read.feed(b'') == []
