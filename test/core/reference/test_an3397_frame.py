"""The frame of AN3397: bytes by hand, and what is left of every position."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import FrameError
from dead_reckoning.core.reference.an3397_frame import decode, encode

POSITIONS = range(-8192, 8192)


@pytest.mark.parametrize(
    ('x', 'y', 'expected'),
    [
        (0, 0, '03 18 00 00 01 01 fe'),
        (63, -63, '03 11 00 00 01 01 fe'),
        (-64, 64, '03 88 01 01 01 01 fe'),
        (-65, -128, '03 81 01 02 01 01 fe'),
        (8191, -8192, '03 11 7f 80 01 01 fe'),
        # 14 bits are left: 8192 wraps to -8192, 16384 to 0.
        (8192, 16384, '03 88 80 00 01 01 fe'),
    ],
)
def test_bytes_by_hand(x, y, expected):
    assert encode(x, y).hex(' ') == expected


def test_every_position_comes_back_cut_to_64_on_each_axis():
    for position in POSITIONS:
        cut = math.trunc(position / 64) * 64
        assert decode(encode(position, 0)) == (cut, 0)
        assert decode(encode(0, position)) == (0, cut)


@given(
    x=st.integers(-(2**31), 2**31 - 1),
    y=st.integers(-(2**31), 2**31 - 1),
    shift=st.integers(0, 31),
    end=st.integers(0, 255),
)
def test_what_the_shift_leaves_comes_back_cut_to_the_byte_that_is_sent(x, y, shift, end):
    kept = 2 ** (32 - shift)
    unit = max(2**24 // 2**shift, 1)

    def cut(position):
        inside = (position + kept // 2) % kept - kept // 2
        return math.trunc(inside / unit) * unit

    assert decode(encode(x, y, shift, end), shift, end) == (cut(x), cut(y))


@pytest.mark.parametrize(
    ('frame', 'words'),
    [
        ('', '7 bytes, not 0'),
        ('03 18 00 00 01 01', '7 bytes, not 6'),
        ('03 18 00 00 01 01 fe 03', '7 bytes, not 8'),
        ('04 18 00 00 01 01 fe', 'no frame'),
        ('03 18 00 00 00 01 fe', 'no frame'),
        ('03 18 00 00 01 02 fe', 'no frame'),
        ('03 18 00 00 01 01 ff', 'no frame'),
        ('03 00 00 00 01 01 fe', '0x00 in .* is no direction'),
        ('03 10 00 00 01 01 fe', '0x10 in .* is no direction'),
        ('03 98 00 00 01 01 fe', '0x98 in .* is no direction'),
        ('03 18 80 00 01 01 fe', '128 in .* is beyond'),
        ('03 81 81 00 01 01 fe', '129 in .* is beyond'),
        ('03 81 00 81 01 01 fe', '129 in .* is beyond'),
    ],
)
def test_other_bytes_are_refused(frame, words):
    with pytest.raises(FrameError, match=words):
        decode(bytes.fromhex(frame))


@given(st.binary(max_size=9))
def test_no_bytes_do_harm(data):
    try:
        x, y = decode(data)
    except FrameError:
        return
    # Zero has two signs in a frame, of which the encoder uses one.
    sent = data[1]
    if (x, y).count(0) == 0:
        assert encode(x, y)[1] == sent
    assert encode(x, y)[2:] == data[2:]
