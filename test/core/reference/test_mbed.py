"""The mbed page's program: each quirk by hand, all of it against a slow transcription."""

from ctypes import c_int16, c_int32
from fractions import Fraction
from math import trunc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dead_reckoning.core.reference import mbed
from dead_reckoning.core.reference.mbed import Constants, means


def constants(**changed):
    values = {
        'calibration_count': 2,
        'sample_count': 2,
        'window_min': -3,
        'window_max': 5,
        'gain': 0.5,
        'update_time': 2.0,
        'no_movement': 2,
    }
    return Constants(**(values | changed))


def run(counts, c):
    return list(map(tuple, mbed.run(counts, c).tolist()))


def integrate(averages, c):
    return list(map(tuple, mbed.integrate(np.array(averages), c).tolist()))


def column(updates, index):
    return [update[index] for update in updates]


def test_averages_truncate_toward_zero():
    assert means(np.array([-1, -2, -3, -4, 1, 2]), 2).tolist() == [-1, -3, 1]


def test_zero_truncates_too():
    # -0.5 becomes 0, where a floor would make it -1.
    (update,) = run(np.array([0, -1, 8, 8]), constants())
    assert update[0] == 8 * 0.5


def test_sum_has_32_bits():
    # 70000 · 32767 - 2^32 = -2001277296
    assert means(np.full(70000, 32767), 70000).tolist() == [-28589]


def test_count_has_16_bits():
    (update,) = run(np.array([0, 0, 65536 - 10, 65536 - 10]), constants())
    assert update[0] == -5.0


def test_window_has_two_sides_and_includes_both():
    found = integrate([-4, -3, 0, 5, 6], constants(gain=1.0))
    assert column(found, 0) == [-4.0, 0.0, 0.0, 0.0, 6.0]


def test_zero_outside_of_the_window_is_quiet_all_the_same():
    found = integrate([40, 0, 0, 0], constants(window_min=1, window_max=5))
    assert column(found, 1)[-1] == 0.0


def test_trapezoids_by_hand():
    # v = (0 + 4 / 2) · 2, then 4 + (4 - 1 / 2) · 2; p likewise.
    found = integrate([8, 6], constants(gain=0.5, window_max=3))
    assert found == [(4.0, 4.0, 4.0), (3.0, 11.0, 19.0)]


def test_velocity_ends_after_more_quiet_updates_than_no_movement():
    found = integrate([8, 0, 0, 0, 0], constants())
    # 4 more of the second half of the pulse, then two quiet ones go on; the third ends it.
    assert column(found, 1) == [4.0, 8.0, 8.0, 0.0, 0.0]
    assert column(found, 2) == [4.0, 16.0, 32.0, 48.0, 48.0]


def test_acceleration_begins_the_count_anew():
    found = integrate([8, 0, 0, 8, 0, 0], constants())
    assert all(velocity > 0 for velocity in column(found, 1))


def test_no_movement_of_zero_ends_at_the_first_quiet_update():
    assert column(integrate([8, 0, 8], constants(no_movement=0)), 1) == [4.0, 0.0, 4.0]


def test_conversions_that_fill_no_update_give_none():
    assert len(run(np.zeros(7, dtype=np.int64), constants())) == 2


def transcribed(counts, c):
    """Follow the page conversion by conversion, in C's integers and in doubles."""

    def average(conversions):
        total = c_int32(0)
        for conversion in conversions:
            total.value += c_int16(conversion).value
        return trunc(Fraction(total.value, len(conversions)))

    bias = average(counts[: c.calibration_count])
    a, v, p = [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]
    quiet = 0
    rows = []
    rest = counts[c.calibration_count :]
    while len(rest) >= c.sample_count:
        a[1] = float(average(rest[: c.sample_count]))
        rest = rest[c.sample_count :]
        a[1] -= bias
        if a[1] >= c.window_min and a[1] <= c.window_max:
            a[1] = 0.0
        else:
            a[1] *= c.gain
        v[1] = v[0] + (a[0] + ((a[1] - a[0]) / 2.0)) * c.update_time
        p[1] = p[0] + (v[0] + ((v[1] - v[0]) / 2.0)) * c.update_time
        if a[1] == 0:
            quiet += 1
        else:
            quiet = 0
        if quiet > c.no_movement:
            v[1] = v[0] = 0.0
            quiet = 0
        a[0], v[0], p[0] = a[1], v[1], p[1]
        rows.append((a[1], v[1], p[1]))
    return rows


@given(
    counts=st.one_of(
        st.lists(st.integers(-32768, 32767), min_size=20, max_size=200),
        st.lists(st.integers(-12, 12), min_size=20, max_size=200),
    ),
    calibration_count=st.integers(1, 20),
    sample_count=st.integers(1, 9),
    window_min=st.integers(-10, 2),
    window_max=st.integers(-2, 10),
    gain=st.floats(-10, 10),
    update_time=st.floats(1e-4, 10),
    no_movement=st.integers(0, 5),
)
@settings(max_examples=200, deadline=None)
def test_program_equals_its_transcription(counts, **values):
    c = Constants(**values)
    found = run(np.array(counts), c)
    assert repr(found) == repr(transcribed(counts, c)), 'signs of zeros included'


@pytest.mark.parametrize('gain', [0.0382, -0.0382, 0.0])
def test_gains_of_either_sign(gain):
    c = constants(gain=gain)
    counts = [0, 0, 100, 120, -80, -90, 0, 0, 0, 0, 0, 0]
    assert repr(run(np.array(counts), c)) == repr(transcribed(counts, c))
