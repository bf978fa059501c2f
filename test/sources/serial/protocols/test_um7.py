"""CH Robotics UM7: packets, the instants they make, and the frames of what is in them."""

import itertools
import math
import struct

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from dead_reckoning.core.errors import (
    CutError,
    FrameError,
    HealthError,
    IncompleteError,
    OutOfRangeError,
    SettingsError,
)
from dead_reckoning.core.rotation import quaternion_from_euler, yaw_from_quaternion
from dead_reckoning.sources.serial.protocols import Measurement, Reading
from dead_reckoning.sources.serial.protocols.um7 import (
    Um7Board,
    Um7Decoder,
    Um7Settings,
    packet,
    turned,
)

NED_TO_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
RIGHT_DOWN = np.diag([1.0, -1.0, -1.0])
NORTH = (1.0, 0.0, 0.0, 0.0)
"""Attitude in NED, a to d: level, facing north."""

angles = st.floats(-3.1, 3.1)
vectors = st.tuples(*[st.floats(-7.0, 7.0, width=32)] * 3)


def decoder(**settings):
    return Um7Decoder(Um7Settings(**settings))


def rate(time, turn=(0.0, 0.0, 0.0)):
    return packet(97, struct.pack('>4f', *turn, time))


def force(time, values=(0.0, 0.0, -1.0)):
    return packet(101, struct.pack('>4f', *values, time))


def quaternion(time, abcd=NORTH):
    return packet(109, struct.pack('>4hf', *(round(29_789.09091 * q) for q in abcd), time))


def euler(time, *degrees):
    angles = (round(91.02222 * angle) for angle in degrees)
    return packet(112, struct.pack('>3hhhhhhf', *angles, 11, 12, 13, 14, 15, time))


def instant(time, **values):
    return rate(time) + force(time) + quaternion(time, **values)


def readings(events):
    return [event for event in events if isinstance(event, Reading)]


def times(events):
    return [reading.clock for reading in readings(events)]


def errors(events):
    return [type(event) for event in events if not isinstance(event, Reading)]


def pieces(data, cuts):
    ends = sorted({min(cut, len(data)) for cut in cuts} | {len(data)})
    return [data[a:b] for a, b in zip([0, *ends], ends, strict=False)]


def measurement(force_g, turn, orientation, time):
    return Measurement({'g': force_g}, time, turn, orientation, (0.0, 0.0, 0.0))


# Packets ---------------------------------------------------------------------------------------

GOLDEN_RATE = bytes.fromhex(
    '73 6e 70 d0 61'  # s n p, data in a batch of 4, register 97
    '42 34 00 00'  # 45 °/s about the axis that points forward
    'c1 20 00 00'  # -10 °/s, to the right
    '00 00 00 00'
    '3f c0 00 00'  # 1.5 s
    '04 d8'  # 0x73+0x6e+0x70+0xd0+0x61 = 0x282; +0x76 +0xe1 +0 +0xff = 0x4d8
)
GOLDEN_FORCE = bytes.fromhex(
    '73 6e 70 d0 65'
    '3f 00 00 00'  # 0.5 g forward
    '00 00 00 00'
    'bf 80 00 00'  # -1 g down
    '3f c0 00 00'
    '05 03'  # 0x286 + 0x3f + 0x13f + 0xff
)
GOLDEN_QUATERNION = bytes.fromhex(
    '73 6e 70 cc 6d'
    '52 48 00 00'  # 21064: cos 45°
    '00 00 52 48'  # the same about the axis that points down: facing east
    '3f c0 00 00'
    '04 bd'  # 0x28a + 0x9a + 0x9a + 0xff
)


def test_golden_packets_of_a_board_that_faces_east():
    (reading,) = decoder().feed(GOLDEN_RATE + GOLDEN_FORCE + GOLDEN_QUATERNION)
    assert reading.values == (0.5, 0.0, 1.0)
    assert reading.rate == pytest.approx((math.radians(45.0), math.radians(10.0), 0.0))
    assert reading.orientation == pytest.approx((0.0, 0.0, 0.0, 1.0))
    assert (reading.clock, reading.start) == (1.5, 0)


def test_packets_of_these_tests_are_those():
    assert rate(1.5, (45.0, -10.0, 0.0)) == GOLDEN_RATE
    assert force(1.5, (0.5, 0.0, -1.0)) == GOLDEN_FORCE
    assert quaternion(1.5, (0.70711, 0.0, 0.0, 0.70711)) == GOLDEN_QUATERNION


