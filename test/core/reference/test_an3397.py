"""AN3397's program: each quirk by hand, all of it against a slow transcription in C's integers."""

from ctypes import c_int16, c_int32, c_uint8, c_uint32
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dead_reckoning.core.reference.an3397 import Axis, Positioning, run


def axis(zero=0, **state):
    return Axis(zero=zero, **state)


def accelerations(one, counts):
    """Feed 64 equal conversions per update; return what the axis makes of each."""
    found = []
    for count in counts:
        one.update(64 * count)
        found.append(one.acceleration)
    return found


def velocities(one, counts):
    found = []
    for count in counts:
        one.update(64 * count)
        found.append(one.velocity)
    return found


def test_the_last_acceleration_leaks_into_the_next_average():
    # (64 · 72 + 72) >> 6 = 73
    assert accelerations(axis(), [72, 72, 72]) == [72, 73, 73]
    assert accelerations(axis(corrected=True), [72, 72, 72]) == [72, 72, 72]


def test_leak_of_less_than_64_costs_a_count_below_zero_only():
    # (64 · 123 - 5) >> 6 = 122
    assert accelerations(axis(128), [123, 123, 123]) == [-5, -6, -6]
    assert accelerations(axis(128), [133, 133, 133]) == [5, 5, 5]
    assert accelerations(axis(128, corrected=True), [123, 123, 123]) == [-5, -5, -5]


def test_averages_floor():
    one = axis()
    one.calibrate(1024 * 100 + 1023)
    assert one.zero == 100
    one.update(64 * 100 + 64 * 10 - 1)
    assert one.acceleration == 9


def test_second_calibration_begins_with_the_first_zero():
    one = axis()
    one.calibrate(1024 * 200)
    one.calibrate(1024 * 100 + 900)
    assert one.zero == 101
    fresh = axis()
    fresh.calibrate(1024 * 100 + 900)
    assert fresh.zero == 100


def test_window_holds_three_counts_on_either_side():
    counts = [128 + offset for offset in (3, 4, -3, -4)]
    assert [accelerations(axis(128), [count])[0] for count in counts] == [0, 4, 0, -4]


def test_halves_floor_so_that_equal_pulses_up_and_down_do_not_cancel():
    # The trapezoid of a pulse of one update is 5: up it gives 4, down -6.
    assert velocities(axis(128, corrected=True), [133, 128]) == [2, 4]
    assert velocities(axis(128, corrected=True), [123, 128]) == [-3, -6]


def test_position_floors_half_a_velocity():
    one = axis(128, velocity=0, acceleration=-5, corrected=True)
    one.update(64 * 123)
    assert (one.velocity, one.position) == (-5, -3)


@pytest.mark.parametrize(
    ('position', 'velocity', 'shift', 'then'),
    [
        (8190, 1, 18, 8191),
        (8191, 1, 18, -8192),
        (-8192, -1, 18, 8191),
        (8191, 1, 17, 8192),
        (16383, 1, 17, -16384),
        (8191, 1, 0, 8192),
        (0, 1, 31, -1),
    ],
)
def test_position_wraps_where_the_shift_pushes_it_out(position, velocity, shift, then):
    one = axis(128, position=position, velocity=velocity, shift=shift)
    one.update(64 * 128)
    assert one.position == then


def test_velocity_and_position_have_32_bits():
    one = axis(velocity=2**31 - 1, acceleration=10, corrected=True, shift=0)
    one.update(64 * 10)
    assert one.velocity == -(2**31) + 9
    # The difference of the velocities wraps too, back to 10.
    assert one.position == -(2**31) + 4


def test_movement_ends_at_the_25th_quiet_update():
    one = axis(128, velocity=7)
    assert velocities(one, [128] * 24) == [7] * 24
    assert one.position == 7 * 24
    assert velocities(one, [128]) == [0]
    assert one.position == 7 * 25, 'the position of that update still moves'
    assert velocities(one, [128]) == [0]


def test_acceleration_begins_the_count_anew():
    one = axis(128, velocity=7)
    accelerations(one, [128] * 24 + [148])
    assert one.quiet == 0
    assert one.velocity == 17


def test_count_is_a_byte_and_wraps_without_harm():
    one = axis(128)
    velocities(one, [128] * 255)
    assert one.quiet == 255
    assert velocities(one, [128] * 30) == [0] * 30
    assert one.quiet == 29


def test_axes_do_not_touch_each_other():
    both = Positioning()
    both.calibrate(1024 * 128, 1024 * 100)
    update = both.update(64 * 148, 64 * 80)
    assert update[:-1] == (20, -20, 10, -10, 5, -5)
    assert update.frame == bytes.fromhex('03110000 0101fe')
    frame = Positioning(end_of_frame=0x0A).update(0, 0).frame
    assert frame[-1] == 0x0A


