"""SparkFun IMU 6DOF v4: frames of 22 bytes whose marks may stand within them as well."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from dead_reckoning.core.errors import CutError, FrameError, SettingsError
from dead_reckoning.sources.serial.protocols import Measurement, Reading
from dead_reckoning.sources.serial.protocols.imu6dof4 import (
    Imu6Dof4Board,
    Imu6Dof4Decoder,
    Imu6Dof4Settings,
)

GOLDEN = bytes.fromhex('41 0007 0200 0201 0202 01ff 0200 0300 0200 023b 01c5 5a')
LENGTH = 22

tens = st.integers(0, 1023)
triples = st.tuples(tens, tens, tens)


def frame(count, accelerations=(1, 2, 3), turns=(512, 512, 512)):
    numbers = (count, 512, 512, 512, *accelerations, *turns)
    return b'A' + b''.join(number.to_bytes(2, 'big') for number in numbers) + b'Z'


def decoder(**settings):
    return Imu6Dof4Decoder(Imu6Dof4Settings(**settings))


def readings(events):
    return [event for event in events if isinstance(event, Reading)]


def values(events):
    return [reading.values for reading in readings(events)]


def pieces(data, cuts):
    ends = sorted({min(cut, len(data)) for cut in cuts} | {len(data)})
    return [data[a:b] for a, b in zip([0, *ends], ends, strict=False)]


def test_golden_frame():
    """A count of 7; accelerations 511, 512, 768; rates 0, +59 and -59 counts: 1.005 rad/s."""
    first, _ = readings(decoder().feed(GOLDEN + frame(8)))
    assert first.values == (511.0, 512.0, 768.0)
    assert first.clock == 0.0
    assert first.start == 0
    assert first.rate == pytest.approx((0.0, 59 / 58.7, -59 / 58.7))


def test_default_sensitivity_is_of_millivolts_per_degree():
    per_degree = Imu6Dof4Settings().rate_sensitivity[0] * math.radians(1.0)
    assert per_degree * 3.3 / 1024 == pytest.approx(3.3e-3, rel=1e-3)


@given(
    st.lists(triples, min_size=2, max_size=8),
    st.integers(0, 65_535),
    st.lists(st.integers(0, 200)),
)
def test_any_cut_of_frames_gives_what_was_sent(sent, first, cuts):
    data = b''.join(frame((first + k) % 65_536, each) for k, each in enumerate(sent))
    read = decoder()
    events = [event for piece in pieces(data, cuts) for event in read.feed(piece)]
    assert values(events) == sent
    assert [event.clock for event in events] == list(range(len(sent)))
    assert [event.start for event in events] == [LENGTH * k for k in range(len(sent))]


@given(
    st.lists(st.tuples(triples, st.tuples(*[st.floats(-5.0, 5.0)] * 3)), min_size=2, max_size=6)
)
def test_decoder_reads_what_the_board_sends(sent):
    settings = Imu6Dof4Settings(rate_sensitivity=(58.0, -60.0, 30.0))
    board, read = Imu6Dof4Board(settings), Imu6Dof4Decoder(settings)
    data = b''.join(
        board.measure(Measurement({'counts': counts}, 0.1 * k, rate, (0, 0, 0, 1), (0, 0, 0)))
        for k, (counts, rate) in enumerate(sent)
    )
    got = read.feed(data)
    assert values(got) == [counts for counts, _ in sent]
    for event, (_, rate) in zip(got, sent, strict=True):
        assert event.rate == pytest.approx(rate, abs=0.5 / 30.0 + 1e-9)


def test_board_keeps_within_ten_bits():
    board = Imu6Dof4Board(Imu6Dof4Settings())
    data = b''.join(
        board.measure(
            Measurement({'counts': counts}, 0.0, (99.0, -99.0, 0.0), (0, 0, 0, 1), (0, 0, 0))
        )
        for counts in ((-3.2, 5000.0, 700.4), (0.0, 0.0, 0.0))
    )
    first, _ = decoder().feed(data)
    assert first.values == (0.0, 1023.0, 700.0)
    assert first.rate == pytest.approx((511 / 58.7, -512 / 58.7, 0.0))


def test_in_step_a_frame_is_read_with_its_last_byte():
    read = decoder()
    read.feed(frame(1) + frame(2))
    assert read.feed(frame(3)[:-1]) == []
    assert values(read.feed(b'Z')) == [(1, 2, 3)]


def test_the_count_goes_on_where_it_begins_anew():
    sent = [frame(count) for count in (65_534, 65_535, 0, 1)]
    assert [r.clock for r in decoder().feed(b''.join(sent))] == [0, 1, 2, 3]
    sent = [frame(count) for count in (32_766, 32_767, 0, 1)]
    assert [r.clock for r in decoder(counts=32_768).feed(b''.join(sent))] == [0, 1, 2, 3]


def test_without_a_count_frames_are_read_all_the_same():
    events = decoder(counts=0).feed(frame(9) + frame(5) + frame(5))
    assert [(type(event), event.clock) for event in events] == [(Reading, None)] * 3


def test_frames_that_are_missing_show_in_the_clock():
    data = b''.join(frame(count, (count, 0, 0)) for count in (1, 2, 5, 6))
    events = decoder().feed(data)
    assert [(r.values[0], r.clock) for r in events] == [(1, 0), (2, 1), (5, 4), (6, 5)]


def test_a_wrong_count_costs_its_frame_alone():
    data = b''.join(frame(c, (k, 0, 0)) for k, c in enumerate([1, 2, 4099, 4, 5, 6]))
    events = decoder().feed(data)
    assert [(r.values[0], r.clock) for r in readings(events)] == [
        (0, 0),
        (1, 1),
        (3, 3),
        (4, 4),
        (5, 5),
    ]
    assert [type(e) for e in events if not isinstance(e, Reading)] == [FrameError]


def test_a_doubled_frame_is_read_once():
    events = decoder().feed(frame(1) + frame(2) + frame(2) + frame(3) + frame(4))
    assert [r.clock for r in readings(events)] == [0, 1, 2, 3]


@pytest.mark.parametrize('index', range(LENGTH))
@pytest.mark.parametrize('damage', ['lost', 'doubled', 'flipped'])
def test_a_damaged_byte_costs_its_frame_alone(index, damage):
    """Values whose change shows nowhere are read wrong: there is no sum."""
    bad = bytearray(frame(3, (3, 0, 0)))
    if damage == 'lost':
        del bad[index]
    elif damage == 'doubled':
        bad.insert(index, bad[index])
    else:
        bad[index] ^= 0x80
    good = [frame(count, (count, 0, 0)) for count in (1, 2, 4, 5, 6)]
    events = decoder().feed(good[0] + good[1] + bytes(bad) + b''.join(good[2:]))
    read = [reading.values[0] for reading in readings(events)]
    assert [value for value in read if value in (1, 2, 4, 5, 6)] == [1, 2, 4, 5, 6]
    assert len(read) <= 6


def test_marks_within_frames_are_no_frames():
    """A start in the middle of frames that have A and Z at each other's distance within them."""
    inner = [frame(0x5A41 + k, (0x15A, 0x141, 0x25A), (0x341, 0x15A, 0x041)) for k in range(6)]
    data = b''.join(inner)
    for cut in range(1, LENGTH):
        events = decoder().feed(data[cut:])
        assert isinstance(events[0], CutError)
        assert values(events) == [(0x15A, 0x141, 0x25A)] * 5, cut
        assert readings(events)[0].start == LENGTH - cut


