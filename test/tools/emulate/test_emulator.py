"""A board behind its line, without a port or a clock."""

import math

import numpy as np
import pytest

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.accelerometer import UNITS
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import yaw_from_quaternion
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.sources.driver import serial_receiver, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.serial.protocols.ascii import AsciiBoard
from dead_reckoning.tools.emulate.emulator import Emulator, Sensor
from dead_reckoning.tools.emulate.faults import Faults

IDEAL = {
    f'driver.simulated.{key}': value
    for key, value in {
        'noise': False,
        'quantise': False,
        'offset': (0.0,) * 3,
        'sensitivity_error': (0.0,) * 3,
        'cross_axis': (0.0,) * 6,
        'nonlinearity': 0.0,
        'low_pass': False,
        'axis_delay': 0.0,
    }.items()
}


def configuration(**values):
    keys = {f'driver.{key.replace("__", ".")}': value for key, value in values.items()}
    return Configuration({'driver.sample_rate': 100.0, **keys})


def emulator(faults=None, **values):
    made = Emulator(configuration(**values), faults or Faults())
    made.switch_on(0.0)
    return made


def test_sensor_measures_what_the_simulator_does_in_every_unit():
    parts = configuration(motion='walk')
    counts = simulated_sensor(parts, 0).read(50).counts
    model, sensor = parts[DriverSettings].model(), Sensor(parts)
    for k in range(50):
        measurement = sensor.measure(0.0)
        assert tuple(measurement.values) == UNITS
        assert measurement.values['counts'] == tuple(counts[k])
        for unit, values in measurement.values.items():
            back = model.counts_of(np.array([values]), unit)[0]
            assert back == pytest.approx(counts[k], abs=1e-6)
    assert sensor.next == pytest.approx(0.5)


def test_sensor_knows_the_truth_of_its_motion():
    parts = Configuration(
        {
            **IDEAL,
            'driver.sample_rate': 100.0,
            'driver.motion': 'vehicle',
            'driver.simulated.attitude': (0.0, 0.0, 0.5),
        }
    )
    sensor, source = Sensor(parts), simulated_sensor(parts, 0)
    many = [sensor.measure(0.0) for _ in range(900)]
    dt = 0.01
    yaw = np.unwrap([yaw_from_quaternion(m.orientation) for m in many])
    rate = np.array([m.rate for m in many])
    assert np.abs(np.gradient(yaw, dt)[1:-1] - rate[1:-1, 2]).max() < 0.02
    assert np.ptp(yaw) > 0.9
    place = np.array([m.position for m in many])
    assert place[-1] == pytest.approx(source.truth(8_990_000_000).position)
    assert np.ptp(place, axis=0)[:2].min() > 0.1
    assert many[0].values['m/s2'] == pytest.approx((0.0, 0.0, GRAVITY), abs=1e-9)


def test_a_gyroscope_takes_the_place_of_the_true_rate():
    bias = (0.1, -0.2, 0.3)
    with_gyro = configuration(gyro__enabled=True, gyro__bias=bias, motion='rest')
    assert Sensor(with_gyro).measure(0.0).rate == pytest.approx(bias, abs=0.02)
    assert Sensor(configuration(motion='rest')).measure(0.0).rate == (0.0, 0.0, 0.0)


def test_measurements_go_over_the_line_at_their_times():
    made = emulator(serial__baud=19_200)
    assert made.next == 0.0
    lines = made.advance(0.0)
    assert lines == b''
    assert made.next == pytest.approx(10.0 / 19_200.0)
    lines += made.advance(0.1999)
    assert made.measured == 20
    lines += made.advance(0.2199)
    values = [tuple(map(float, line.split(b','))) for line in lines.split()[:20]]
    sensor = Sensor(configuration())
    assert values == [sensor.measure(0.0).values['counts'] for _ in range(20)]


def test_a_line_that_is_too_slow_carries_what_it_can_and_whole_lines_only():
    made = emulator(serial__baud=1200)
    got = b''.join(made.advance(0.05 * k) for k in range(101))
    assert made.measured == 501
    assert made.unsent + got.count(b'\n') == pytest.approx(made.measured, abs=6)
    assert len(got) == pytest.approx(5.0 * 120.0, abs=5)
    assert all(line.count(b',') == 2 for line in got.splitlines()[:-1])


def test_a_board_that_was_off_begins_anew_while_its_sensor_moved_on(monkeypatch):
    times = []

    def note(self, measurement):
        times.append(measurement.time)
        return b'x' * 10

    monkeypatch.setattr(AsciiBoard, 'measure', note)
    made = emulator()
    made.advance(0.095)
    made.switch_off()
    assert made.advance(0.195) == b''
    made.switch_on(0.195)
    made.advance(0.225)
    assert made.measured == 13
    assert times[:10] == pytest.approx([0.01 * k for k in range(10)])
    assert times[10:] == pytest.approx([0.005, 0.015, 0.025])


def test_what_is_heard_is_answered_over_the_line_and_not_for_ever(monkeypatch):
    monkeypatch.setattr(AsciiBoard, 'hear', lambda self, data: data.upper())
    monkeypatch.setattr(AsciiBoard, 'measure', lambda self, measurement: b'')
    made = emulator()
    made.hear(b'abc', 1.0)
    assert made.advance(2.0) == b'ABC'
    for _ in range(10_000):
        made.hear(b'a' * 100, 2.0)
    assert len(made.advance(100.0)) < 5000
    made.switch_off()
    made.hear(b'abc', 101.0)
    assert made.advance(102.0) == b''


def test_faults_are_on_the_line():
    made = emulator(Faults(drop=0.5))
    got = made.advance(1.0)
    assert 0 < len(got) < 900
    assert got == emulator(Faults(drop=0.5)).advance(1.0)
    assert got != emulator(Faults(drop=0.5), simulated__seed=2).advance(1.0)


def test_what_the_driver_could_not_read_is_refused():
    with pytest.raises(SettingsError, match=r'driver\.serial\.ascii\.unit'):
        emulator(serial__ascii__unit='volts', sensor='adxl345')


@pytest.mark.parametrize('flip', [0.0, 0.0005])
@pytest.mark.parametrize(
    'board',
    [
        {'serial__protocol': 'hex', 'adc_bits': 10},
        {'serial__protocol': 'imu6dof4', 'adc_bits': 10},
        {'serial__protocol': 'um7', 'sensor': 'um7'},
        {'serial__protocol': 'witilt3', 'adc_bits': 10},
    ],
)
def test_boards_with_a_clock_are_stamped_when_they_measured(board, flip):
    """Handed over every 16 ms, bits turned: what is left is a steady part of a frame's time."""
    made = emulator(Faults(flip=flip), motion='rest', **board)
    receiver = serial_receiver(configuration(**board))
    receiver.restart()
    start_ns, told, stamps = 1_700_000_000 * NANOSECONDS, -math.inf, []
    for time in np.arange(1, 1250) * 0.016:
        taken = receiver.take(made.advance(time), start_ns + round(time * NANOSECONDS))
        stamps += taken.conversions.stamps_ns.tolist()
        say = receiver.due(time - told)
        if say:
            made.hear(say, time)
            told = time
    late = (np.array(stamps) - start_ns) % (NANOSECONDS // 100) / NANOSECONDS
    after = late[500:]
    assert len(after) > 1000
    assert np.quantile(np.abs(after - np.median(after)), 0.98) < 1e-5
    assert 0.0 <= np.median(after) < 0.003