def test_conversions_that_fill_no_update_give_none():
    counts = np.full((1024 + 2 * 64 + 63, 2), 128)
    assert len(run(counts)) == 2
    assert run(counts[:1024]) == []


def test_count_is_kept_in_a_byte():
    counts = np.full((1024 + 64, 2), 128)
    assert run(counts + 256) == run(counts)


class Transcription:
    """One axis as the controller keeps it: an array of two, and each conversion one by one."""

    def __init__(self, corrected, shift):
        self.corrected, self.shift = corrected, shift
        self.sum = c_uint32(0)
        self.a = [c_int16(0), c_int16(0)]
        self.v = [c_int32(0), c_int32(0)]
        self.p = [c_int32(0), c_int32(0)]
        self.quiet = c_uint8(0)

    def calibrate(self, conversions):
        for conversion in conversions:
            self.sum.value += conversion
        self.sum.value //= 1024

    def update(self, conversions):
        a, v, p = self.a, self.v, self.p
        if self.corrected:
            a[1].value = 0
        for conversion in conversions:
            a[1].value += conversion
        a[1].value //= 64
        a[1].value -= self.sum.value
        if abs(a[1].value) < 4:
            a[1].value = 0
        v[1].value = v[0].value + a[0].value + (a[1].value - a[0].value) // 2
        p[1].value = p[0].value + v[0].value + (v[1].value - v[0].value) // 2
        a[0].value, v[0].value = a[1].value, v[1].value
        p[1].value *= 2**self.shift
        sent = p[1].value
        p[1].value //= 2**self.shift
        if a[1].value == 0:
            self.quiet.value += 1
        else:
            self.quiet.value = 0
        if self.quiet.value >= 25:
            v[0].value = v[1].value = 0
        p[0].value = p[1].value
        return a[1].value, v[1].value, p[1].value, sent


def transcribed(counts, corrected, shift, end):
    axes = [Transcription(corrected, shift), Transcription(corrected, shift)]
    rows = []
    for index, one in enumerate(axes):
        one.calibrate(counts[:1024, index].tolist())
    edges = range(1024, len(counts) + 1, 64)
    for begin, stop in pairwise(edges):
        (ax, vx, px, x), (ay, vy, py, y) = (
            one.update(counts[begin:stop, index].tolist()) for index, one in enumerate(axes)
        )
        direction = (0x80 if x < 0 else 0x10) + (0x01 if y < 0 else 0x08)
        frame = [3, direction, abs(x) // 2**24, abs(y) // 2**24, 1, 1, end]
        rows.append((ax, ay, vx, vy, px, py, bytes(frame)))
    return rows


STRETCHES = st.lists(
    st.tuples(
        st.integers(0, 255),
        st.integers(0, 255),
        st.integers(0, 40),
        st.sampled_from([1, 2, 7, 27]),
    ),
    min_size=1,
    max_size=8,
)
"""Level of x and y, spread, and how many updates it lasts."""


@given(
    zero=st.tuples(st.integers(0, 255), st.integers(0, 255)),
    stretches=STRETCHES,
    seed=st.integers(0, 2**32 - 1),
    corrected=st.booleans(),
    shift=st.integers(0, 31),
    end=st.integers(0, 255),
)
@settings(max_examples=60, deadline=None)
def test_program_equals_its_transcription(zero, stretches, seed, corrected, shift, end):
    generator = np.random.default_rng(seed)
    parts = [generator.integers(-2, 3, (1024, 2)) + zero]
    for x, y, spread, updates in stretches:
        level = np.array([x, y])
        parts.append(generator.integers(-spread, spread + 1, (64 * updates, 2)) + level)
        # At rest often enough that movements end.
        parts.append(generator.integers(-2, 3, (64 * 3 * (updates // 7), 2)) + zero)
    counts = np.clip(np.concatenate(parts), 0, 255)
    found = run(counts, corrected=corrected, shift=shift, end_of_frame=end)
    assert [tuple(update) for update in found] == transcribed(counts, corrected, shift, end)


@given(st.binary(min_size=2 * (1024 + 640), max_size=2 * (1024 + 640)))
@settings(max_examples=40, deadline=None)
def test_any_counts_give_what_the_transcription_gives(conversions):
    counts = np.frombuffer(conversions, dtype=np.uint8).astype(np.int64).reshape(-1, 2)
    found = run(counts)
    assert [tuple(update) for update in found] == transcribed(counts, False, 18, 0xFE)
