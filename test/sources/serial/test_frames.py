"""Frames in a stream: what is skipped, how often that is said, and laws of who finds them."""

import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import CutError, FrameError
from dead_reckoning.sources.serial.frames import Frames
from dead_reckoning.sources.serial.protocols import (
    Measurement,
    Position,
    Reading,
    board_class,
    decoder_class,
)


class Pairs(Frames):
    """Two bytes, ``<`` and a digit."""

    FIRST = b'<'
    SHAPE = 'pair'
    unit = 'counts'

    def _read(self, data, at, events):
        if len(data) - at < 2:
            return None
        if not data[at + 1 : at + 2].isdigit():
            return 0
        events.append(
            Position(float(data[at + 1 : at + 2]), float(self._in_step), self._before + at)
        )
        return 2


def seen(events):
    return [(e.x, e.y, e.start) if isinstance(e, Position) else type(e) for e in events]


def test_frames_say_where_they_began_and_whether_one_ended_there():
    assert seen(Pairs().feed(b'<1<2<3')) == [(1, 0, 0), (2, 1, 2), (3, 1, 4)]


def test_a_run_of_skipped_bytes_is_one_error_and_ends_the_step():
    pairs = Pairs()
    assert seen(pairs.feed(b'<1')) == [(1, 0, 0)]
    assert seen(pairs.feed(b'x<y')) == [FrameError]
    assert seen(pairs.feed(b'<<zzz')) == []
    assert seen(pairs.feed(b'<2<3.')) == [(2, 0, 10), (3, 1, 12), FrameError]


def test_at_the_start_the_rest_of_a_frame_is_to_be_expected():
    assert seen(Pairs().feed(b'9<1.<2')) == [CutError, (1, 0, 1), FrameError, (2, 0, 4)]


def test_a_restart_cuts_the_frame_that_has_begun_and_counts_on():
    pairs = Pairs()
    assert seen(pairs.feed(b'<1<')) == [(1, 0, 0)]
    assert seen(pairs.restart()) == [CutError]
    assert pairs.restart() == []
    assert seen(pairs.feed(b'2<3')) == [CutError, (3, 0, 4)]


def test_a_frame_that_begins_within_what_is_none_is_read():
    assert seen(Pairs().feed(b'<<1')) == [CutError, (1, 0, 1)]


def sent_by(name, count):
    """Return what a board sends while it rests, a frame or an instant each."""
    board = board_class(name)(decoder_class(name).Settings())
    said = []
    for k in range(2000):
        values = {'counts': (512.0, 512.0, 711.0), 'g': (0.0, 0.0, 1.0)}
        measured = Measurement(values, 0.01 * k, (0, 0, 0), (0, 0, 0, 1), (0, 0, 0))
        said.append(board.measure(measured))
        if sum(map(bool, said)) == count:
            return [frame for frame in said if frame]
    raise AssertionError(f'{name} is silent')


FRAMED = ('an3397', 'imu6dof4', 'um7')
SENT = {name: sent_by(name, 12) for name in FRAMED}


@st.composite
def disturbed(draw):
    """A protocol, and pieces of its stream with all that may happen to one."""
    name = draw(st.sampled_from(FRAMED))
    pieces = []
    for frame in SENT[name]:
        end = draw(st.integers(0, len(frame)))
        pieces.append(
            draw(
                st.sampled_from(
                    [frame, frame, frame[:end], frame[end:], frame * 2, frame[:end] + frame]
                )
                | st.binary(max_size=30)
            )
        )
    return name, pieces


@given(disturbed(), st.integers(1, 60), st.booleans())
def test_a_disturbed_stream_gives_the_same_however_it_is_cut(stream, step, restart):
    name, pieces = stream
    data = b''.join(pieces)
    ways = [pieces, [data], [data[k : k + step] for k in range(0, len(data), step)]]
    said = []
    for way in ways:
        read = decoder_class(name)(decoder_class(name).Settings())
        events = [event for piece in way for event in read.feed(piece)]
        assert len(pickle.dumps(read)) < 1500
        events += read.restart() if restart else []
        said.append([repr(event) for event in events])
        starts = [event.start for event in events if isinstance(event, (Reading, Position))]
        assert starts == sorted(set(starts))
    assert said[0] == said[1] == said[2]


@pytest.mark.parametrize('name', FRAMED)
def test_within_two_frames_after_damage_all_are_found(name):
    """Noise that holds no first byte of a frame, between any two."""
    frames = SENT[name]
    first = decoder_class(name).FIRST
    noise = bytes(k for k in range(256) if bytes((k,)) != first)
    for at in range(1, len(frames)):
        read = decoder_class(name)(decoder_class(name).Settings())
        data = b''.join(frames[:at]) + noise + b''.join(frames[at:])
        good = [e for e in read.feed(data) if isinstance(e, (Reading, Position))]
        lost = len(frames) - len(good)
        assert lost <= (name == 'imu6dof4' and at in (1, len(frames) - 1)), 'no frame beside it'