@pytest.mark.parametrize(
    'answer',
    [
        '73 6e 70 80 aa 55 37 32 41 03 7a',  # firmware U72A
        '73 6e 70 80 65 bb ab ab e4 05 2b',  # register 101 alone, asked for by someone
        '73 6e 70 00 05 01 56',  # a write is done
        '73 6e 70 01 aa 01 fc',  # a command has failed
        '73 6e 70 c0 61 02 72',  # a batch of none
    ],
)
def test_packets_of_something_else_are_nothing(answer):
    read = decoder()
    assert times(read.feed(instant(1.0))) == [1.0]
    assert read.feed(bytes.fromhex(answer)) == []
    assert times(read.feed(instant(1.1))) == [pytest.approx(1.1)]


def test_hidden_registers_are_not_those_of_the_same_address():
    hidden = bytearray(force(1.0, (9.0, 9.0, 9.0)))
    hidden[3] |= 2
    hidden[-2:] = sum(hidden[:-2]).to_bytes(2, 'big')
    assert decoder().feed(bytes(hidden) + instant(1.0))[0].values == (0.0, 0.0, 1.0)


def test_all_that_is_processed_may_come_in_one_packet():
    registers = struct.pack('>12f', 1, 2, 3, 5.0, 0, 0, -1, 5.0, 0.3, 0.0, 0.4, 5.0)
    (reading,) = decoder().feed(packet(97, registers) + quaternion(5.0))
    assert reading.values == (0.0, 0.0, 1.0)
    assert reading.rate == pytest.approx(tuple(map(math.radians, (1, -2, -3))))


def test_euler_angles_may_come_with_the_position():
    registers = euler(2.0, 0.0, 0.0, 90.0)[5:-2] + bytes(16)
    (reading,) = decoder(attitude='euler').feed(rate(2.0) + force(2.0) + packet(112, registers))
    assert reading.orientation == pytest.approx((0.0, 0.0, 0.0, 1.0), abs=1e-6)


@pytest.mark.parametrize(
    ('bits', 'words'),
    [
        (1 << 8, ['baud']),
        (1 << 3 | 1 << 2, ['accelerometer', 'gyroscope']),
        (1 << 1, ['magnetometer']),
        (0xFFFF_FE31, []),  # satellites, a disturbed field, no GNSS
        (0, []),
    ],
)
def test_what_the_board_says_of_its_health(bits, words):
    head = b'snp\x80' + bytes((85,)) + bits.to_bytes(4, 'big')
    events = decoder().feed(head + sum(head).to_bytes(2, 'big'))
    assert all(isinstance(event, HealthError) for event in events)
    assert len(events) == len(words)
    assert all(word in str(event) for word, event in zip(words, events, strict=True))


# Instants --------------------------------------------------------------------------------------


@pytest.mark.parametrize('order', list(itertools.permutations([rate, force, quaternion])))
def test_packets_of_an_instant_come_in_any_order(order):
    read = decoder()
    for k in range(4):
        *first, last = (part(0.01 * k) for part in order)
        assert read.feed(b''.join(first)) == []
        (reading,) = read.feed(last)
        assert reading.clock == pytest.approx(0.01 * k)
        assert reading.start == (23 + 23 + 19) * k


