"""From bytes with the time of their arrival to counts with stamps."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.accelerometer import UNITS
from dead_reckoning.core.errors import ColumnError, CutError, OutOfRangeError, ReadingError
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.sources.driver import serial_receiver
from dead_reckoning.sources.driver_settings import DriverSettings

START_NS = 1_700_000_000 * NANOSECONDS
BYTE_NS = 1_000_000
"""A byte takes a millisecond at 10,000 baud."""


def receiver(**values):
    """Return a receiver at 10,000 baud that is in step, and has been fed one byte."""
    keys = {f'driver.{key.replace("__", ".")}': value for key, value in values.items()}
    made = serial_receiver(Configuration({'driver.serial.baud': 10_000, **keys}))
    conversions, errors = made.take(b'\n', START_NS)
    assert (len(conversions), errors) == (0, [])
    return made


def test_stamp_is_when_the_first_byte_of_the_line_began():
    conversions, _ = receiver().take(b'1,2,3\n', START_NS)
    assert conversions.stamps_ns.tolist() == [START_NS - 6 * BYTE_NS]
    assert conversions.counts.tolist() == [[1.0, 2.0, 3.0]]


def test_lines_that_arrive_together_have_their_places_on_the_wire():
    conversions, _ = receiver().take(b'1,2,3\n44,55,66\n7,', START_NS)
    assert conversions.stamps_ns.tolist() == [START_NS - 17 * BYTE_NS, START_NS - 11 * BYTE_NS]


def test_a_line_that_arrives_in_two_parts_counts_back_from_its_end():
    made = receiver()
    assert len(made.take(b'1,2', START_NS)[0]) == 0
    conversions, _ = made.take(b',3\n', START_NS + 50 * BYTE_NS)
    assert conversions.stamps_ns.tolist() == [START_NS + 44 * BYTE_NS]


def test_known_latency_is_taken_off():
    conversions, _ = receiver(serial__latency=0.25).take(b'1,2,3\n', START_NS)
    assert conversions.stamps_ns.tolist() == [START_NS - 6 * BYTE_NS - NANOSECONDS // 4]


@given(st.lists(st.tuples(st.integers(1, 4), st.integers(0, 900_000_000)), max_size=30))
def test_stamps_rise_though_arrivals_go_back_and_forth_within_a_second(arrivals):
    made = receiver()
    stamps = [
        stamp
        for lines, offset in arrivals
        for stamp in made.take(b'1,2,3\n' * lines, START_NS + offset)[0].stamps_ns.tolist()
    ]
    assert all(b > a for a, b in pairwise(stamps))


def test_a_clock_that_goes_back_by_more_than_a_second_is_followed():
    made = receiver()
    made.take(b'1,2,3\n', START_NS)
    conversions, _ = made.take(b'1,2,3\n', START_NS - 10 * NANOSECONDS)
    assert conversions.stamps_ns.tolist() == [START_NS - 10 * NANOSECONDS - 6 * BYTE_NS]


def test_errors_cost_their_line_only():
    made = receiver()
    conversions, errors = made.take(b'1,2,3\n1,2\n4,5,6\n', START_NS)
    assert conversions.counts.tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    assert [type(error) for error in errors] == [ColumnError]
    assert made.readings == 2


def test_what_was_begun_before_a_restart_is_no_reading():
    made = receiver()
    made.take(b'1,2,', START_NS)
    assert [type(error) for error in made.restart()] == [CutError]
    conversions, errors = made.take(b'3\n4,5,6\n', START_NS + NANOSECONDS)
    assert conversions.counts.tolist() == [[4.0, 5.0, 6.0]]
    assert conversions.stamps_ns.tolist() == [START_NS + NANOSECONDS - 6 * BYTE_NS]
    assert [type(error) for error in errors] == [CutError]


@pytest.mark.parametrize(
    ('line', 'settings'),
    [
        (b'0,0,4098\n', {}),
        (b'-2,0,0\n', {}),
        (b'0,0,1025\n', {'adc_bits': 10}),
        (b'0,0,3.4\n', {'serial__ascii__unit': 'volts'}),
        (b'0,0,600\n', {'sensor': 'adxl345'}),
    ],
)
def test_a_reading_that_the_converter_can_not_give_is_refused(line, settings):
    conversions, (error,) = receiver(**settings).take(line + b'1,1,1\n', START_NS)
    assert len(conversions) == 1
    assert isinstance(error, OutOfRangeError)
    assert line.strip().decode().split(',')[2] in str(error).replace(' ', '')
    assert 'driver.' in str(error)


@pytest.mark.parametrize('sensor', ['mma7260qt', 'adxl330', 'adxl345'])
@pytest.mark.parametrize(('unit', 'scale'), [('g', GRAVITY), ('m/s2', 1.0)])
def test_readings_in_g_and_in_si_become_that_force(sensor, unit, scale):
    values = np.array([0.25, -0.5, 1.0]) * GRAVITY / scale
    line = ','.join(f'{value:.9f}' for value in values) + '\n'
    made = receiver(sensor=sensor, serial__ascii__unit=unit)
    counts = made.take(line.encode(), START_NS)[0].counts
    model = DriverSettings(sensor=sensor).model()
    force = model.force(counts, np.array(model.zero_g))[0]
    assert force == pytest.approx(values * scale, abs=1e-6)


def test_volts_become_counts():
    volts = receiver(serial__ascii__unit='volts', adc_bits=10)
    counts = volts.take(b'0,1.65,3.3\n', START_NS)[0].counts
    assert counts[0] == pytest.approx([0.0, 512.0, 1024.0])


def test_a_force_beyond_the_range_counts_as_clipped():
    made = receiver(serial__ascii__unit='g')
    counts = made.take(b'0,0,9\n0,0,1e8\n0,0,1\n', START_NS)[0].counts
    clipped = DriverSettings().model().clipped(counts)
    assert clipped.tolist() == [[False, False, True]] * 2 + [[False] * 3]


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('unit', UNITS)
@given(
    st.lists(
        st.sampled_from([b'1,2,3\n', b'-9e8,9e8,.1\n', b'5,', b'\n', b'\xff'])
        | st.binary(max_size=40)
    )
)
def test_whatever_comes_becomes_finite_counts_or_errors(unit, parts):
    made = receiver(serial__ascii__unit=unit)
    for number, data in enumerate(parts):
        conversions, errors = made.take(data, START_NS + number)
        assert conversions.counts.shape == (len(conversions), 3)
        assert conversions.stamps_ns.shape == (len(conversions),)
        assert np.isfinite(conversions.counts).all()
        assert all(isinstance(error, ReadingError) for error in errors)
