"""A board on a serial port, over DDS: what it measures goes out, whatever happens to the port."""

import fcntl
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from itertools import pairwise

import numpy as np
import pytest
from messages import NANOSECONDS, clock_message
from nav_msgs.msg import Odometry
from ros_harness import EXECUTORS, NodeProcess, figures
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu

from dead_reckoning.core.rest import GRAVITY

LEVEL = b'2048,2048,3041\r\n'
"""A level MMA7260QT at ±1.5 g, 12 bits."""

OK, WARN, ERROR = b'\0', b'\1', b'\2'
DRIVER = 'accelerometer_driver'
EMULATE = [sys.executable, '-m', 'dead_reckoning.tools.main', 'emulate']


class Wire:
    """Lines that a board sends while it is plugged in and the test's node spins."""

    def __init__(self, ros, board, line=LEVEL, rate=100.0):
        self.line = line
        self._board = board
        ros.node.create_timer(1.0 / rate, self._send)

    def _send(self):
        if self._board.plugged and self.line:
            with suppress(BlockingIOError):  # nobody reads
                self._board.send(self.line)


def parameters(board, **more):
    values = {f'driver.{key.replace("__", ".")}': value for key, value in more.items()}
    return {'driver.source': 'serial', 'driver.serial.port': str(board.port), **values}


def forces(messages):
    return np.array(
        [[getattr(message.linear_acceleration, axis) for axis in 'xyz'] for message in messages]
    )


def processor_time(node):
    """Return the processor time [s] that a node has used."""
    with open(f'/proc/{node.process.pid}/stat') as file:
        fields = file.read().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def state(ros, name, level, node=DRIVER):
    """Wait until /diagnostics shows a state of the port, and return what it says."""
    return ros.diagnostics().until(
        node, lambda s: figures(s).get('port_state') == name and s.level == level, name
    )


@pytest.mark.parametrize('executor', EXECUTORS)
def test_readings_go_out_as_specific_force_with_the_time_they_came(ros, board, executor):
    board.plug()
    node = ros.start(DRIVER, {**parameters(board), 'common.executor': executor})
    raw = ros.record('imu/data_raw', Imu).connected()
    Wire(ros, board)
    begun = time.time_ns()
    messages = raw.wait(50)
    assert forces(messages) == pytest.approx(
        np.tile([0.0, 0.0, GRAVITY], (len(messages), 1)), abs=0.01
    )
    for message in messages:
        assert message.header.frame_id == 'imu_link'
        assert message.orientation_covariance[0] == -1.0
        assert message.angular_velocity_covariance[0] == -1.0
        assert 0.0 < message.linear_acceleration_covariance[0] < 1.0
    stamps = raw.stamps
    assert all(b > a for a, b in pairwise(stamps))
    assert abs(stamps[0] - begun) < 5e9
    shown = figures(state(ros, 'reading', OK))
    assert shown['port'] == str(board.port)
    assert shown['reconnections'] == '0'
    assert int(shown['readings']) >= 50
    assert node.stderr.count('readings come') == 1
    assert 'ground_truth/odom' not in dict(ros.node.get_topic_names_and_types())


def test_an_unplugged_board_is_said_once_and_read_on_when_it_is_back(ros, board):
    board.plug()
    node = ros.start(DRIVER, parameters(board))
    raw = ros.record('imu/data_raw', Imu)
    Wire(ros, board)
    raw.wait(10)
    for time_ in (1, 2):
        board.unplug()
        said = state(ros, 'LostPortError', ERROR)
        assert str(board.port) in said.message
        assert 'plug the board in' in said.message
        ros.for_seconds(1.5)  # some tries in vain
        board.plug()
        raw.wait(len(raw) + 10)
        shown = figures(state(ros, 'reading', OK))
        assert int(shown['LostPortError']) == time_
        assert node.stderr.count('the port is gone') == time_
        assert node.stderr.count(f'{board.port}: LostPortError is over') == time_
    ros.diagnostics().until(DRIVER, lambda s: figures(s)['reconnections'] == '2', 'two returns')
    assert all(b > a for a, b in pairwise(raw.stamps))
    assert 'Traceback' not in node.stderr


