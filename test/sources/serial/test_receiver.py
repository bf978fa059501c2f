"""From bytes with the time of their arrival to counts with stamps."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.accelerometer import UNITS
from dead_reckoning.core.errors import (
    ColumnError,
    CutError,
    FrameError,
    OutOfRangeError,
    ReadingError,
)
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS, UNMEASURED_VARIANCE
from dead_reckoning.sources.driver import serial_receiver
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.serial.protocols import Decoder, Position, Reading
from dead_reckoning.sources.serial.receiver import Receiver
from dead_reckoning.sources.serial.settings import SerialSettings

START_NS = 1_700_000_000 * NANOSECONDS
BYTE_NS = 1_000_000
"""A byte takes a millisecond at 10,000 baud."""


def receiver(**values):
    """Return a receiver at 10,000 baud that is in step, and has been fed one byte."""
    keys = {f'driver.{key.replace("__", ".")}': value for key, value in values.items()}
    made = serial_receiver(Configuration({'driver.serial.baud': 10_000, **keys}))
    conversions, errors, _ = made.take(b'\n', START_NS)
    assert (len(conversions), errors) == (0, [])
    return made


def test_stamp_is_when_the_first_byte_of_the_line_began():
    conversions, *_ = receiver().take(b'1,2,3\n', START_NS)
    assert conversions.stamps_ns.tolist() == [START_NS - 6 * BYTE_NS]
    assert conversions.counts.tolist() == [[1.0, 2.0, 3.0]]


def test_lines_that_arrive_together_have_their_places_on_the_wire():
    conversions, *_ = receiver().take(b'1,2,3\n44,55,66\n7,', START_NS)
    assert conversions.stamps_ns.tolist() == [START_NS - 17 * BYTE_NS, START_NS - 11 * BYTE_NS]


def test_a_line_that_arrives_in_two_parts_counts_back_from_its_end():
    made = receiver()
    assert len(made.take(b'1,2', START_NS)[0]) == 0
    conversions, *_ = made.take(b',3\n', START_NS + 50 * BYTE_NS)
    assert conversions.stamps_ns.tolist() == [START_NS + 44 * BYTE_NS]


def test_known_latency_is_taken_off():
    conversions, *_ = receiver(serial__latency=0.25).take(b'1,2,3\n', START_NS)
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
    conversions, *_ = made.take(b'1,2,3\n', START_NS - 10 * NANOSECONDS)
    assert conversions.stamps_ns.tolist() == [START_NS - 10 * NANOSECONDS - 6 * BYTE_NS]


def test_errors_cost_their_line_only():
    made = receiver()
    conversions, errors, _ = made.take(b'1,2,3\n1,2\n4,5,6\n', START_NS)
    assert conversions.counts.tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    assert [type(error) for error in errors] == [ColumnError]
    assert made.readings == 2


def test_what_was_begun_before_a_restart_is_no_reading():
    made = receiver()
    made.take(b'1,2,', START_NS)
    assert [type(error) for error in made.restart()] == [CutError]
    conversions, errors, _ = made.take(b'3\n4,5,6\n', START_NS + NANOSECONDS)
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
    conversions, (error,), _ = receiver(**settings).take(line + b'1,1,1\n', START_NS)
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
        conversions, errors, _ = made.take(data, START_NS + number)
        assert conversions.counts.shape == (len(conversions), 3)
        assert conversions.stamps_ns.shape == (len(conversions),)
        assert np.isfinite(conversions.counts).all()
        assert all(isinstance(error, ReadingError) for error in errors)


class Scripted(Decoder):
    """Give, for each byte, the event of that number; a byte is a whole frame."""

    unit = 'counts'

    def __init__(self, events, *, polled=False):
        self.POLLED = polled
        self._events = events
        self._fed = 0

    def feed(self, data):
        found = [replace_start(self._events[byte], self._fed + n) for n, byte in enumerate(data)]
        self._fed += len(data)
        return found

    def restart(self):
        return []


def replace_start(event, start):
    return event if isinstance(event, ReadingError) else dataclasses.replace(event, start=start)


def scripted(*events, **options):
    """Return a receiver at 10,000 baud of a board whose byte n stands for event n."""
    settings = SerialSettings(baud=10_000, latency=options.pop('latency', 0.0))
    return Receiver(Scripted(events, **options), DriverSettings().model(), settings)


def reading(x=1.0, **more):
    return Reading((x, 2.0, 3.0), 0, **more)


def test_rates_and_orientations_go_along_and_what_lacks_is_nan():
    made = scripted(reading(rate=(0.1, 0.2, 0.3)), reading(orientation=(0.0, 0.0, 0.6, 0.8)))
    conversions, *_ = made.take(b'\0\1', START_NS)
    np.testing.assert_equal(conversions.rates, [[0.1, 0.2, 0.3], [np.nan] * 3])
    np.testing.assert_equal(conversions.orientations, [[np.nan] * 4, [0.0, 0.0, 0.6, 0.8]])
    conversions, *_ = scripted(reading()).take(b'\0', START_NS)
    assert conversions.rates is None
    assert conversions.orientations is None


def test_a_position_is_a_state_of_which_nothing_else_is_known():
    (state,) = scripted(Position(1.5, -2.0, 0)).take(b'\0', START_NS).positions
    assert state.stamp_ns == START_NS - BYTE_NS
    assert state.position == (1.5, -2.0, 0.0)
    assert state.position_covariance[::4] == (1.0, 1.0, UNMEASURED_VARIANCE)
    assert state.attitude_covariance[::4] == (UNMEASURED_VARIANCE,) * 3
    assert state.velocity_covariance[::4] == (UNMEASURED_VARIANCE,) * 3
    assert state.angular_velocity is None


def test_a_polled_reading_is_stamped_between_question_and_answer():
    """Two bytes of question, from 0 to 2 ms; the answer is on the wire from 9 to 10 ms."""
    made = scripted(reading(), polled=True, latency=0.0005)
    made.told(b'V?', START_NS)
    conversions, *_ = made.take(b'\0', START_NS + 10 * BYTE_NS)
    assert conversions.stamps_ns.tolist() == [START_NS + 5 * BYTE_NS]


def test_only_the_answer_is_stamped_so_and_not_one_that_came_before_the_question():
    made = scripted(reading(), polled=True)
    made.told(b'V', START_NS)
    early, *_ = made.take(b'\0', START_NS)
    answer, *_ = made.take(b'\0', START_NS + 4 * BYTE_NS)
    other, *_ = made.take(b'\0', START_NS + 20 * BYTE_NS)
    stamps = [int(c.stamps_ns[0]) - START_NS for c in (early, answer, other)]
    assert stamps == [-BYTE_NS, 2 * BYTE_NS, 19 * BYTE_NS]


def test_equal_answers_and_numbers_that_come_twice_are_counted_and_handed_on():
    polled = scripted(reading(1.0), reading(5.0), polled=True)
    assert len(polled.take(b'\0\0\1\1\0', START_NS).conversions) == 5
    assert polled.duplicates == 2
    numbered = scripted(reading(clock=1.0), reading(clock=2.0))
    assert len(numbered.take(b'\0\1\1', START_NS).conversions) == 3
    assert numbered.duplicates == 1
    streaming = scripted(reading())
    streaming.take(b'\0\0\0', START_NS)
    assert streaming.duplicates == 0


def test_what_is_damaged_and_how_often_it_was_in_step_again_is_counted():
    made = scripted(reading(), FrameError('no frame'), CutError('cut'))
    made.take(b'\2\0\1\1\0\0\1', START_NS)
    assert (made.bad, made.resynchronised) == (3, 1)
    made.take(b'\0', START_NS + NANOSECONDS)
    figures = made.figures()
    assert figures['bad_readings'] == 3
    assert figures['resynchronised'] == 2
    assert figures['last_error'] == 'no frame'


def test_rate_and_jitter_are_those_of_the_stamps_of_late():
    made = scripted(reading())
    assert (made.figures()['rate'], made.figures()['jitter']) == ('0.00', '0.000000')
    for number in range(300):
        late_ns = 2_000_000 * (number % 2)
        made.take(b'\0', START_NS + number * 10_000_000 + late_ns)
    assert float(made.figures()['rate']) == pytest.approx(100.0, abs=0.1)
    assert float(made.figures()['jitter']) == pytest.approx(0.002, abs=1e-5)
    made.restart()
    assert made.figures()['rate'] == '0.00'


NUMBERED = [reading(clock=float(number)) for number in range(256)]
"""At 100 Hz."""


@given(st.lists(st.integers(1, 16), min_size=1, max_size=40), st.integers(0, 100))
def test_stamps_by_the_clock_of_a_board_do_not_depend_on_how_bytes_are_cut(cuts, seed):
    """A burst holds what came in 0.16 s, byte after byte, and arrives as a whole or in parts."""
    random = np.random.default_rng(seed)
    whole, cut = scripted(*NUMBERED), scripted(*NUMBERED)
    for number, size in enumerate(cuts):
        burst = bytes((16 * number + k) % 256 for k in range(16)) if number < 16 else b''
        arrival_ns = START_NS + round(
            (0.16 * (number + 1) + random.uniform(0, 0.01)) * NANOSECONDS
        )
        ours = whole.take(burst, arrival_ns).conversions.stamps_ns.tolist()
        first = cut.take(burst[:size], arrival_ns - len(burst[size:]) * BYTE_NS)
        rest = cut.take(burst[size:], arrival_ns)
        parts = [*first.conversions.stamps_ns.tolist(), *rest.conversions.stamps_ns.tolist()]
        assert parts == ours


def test_stamps_by_the_clock_of_a_board_are_even_and_a_restart_forgets_it():
    made = scripted(*NUMBERED)
    random = np.random.default_rng(1)
    found = []
    for number in range(256):
        delay = random.uniform(0.0, 0.016) * (number % 8 > 0)
        arrival_ns = START_NS + round((0.01 * number + delay) * NANOSECONDS) + BYTE_NS
        found += made.take(bytes([number]), arrival_ns).conversions.stamps_ns.tolist()
    error = (np.array(found) - START_NS) / NANOSECONDS - 0.01 * np.arange(256)
    assert np.abs(error[100:]).max() < 0.0005
    made.restart()
    stamps = made.take(b'\0', START_NS + 10 * NANOSECONDS).conversions.stamps_ns
    assert stamps.tolist() == [START_NS + 10 * NANOSECONDS - BYTE_NS]