def test_a_false_lock_is_left():
    """Bytes that look like two frames in a row, then real ones at another place."""
    false = frame(100, (9, 9, 9)) + frame(101, (9, 9, 9))
    real = b''.join(frame(count) for count in range(1, 4))
    events = decoder().feed(false + b'A' + real)
    assert values(events) == [(9, 9, 9)] * 2 + [(1, 2, 3)] * 3


@given(st.binary(max_size=100))
@example(b'A' * 30)
@example(b'A' + b'\0' * 20 + b'Z')
def test_after_garbage_the_next_frames_are_read(noise):
    data = b''.join(frame(count, (count % 1000, 7, 7)) for count in range(40_000, 40_005))
    assert values(decoder().feed(noise + data))[-4:] == [(count, 7, 7) for count in range(1, 5)]


def test_a_number_of_more_than_ten_bits_is_no_frame():
    events = decoder().feed(frame(1) + frame(2) + frame(3, (1024, 0, 0)) + frame(4) + frame(5))
    assert [r.clock for r in readings(events)] == [0, 1, 3, 4]


def test_after_a_restart_the_count_begins_anew():
    read = decoder()
    read.feed(frame(50) + frame(51) + b'A')
    assert [type(event) for event in read.restart()] == [CutError]
    assert [r.start for r in readings(read.feed(frame(51) + frame(52)))] == [45, 67]


@pytest.mark.parametrize(
    'settings',
    [
        {'counts': -1},
        {'counts': 65_537},
        {'rate_zero': (0.0, 0.0, 2000.0)},
        {'rate_sensitivity': (1.0, 0.0, 1.0)},
    ],
)
def test_settings_that_no_board_has_are_refused(settings):
    with pytest.raises(SettingsError, match=rf'driver\.serial\.imu6dof4\.{next(iter(settings))}'):
        Imu6Dof4Settings(**settings)