def test_a_missing_port_is_one_line_and_no_work_and_ctrl_c_ends_at_once(ros, board):
    node = ros.start(DRIVER, parameters(board))
    state(ros, 'MissingPortError', ERROR)
    used, begun = processor_time(node), time.monotonic()
    ros.for_seconds(3.0)
    assert processor_time(node) - used < 0.5 * (time.monotonic() - begun)
    (line,) = node.stderr.splitlines()
    assert str(board.port) in line
    assert '[ERROR]' in line
    begun = time.monotonic()
    assert node.end(signal.SIGINT, signal.SIGINT) == 0
    assert time.monotonic() - begun < 3.0
    assert node.stderr.splitlines() == [line]


def test_a_port_of_another_program_is_read_when_that_ends(ros, board):
    board.plug()
    with board.port.open('rb', buffering=0) as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        ros.start(DRIVER, parameters(board))
        assert 'another program has it' in state(ros, 'BusyPortError', ERROR).message
    Wire(ros, board)
    state(ros, 'reading', OK)


def test_garbage_is_counted_by_cause_and_costs_nothing_but_itself(ros, board):
    board.plug()
    node = ros.start(DRIVER, parameters(board))
    raw = ros.record('imu/data_raw', Imu)
    wire = Wire(ros, board)
    raw.wait(10)
    wire.line = (
        b'\xff\xfe\x80\n2048,2048\n2048,,3041\nboard v1.0\n9999,0,0\n' + b'5' * 600 + b'\n' + LEVEL
    )
    before, count = time.monotonic(), len(raw)
    raw.wait(count + 100)
    assert time.monotonic() - before < 10.0
    wire.line = LEVEL
    raw.wait_next()
    assert forces(raw.messages)[:, 2] == pytest.approx(np.full(len(raw), GRAVITY), abs=0.01)
    causes = {'GarbledError', 'ColumnError', 'NumberError', 'OutOfRangeError', 'OverlongError'}

    def counted(status):
        shown = figures(status)
        return all(int(shown.get(cause, 0)) > 50 for cause in causes)

    assert ros.diagnostics().until(DRIVER, counted, 'all causes').level in (OK, WARN)
    warnings = [line for line in node.stderr.splitlines() if '[WARN]' in line]
    assert len(warnings) == len(causes)
    state(ros, 'reading', OK)


def test_nothing_but_garbage_is_a_port_without_readings(ros, board):
    board.plug()
    node = ros.start(DRIVER, parameters(board))
    wire = Wire(ros, board, b'\x8e\xff\x00\xf8' * 12)
    said = state(ros, 'SilentPortError', ERROR)
    assert 'driver.serial.baud' in said.message
    wire.line = LEVEL
    state(ros, 'reading', OK)
    assert node.stderr.count('no reading has come') == 1
    assert node.stderr.count('SilentPortError is over') == 1


def test_a_board_that_falls_silent_is_said_and_comes_back(ros, board):
    board.plug()
    node = ros.start(DRIVER, parameters(board))
    wire = Wire(ros, board)
    state(ros, 'reading', OK)
    wire.line = b''
    said = state(ros, 'SilentPortError', ERROR)
    assert 'is the board on' in said.message
    wire.line = LEVEL
    state(ros, 'reading', OK)
    assert node.stderr.count('readings come') == 2


def test_calibration_works_on_a_board(ros, board):
    board.plug()
    ros.start(DRIVER, parameters(board, calibration_samples=64))
    raw = ros.record('imu/data_raw', Imu)
    wire = Wire(ros, board, b'2078,2018,3061\n', rate=200.0)
    raw.wait(10)
    assert abs(forces(raw.messages)[-1, 0]) > 0.2
    answer = ros.trigger(f'{DRIVER}/calibrate')
    assert answer.success, answer.message
    count = len(raw)
    raw.wait(count + 10)
    assert forces(raw.messages)[-1] == pytest.approx([0.0, 0.0, GRAVITY], abs=0.02)
    wire.line = b'2048,2048,2048\n'
    raw.wait(len(raw) + 10)
    refused = ros.trigger(f'{DRIVER}/calibrate')
    assert not refused.success
    assert 'level' in refused.message


def test_volts_in_other_columns_are_averaged(ros, board):
    board.plug()
    ros.start(
        DRIVER,
        parameters(
            board,
            serial__ascii__columns='-zyx',
            serial__ascii__separator=' ',
            serial__ascii__unit='volts',
            samples_per_message=4,
        ),
    )
    raw = ros.record('imu/data_raw', Imu)
    Wire(ros, board, b'17.5  2.45 1.65\t0.85\n' * 2 + b'17.6 2.45 1.65 0.85\n' * 2)
    raw.wait(10)
    assert forces(raw.messages)[-1] == pytest.approx([-GRAVITY, 0.0, GRAVITY], abs=0.01)


