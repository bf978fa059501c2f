"""Scans are read as the kernel lays them out."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.errors import WrongDeviceError
from dead_reckoning.sources.iio.scan import Element, Layout


@st.composite
def elements(draw):
    storage = draw(st.sampled_from([8, 16, 32, 64]))
    shift = draw(st.integers(0, storage - 1))
    bits = draw(st.integers(1, storage - shift))
    return draw(st.booleans()), draw(st.booleans()), bits, storage, shift


@given(elements(), st.data())
def test_a_value_of_any_type_comes_back_whatever_the_bits_beside_it(type_, data):
    big, signed, bits, storage, shift = type_
    low, high = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
    value = data.draw(st.integers(low, min(high, 2**63 - 1)))
    beside = data.draw(st.integers(0, 2**storage - 1)) & ~(((1 << bits) - 1) << shift)
    word = (value & (1 << bits) - 1) << shift | beside
    stored = word.to_bytes(storage // 8, 'big' if big else 'little')
    text = f'{"be" if big else "le"}:{"s" if signed else "u"}{bits}/{storage}>>{shift}'
    element = Element.parse(text + '\n')
    assert element.values(np.frombuffer(stored, np.uint8)[np.newaxis]).tolist() == [value]


def test_axes_and_stamp_of_an_adxl345():
    axis, stamp = Element.parse('le:s13/16>>0'), Element.parse('le:s64/64>>0')
    layout = Layout({'t': (3, stamp), 'z': (2, axis), 'x': (0, axis), 'y': (1, axis)})
    assert layout.size == 16
    data = struct.pack('<3hxxq', -4096, 4095, -1, 7) + struct.pack('<3hxxq', 1, 2, 3, -8)
    assert layout.values(data, 'x').tolist() == [-4096, 1]
    assert layout.values(data, 'y').tolist() == [4095, 2]
    assert layout.values(data, 'z').tolist() == [-1, 3]
    assert layout.values(data, 't').tolist() == [7, -8]


def test_elements_stand_at_multiples_of_their_size_in_the_order_of_their_index():
    layout = Layout(
        {
            'byte': (0, Element.parse('le:u8/8>>0')),
            'four': (5, Element.parse('be:s24/32>>8')),
            'row': (2, Element.parse('le:s16/16X4>>0')),
        }
    )
    assert layout.size == 24, 'a byte, to 8, four of two bytes, four bytes, to a multiple of 8'
    data = (
        bytes([200]) + bytes(7) + struct.pack('<4h', 5, 6, 7, 8) + b'\xff\xff\xfe\x99' + bytes(4)
    )
    assert layout.values(data, 'byte').tolist() == [200]
    assert layout.values(data, 'row').tolist() == [5]
    assert layout.values(data, 'four').tolist() == [-2]


@pytest.mark.parametrize('text', ['', 'le:s13', 'xx:s13/16>>0', 'le:s13/12>>0', 'le:s16/16>>4'])
def test_what_is_no_type_is_named(text):
    with pytest.raises(WrongDeviceError):
        Element.parse(text)