@pytest.mark.parametrize('order', list(itertools.permutations([rate, force, quaternion])))
@pytest.mark.parametrize('lost', range(6, 15))
def test_a_lost_packet_costs_its_instant_alone(order, lost):
    sent = [part(0.01 * k) for k in range(8) for part in order]
    del sent[lost]
    events = decoder().feed(b''.join(sent))
    assert times(events) == pytest.approx([0.01 * k for k in range(8) if k != lost // 3])
    (error,) = [event for event in events if not isinstance(event, Reading)]
    assert type(error) is IncompleteError
    name = {rate: '97 to 100', force: '101 to 104', quaternion: '109 to 111'}[order[lost % 3]]
    assert name in str(error)


def test_a_doubled_packet_costs_one_instant():
    sent = [part(0.01 * k) for k in range(6) for part in (rate, force, quaternion)]
    for doubled in range(3, 6):
        events = decoder().feed(b''.join([*sent[:doubled], sent[doubled], *sent[doubled:]]))
        assert 5 <= len(times(events)) <= 6
        assert times(events)[-3:] == pytest.approx([0.03, 0.04, 0.05])


def test_times_of_an_instant_may_differ_a_little_and_the_clock_is_that_of_the_force():
    data = rate(1.0) + quaternion(1.001) + force(1.002)
    assert times(decoder().feed(data)) == pytest.approx([1.002])
    assert times(decoder(together=0.0005).feed(data)) == []


def test_times_may_differ_by_what_a_float_rounds():
    """After a day they go on in steps of 8 ms."""
    data = b''.join(rate(t) + force(t + 1 / 128) + quaternion(t) for t in (86_000.0, 86_001.0))
    assert len(times(decoder().feed(data))) == 2


def test_a_board_that_was_switched_off_goes_on():
    events = decoder().feed(instant(5000.0) + instant(0.5) + instant(0.51))
    assert times(events) == pytest.approx([5000.0, 0.5, 0.51])


def test_what_is_not_sent_is_said_by_its_registers():
    cut, *said = decoder().feed(b''.join(rate(t) + force(t) for t in (1.0, 1.1, 1.2)))
    assert isinstance(cut, CutError), 'the first may have begun before the port was opened'
    assert [type(event) for event in said] == [IncompleteError]
    assert 'attitude (registers 109 to 111)' in str(said[0])
    _, said = decoder(attitude='euler').feed(b''.join(rate(t) + force(t) for t in (1.0, 1.1, 1.2)))
    assert 'attitude (registers 112 to 116)' in str(said)


def test_a_restart_forgets_the_instant():
    read = decoder()
    read.feed(rate(1.0) + b'snp')
    assert [type(event) for event in read.restart()] == [CutError]
    assert read.feed(force(1.0) + quaternion(1.0)) == []
    (cut, reading) = read.feed(instant(1.1))
    assert isinstance(cut, CutError)
    assert reading.start == len(rate(1.0)) + 3 + len(force(1.0) + quaternion(1.0))


@pytest.mark.parametrize(
    'bad',
    [
        rate(1.0, (math.nan, 0.0, 0.0)),
        rate(1.0, (0.0, math.inf, 0.0)),
        force(1.0, (0.0, 0.0, 1e30)),
        force(math.nan),
        force(math.inf),
        force(-1.0),
        quaternion(1.0, (0.0, 0.0, 0.0, 0.0)),
        quaternion(1.0, (1.0, 1.0, 0.0, 0.0)),
    ],
)
def test_numbers_that_no_board_measures_are_refused(bad):
    events = decoder().feed(instant(0.9) + bad + instant(1.1))
    assert errors(events) == [OutOfRangeError]
    assert times(events) == pytest.approx([0.9, 1.1])


# Disturbed lines -------------------------------------------------------------------------------


@given(
    st.lists(
        st.tuples(vectors, vectors, st.tuples(angles, angles, angles)), min_size=1, max_size=4
    ),
    st.lists(st.integers(0, 400)),
    st.sampled_from(['quaternion', 'inverse', 'euler']),
)
def test_decoder_reads_at_any_cut_what_the_board_sends(sent, cuts, attitude):
    settings = Um7Settings(attitude=attitude)
    board, read = Um7Board(settings), Um7Decoder(settings)
    sent = [(values, turn, quaternion_from_euler(*euler)) for values, turn, euler in sent]
    data = b''.join(board.measure(measurement(*each, 0.25 * k)) for k, each in enumerate(sent))
    got = [event for piece in pieces(data, cuts) for event in read.feed(piece)]
    assert [event.clock for event in got] == [0.25 * k for k in range(len(sent))]
    assert [event.start for event in got] == [len(data) // len(sent) * k for k in range(len(sent))]
    for event, (values, turn, orientation) in zip(got, sent, strict=True):
        assert event.values == pytest.approx(values, rel=1e-6)
        assert event.rate == pytest.approx(turn, rel=1e-6, abs=1e-9)
        same = abs(np.dot(event.orientation, orientation))
        assert math.acos(min(same, 1.0)) < 3e-4


@pytest.mark.parametrize('index', range(23))
@pytest.mark.parametrize('damage', ['lost', 'doubled', 'flipped'])
def test_a_damaged_byte_costs_its_instant_alone(index, damage):
    bad = bytearray(force(1.0, (0.1, 0.2, -0.9)))
    if damage == 'lost':
        del bad[index]
    elif damage == 'doubled':
        bad.insert(index, bad[index])
    else:
        bad[index] ^= 0x10
    rest = b''.join(instant(1.0 + 0.1 * k) for k in range(1, 6))
    events = decoder().feed(instant(0.9) + rate(1.0) + bytes(bad) + quaternion(1.0) + rest)
    whole = [0.9, 1.1, 1.2, 1.3, 1.4, 1.5]
    if damage == 'doubled' and index in (0, 22):
        whole.insert(1, 1.0)  # a packet beside a byte too many
    assert times(events) == pytest.approx(whole)
    assert FrameError in errors(events)


@given(st.binary(max_size=150))
@example(b'snp' * 20)
@example(b'snp\xfe' + b'\0' * 40)
@example(b'snps')
def test_after_garbage_instants_are_found_again(noise):
    """Two packets at most hide in what looks like the longest one."""
    events = decoder().feed(noise + b''.join(instant(float(k)) for k in range(5)))
    assert times(events)[-3:] == [2.0, 3.0, 4.0]


def test_head_within_a_packet_is_no_packet():
    number = struct.unpack('>f', b'snp\xfd')[0] / 1e32
    data = b''.join(
        rate(float(k), (number, 0, 0)) + force(float(k)) + quaternion(float(k)) for k in range(4)
    )
    assert times(decoder().feed(data)) == [0.0, 1.0, 2.0, 3.0]
    within = packet(97, b'snp\xfdsnp\xfd' + struct.pack('>2f', 0.0, 0.0))
    events = decoder().feed(within[5:] + b''.join(instant(float(k)) for k in range(6)))
    assert times(events)[-4:] == [2.0, 3.0, 4.0, 5.0]


def test_text_between_packets_is_said_once_each_time():
    text = b'$PCHRA,105.015,0.0,0.0,0.0,0.0,*70\r\n'
    events = decoder().feed(b''.join(instant(0.1 * k) + text for k in range(4)))
    assert len(times(events)) == 4
    assert errors(events) == [FrameError] * 4


# Frames ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('compass', 'yaw'), [(0.0, 90.0), (90.0, 0.0), (180.0, -90.0), (-90.0, 180.0), (45.0, 45.0)]
)
@pytest.mark.parametrize('attitude', ['quaternion', 'inverse', 'euler'])
def test_a_level_board_points_where_its_compass_does(compass, yaw, attitude):
    """North is +90° in ENU, east 0; up reads +1 g."""
    half = math.radians(compass) / 2.0
    sent = {
        'quaternion': quaternion(1.0, (math.cos(half), 0.0, 0.0, math.sin(half))),
        'inverse': quaternion(1.0, (math.cos(half), 0.0, 0.0, -math.sin(half))),
        'euler': euler(1.0, 0.0, 0.0, compass),
    }[attitude]
    (reading,) = decoder(attitude=attitude).feed(rate(1.0) + force(1.0) + sent)
    x, y, _, _ = reading.orientation
    assert (x, y) == pytest.approx((0.0, 0.0), abs=1e-4)
    off = math.degrees(yaw_from_quaternion(reading.orientation)) - yaw
    assert (off + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.01)
    assert reading.values == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ('roll', 'pitch', 'read', 'up'),
    [
        (0.0, 90.0, (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)),  # nose up: forward is up
        (90.0, 0.0, (0.0, -1.0, 0.0), (0.0, 1.0, 0.0)),  # right side down: left is up
        (180.0, 0.0, (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)),  # on its back
    ],
)
def test_a_tilted_board_at_rest_feels_what_its_attitude_says(roll, pitch, read, up):
    """In the world it is +1 g up, so the axes of force and attitude belong together."""
    (reading,) = decoder(attitude='euler').feed(
        rate(1.0) + force(1.0, read) + euler(1.0, roll, pitch, 30.0)
    )
    assert reading.values == pytest.approx(up)
    world = Rotation.from_quat(reading.orientation).apply(reading.values)
    assert world == pytest.approx((0.0, 0.0, 1.0), abs=1e-4)


@given(angles, angles, angles)
def test_attitude_is_that_of_the_matrices(roll, pitch, yaw):
    ned = Rotation.from_euler('xyz', [roll, pitch, yaw])
    here = Rotation.from_quat(turned(tuple(ned.as_quat())))
    assert here.as_matrix() == pytest.approx(NED_TO_ENU @ ned.as_matrix() @ RIGHT_DOWN, abs=1e-12)
    assert turned(turned((0.1, 0.2, 0.3, 0.9))) == pytest.approx((0.1, 0.2, 0.3, 0.9))


def test_turning_clockwise_seen_from_above_lowers_the_yaw():
    (reading,) = decoder().feed(rate(1.0, (0.0, 0.0, 90.0)) + force(1.0) + quaternion(1.0))
    assert reading.rate == pytest.approx((0.0, 0.0, -math.pi / 2.0))


@pytest.mark.parametrize('settings', [{'attitude': 'matrix'}, {'together': -0.1}])
def test_settings_that_no_board_has_are_refused(settings):
    with pytest.raises(SettingsError, match=rf'driver\.serial\.um7\.{next(iter(settings))}'):
        Um7Settings(**settings)
