"""Boards that are told what to do, that measure their attitude, or that send positions."""

import os
import signal
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

import pytest
from nav_msgs.msg import Odometry
from ros_harness import NodeProcess, figures
from sensor_msgs.msg import Imu

from dead_reckoning.core.rest import GRAVITY

LEVEL = b'2048,2048,3041\r\n'
DRIVER = 'accelerometer_driver'


@pytest.fixture(autouse=True)
def _fake_protocols(monkeypatch):
    """Let nodes find the protocols of this test beside those of the package."""
    folder = str(Path(__file__).parent / 'fake_protocols')
    monkeypatch.setenv('PYTHONPATH', os.pathsep.join([folder, os.environ.get('PYTHONPATH', '')]))


class Line:
    """The board's end of the wire: every 10 ms it hears, and sends what ``answer`` makes of it."""

    def __init__(self, ros, board, answer):
        self.heard = b''
        self._board = board
        self._answer = answer
        ros.node.create_timer(0.01, self._turn)

    def _turn(self):
        if self._board.plugged:
            told = self._board.hear()
            self.heard += told
            with suppress(BlockingIOError):  # nobody reads
                self._board.send(self._answer(told))


def parameters(board, protocol, **more):
    return {
        'driver.source': 'serial',
        'driver.serial.port': str(board.port),
        'driver.serial.protocol': protocol,
        **more,
    }


def shown(ros, node=DRIVER, **wanted):
    """Wait until /diagnostics shows some figures, and return all of them."""
    return figures(
        ros.diagnostics().until(node, lambda s: wanted.items() <= figures(s).items(), f'{wanted}')
    )


def test_a_polled_board_is_set_asked_set_anew_when_it_is_back_and_told_the_end(ros, board):
    board.plug()
    node = ros.start(DRIVER, parameters(board, 'polled'))
    raw = ros.record('imu/data_raw', Imu)
    line = Line(ros, board, lambda told: LEVEL * told.count(b'?'))
    raw.wait(20)
    assert line.heard[:2] == b'S?'
    assert line.heard.count(b'S') == 1
    board.unplug()
    shown(ros, port_state='LostPortError')
    line.heard = b''
    board.plug()
    raw.wait(len(raw) + 20)
    assert line.heard[:2] == b'S?'
    assert all(b > a for a, b in pairwise(raw.stamps))
    found = shown(ros, port_state='reading', reconnections='1', bad_readings='0')
    assert int(found['duplicates']) > 20
    assert 10.0 < float(found['rate']) < 70.0
    assert 0.0 < float(found['jitter']) < 0.1
    assert node.end(signal.SIGINT) == 0
    assert (line.heard + board.hear())[-1:] == b'Q'


def test_counts_of_another_converter_stop_the_node(domain_id, tmp_path, board):
    values = parameters(board, 'polled', **{'driver.adc_bits': 10})
    node = NodeProcess(DRIVER, domain_id, tmp_path / 'node', values)
    assert node.wait() == 2
    (said,) = node.stderr.splitlines()
    assert 'driver.adc_bits' in said
    assert 'polled' in said


def test_a_board_that_measures_its_attitude_publishes_that(ros, board):
    board.plug()
    ros.start(DRIVER, parameters(board, 'levelled'))
    data = ros.record('imu/data', Imu)
    Line(ros, board, lambda told: LEVEL)
    message = data.wait(20)[-1]
    assert message.linear_acceleration.z == pytest.approx(GRAVITY, abs=0.01)
    assert (message.orientation.z, message.orientation.w) == (0.6, 0.8)
    assert message.orientation_covariance[::4] == pytest.approx([0.0025, 0.0025, 0.01])
    assert message.angular_velocity.z == 0.5
    assert message.angular_velocity_covariance[0] > 0.0
    assert not ros.node.get_publishers_info_by_topic('/imu/data_raw')


def test_the_pipeline_goes_on_from_that_attitude_or_says_what_to_set(
    ros, board, other_module_domain_id, tmp_path
):
    board.plug()
    values = {**parameters(board, 'levelled'), 'pipeline.source': 'serial'}
    ros.start('pipeline', {**values, 'gravity.attitude': 'message'})
    odometry = ros.record('odom', Odometry)
    Line(ros, board, lambda told: LEVEL)
    pose = odometry.wait(20)[-1].pose.pose
    assert (pose.orientation.z, pose.orientation.w) == pytest.approx((0.6, 0.8))
    refused = NodeProcess('pipeline', other_module_domain_id, tmp_path / 'refused', values)
    assert refused.wait() == 2
    (said,) = refused.stderr.splitlines()
    assert 'gives imu/data, and the estimators take imu/data_raw' in said
    assert "gravity.attitude to 'message'" in said


def test_positions_go_out_as_odometry_and_to_no_estimator(
    ros, board, other_module_domain_id, tmp_path
):
    board.plug()
    ros.start(DRIVER, parameters(board, 'places'))
    odometry = ros.record('an3397/odom', Odometry)
    Line(ros, board, lambda told: b'1.5,-2.25,0\n')
    message = odometry.wait(20)[-1]
    assert (message.header.frame_id, message.child_frame_id) == ('odom', 'base_link')
    assert (message.pose.pose.position.x, message.pose.pose.position.y) == (1.5, -2.25)
    assert message.pose.covariance[::7] == pytest.approx([1.0, 1.0, 1e6, 1e6, 1e6, 1e6])
    assert message.twist.covariance[::7] == pytest.approx([1e6] * 6)
    assert all(b > a for a, b in pairwise(odometry.stamps))
    shown(ros, port_state='reading')
    values = {**parameters(board, 'places'), 'pipeline.source': 'serial'}
    refused = NodeProcess('pipeline', other_module_domain_id, tmp_path / 'refused', values)
    assert refused.wait() == 2
    assert 'an3397/odom' in refused.stderr