def test_the_pipeline_reads_the_board_itself(ros, board):
    board.plug()
    ros.start(
        'pipeline',
        {'pipeline.source': 'serial', 'driver.serial.port': str(board.port)},
    )
    odometry = ros.record('odom', Odometry)
    Wire(ros, board)
    messages = odometry.wait(20)
    assert abs(messages[-1].pose.pose.position.x) < 0.01
    state(ros, 'reading', OK, node='pipeline')
    assert ros.get('pipeline', 'driver.source', 'driver.samples_per_message') == ['serial', 1]


def test_under_simulated_time_readings_wait_for_a_clock_and_take_its_time(ros, board):
    board.plug()
    ros.start(DRIVER, {**parameters(board), 'use_sim_time': True})
    raw = ros.record('imu/data_raw', Imu)
    Wire(ros, board)
    said = ros.diagnostics().until(
        DRIVER, lambda s: 'ZeroStampError' in figures(s) and s.level == WARN, 'no clock'
    )
    assert '/clock' in said.message
    assert not raw.messages
    clock = ros.publisher('/clock', Clock)
    now = clock_message(1000 * NANOSECONDS)
    ros.node.create_timer(0.05, lambda: clock.publish(now))
    raw.wait(20)  # the clock stands, and stamps rise all the same
    assert all(b > a for a, b in pairwise(raw.stamps))
    assert 999.9e9 < raw.stamps[0] < raw.latest_stamp < 1000.1e9
    state(ros, 'reading', OK)


@pytest.mark.parametrize(
    ('settings', 'named'),
    [
        ({'serial__port': ''}, 'driver.serial.port'),
        ({'serial__baud': 0}, 'driver.serial.baud: 0 is not allowed'),
        ({'serial__protocol': 'morse'}, "'morse'"),
        ({'serial__ascii__columns': 'abc'}, 'driver.serial.ascii.columns'),
        ({'serial__ascii__unit': 'volts', 'sensor': 'adxl345'}, 'adxl345'),
    ],
)
def test_wrong_settings_stop_the_node_with_one_line(domain_id, tmp_path, board, settings, named):
    node = NodeProcess(DRIVER, domain_id, tmp_path / 'node', parameters(board, **settings))
    assert node.wait() == 2
    (line,) = node.stderr.splitlines()
    assert named in line


def test_a_flood_of_garbage_leaves_time_for_a_clean_end(ros, board):
    """At the wrong speed a board of 115,200 baud brings 11,520 bytes a second of anything."""
    board.plug()
    node = ros.start(DRIVER, parameters(board))
    Wire(ros, board, b'\xfe\n\x00,\r' * 23, rate=100.0)
    state(ros, 'SilentPortError', ERROR)
    used, begun = processor_time(node), time.monotonic()
    ros.for_seconds(3.0)
    assert processor_time(node) - used < 0.7 * (time.monotonic() - begun)
    assert len(node.stderr.splitlines()) < 10
    begun = time.monotonic()
    assert node.end(signal.SIGINT) == 0
    assert time.monotonic() - begun < 3.0


def test_the_emulated_board_is_read_through_hang_up_and_return(ros, tmp_path):
    """The whole way without hardware: a line with faults, pulled out and put back every 3 s."""
    link = tmp_path / 'board'
    arguments = '--protocol hex --motion rest --rate 200 --faults drop:1e-4,flip:1e-4,hangup:3'
    emulator = subprocess.Popen(
        [*EMULATE, '--link', str(link), *arguments.split()],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        port = emulator.stdout.readline().strip()
        node = ros.start(
            DRIVER,
            {
                'driver.source': 'serial',
                'driver.serial.port': port,
                'driver.serial.protocol': 'hex',
                'driver.adc_bits': 10,
            },
        )
        raw = ros.record('imu/data_raw', Imu)
        ros.diagnostics().until(
            DRIVER, lambda s: int(figures(s).get('reconnections', 0)) >= 2, 'two returns'
        )
        raw.wait(len(raw) + 100)
    finally:
        emulator.terminate()
        assert emulator.wait(timeout=10) == 143
    force = np.median(forces(raw.messages), axis=0)
    assert force == pytest.approx([0.3, -0.2, GRAVITY + 0.4], abs=0.1)  # its offsets
    assert all(b > a for a, b in pairwise(raw.stamps))
    assert node.stderr.count('the port is gone') >= 2
    assert 'Traceback' not in node.stderr
