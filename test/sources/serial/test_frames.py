"""Frames in a stream: what is skipped, and how often that is said."""

from dead_reckoning.core.errors import CutError, FrameError
from dead_reckoning.sources.serial.frames import Frames
from dead_reckoning.sources.serial.protocols import Position


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
