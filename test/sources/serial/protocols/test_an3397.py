"""Positions of AN3397's board."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from dead_reckoning.core.errors import CutError, FrameError, SettingsError
from dead_reckoning.core.reference import an3397
from dead_reckoning.core.reference.an3397_frame import SIGNS, decode
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.serial.protocols import Measurement, Position
from dead_reckoning.sources.serial.protocols.an3397 import (
    An3397Board,
    An3397Decoder,
    An3397Settings,
)

LENGTH = 7

frames = st.builds(
    lambda signs, x, y: bytes((3, signs, x, y, 1, 1, 0xFE)),
    st.sampled_from(sorted(SIGNS)),
    st.integers(0, 127),
    st.integers(0, 127),
)


def decoder(**settings):
    return An3397Decoder(An3397Settings(**{'metres_per_unit': 0.5, **settings}))


def places(events):
    return [(event.x, event.y) for event in events if isinstance(event, Position)]


@pytest.mark.parametrize(
    ('frame', 'place'),
    [
        ('03 18 00 00 01 01 fe', (0.0, 0.0)),
        ('03 18 0a 03 01 01 fe', (5.0, 1.5)),
        ('03 11 7f 01 01 01 fe', (63.5, -0.5)),
        ('03 88 80 7f 01 01 fe', (-64.0, 63.5)),
        ('03 81 03 80 01 01 fe', (-1.5, -64.0)),
    ],
)
def test_golden_frames(frame, place):
    (event,) = decoder().feed(bytes.fromhex(frame))
    assert event == Position(*place, 0)


def test_a_unit_is_64_counts_of_which_the_default_gives_the_metres():
    """0.158 m/s² for (10 ms)² are 15.8 µm, 64 of them 1.01 mm."""
    assert An3397Settings().metres_per_unit == pytest.approx(1.011e-3, rel=1e-3)
    assert An3397Settings().shift == 18
    assert An3397Settings(counts_per_unit=1).metres_per_unit == pytest.approx(15.8e-6, rel=1e-3)
    (event,) = An3397Decoder(An3397Settings()).feed(bytes.fromhex('03 11 64 00 01 01 fe'))
    assert event.x == pytest.approx(0.1011, rel=1e-3)


@given(st.lists(frames, max_size=8), st.lists(st.integers(0, 56)))
def test_any_cut_of_frames_gives_what_was_sent(sent, cuts):
    data = b''.join(sent)
    ends = sorted({min(cut, len(data)) for cut in cuts} | {len(data)})
    read = decoder(metres_per_unit=64.0)
    pieces = [data[a:b] for a, b in zip([0, *ends], ends, strict=False)]
    events = [event for piece in pieces for event in read.feed(piece)]
    assert places(events) == [decode(frame) for frame in sent]
    assert [event.start for event in events] == [LENGTH * k for k in range(len(sent))]


def sent_by(board, counts):
    """Return what a board sends of counts of x and y, shape (n, 2), a piece for each."""
    return [
        board.measure(
            Measurement({'counts': (x, y, 0.0)}, 0.0, (0, 0, 0), (0, 0, 0, 1), (0, 0, 0))
        )
        for x, y in counts.tolist()
    ]


@pytest.mark.parametrize('counts_per_unit', [64, 1])
def test_board_sends_what_the_program_of_the_document_does(counts_per_unit):
    """A push forward and one back, with noise."""
    counts = 128.0 + np.random.default_rng(5).normal(0.0, 1.5, (1024 + 64 * 60, 2))
    counts[1024 + 640 : 1024 + 1280] += (12.0, -9.0)
    counts[1024 + 1920 : 1024 + 2560] -= (12.0, -9.0)
    counts = counts.round()
    settings = An3397Settings(
        metres_per_unit=float(counts_per_unit), counts_per_unit=counts_per_unit
    )
    sent = b''.join(sent_by(An3397Board(settings), counts))
    updates = an3397.run(counts.astype(np.int64), shift=settings.shift)
    assert sent == b''.join(update.frame for update in updates)
    assert len(updates) == 60
    went = np.array(places(An3397Decoder(settings).feed(sent)))
    if counts_per_unit == 64:
        program = np.array([(update.px, update.py) for update in updates])
        assert np.abs(went - program).max() < 64
        assert went[-1] == pytest.approx((12 * 10 * 20, -9 * 10 * 20), rel=0.3), 'it floors'
    else:
        assert np.abs(went).max() <= 128, 'the byte wraps after 128 counts'


def test_default_metres_are_those_of_the_rate_of_the_board():
    """1.1 m/s² for 0.35 s, half an update less by the trapezoid: a unit shows 1 mm."""
    settings, model = An3397Settings(), DriverSettings(adc_bits=8).model()
    force = np.zeros((1024 + round(0.35 * An3397Board.RATE), 3))
    force[1024:, 0] = 1.1
    counts = model.counts(model.output(force))[:, :2]
    *_, last = An3397Decoder(settings).feed(b''.join(sent_by(An3397Board(settings), counts)))
    assert last.x == pytest.approx(0.5 * 1.1 * 0.345**2, abs=0.0015)
    assert last.y == 0.0


def test_end_of_frame_is_a_setting():
    frame = bytes.fromhex('03 18 0a 03 01 01 0d')
    assert places(decoder(end_of_frame=13).feed(frame)) == [(5.0, 1.5)]
    assert places(decoder().feed(frame)) == []


@pytest.mark.parametrize('index', range(LENGTH))
@pytest.mark.parametrize('damage', ['lost', 'doubled', 'flipped'])
def test_a_damaged_byte_costs_its_frame_alone(index, damage):
    bad = bytearray.fromhex('03 11 05 06 01 01 fe')
    if damage == 'lost':
        del bad[index]
    elif damage == 'doubled':
        bad.insert(index, bad[index])
    else:
        bad[index] ^= 0x88
    good = [bytes((3, 0x18, 10, k, 1, 1, 0xFE)) for k in range(4)]
    events = decoder(metres_per_unit=1.0).feed(good[0] + good[1] + bytes(bad) + good[2] + good[3])
    read = [place for place in places(events) if place[0] == 10.0]
    assert read == [(10.0, float(k)) for k in range(4)]


@given(st.binary(max_size=60).filter(lambda noise: 0xFE not in noise))
@example(bytes.fromhex('03 18 03 18 01 01'))
@example(bytes.fromhex('03 18 00 03 18 00'))
def test_after_garbage_the_next_frame_is_read(noise):
    frame = bytes.fromhex('03 11 05 06 01 01 fe')
    events = decoder().feed(noise + frame)
    assert places(events)[-1] == (2.5, -3.0)
    assert events[-1].start == len(noise)


@pytest.mark.parametrize(
    'frame', ['03 19 00 00 01 01 fe', '03 18 80 00 01 01 fe', '03 11 00 81 01 01 fe']
)
def test_a_direction_or_a_distance_that_there_is_not_is_no_frame(frame):
    good = bytes.fromhex('03 18 00 00 01 01 fe')
    events = decoder().feed(good + bytes.fromhex(frame) + good)
    assert [type(event) for event in events] == [Position, FrameError, Position]


def test_a_start_within_a_frame_is_to_be_expected():
    cut, place = decoder().feed(bytes.fromhex('01 01 fe 03 18 02 00 01 01 fe'))
    assert isinstance(cut, CutError)
    assert place == Position(1.0, 0.0, 3)


@pytest.mark.parametrize('counts', [0, 3, 63, 65, 1 << 25])
def test_counts_that_no_shift_gives_are_refused(counts):
    with pytest.raises(SettingsError, match=r'driver\.serial\.an3397\.counts_per_unit'):
        An3397Settings(counts_per_unit=counts)
