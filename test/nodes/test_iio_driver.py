"""An accelerometer of the kernel, over DDS, on a tree of files: read, unplugged, read on."""

import signal
from itertools import pairwise

import numpy as np
import pytest
from iio_tree import GRAVITY, Board, IioTree
from nav_msgs.msg import Odometry
from ros_harness import NodeProcess, figures
from sensor_msgs.msg import Imu

OK, ERROR = b'\0', b'\2'
DRIVER = 'accelerometer_driver'


def parameters(tree, **more):
    return {
        'driver.source': 'iio',
        'driver.sensor': 'adxl345',
        'driver.range_g': 16.0,
        'driver.iio.root': str(tree.root),
        **more,
    }


@pytest.fixture
def tree(tmp_path):
    """Give a tree with no device in it yet."""
    tree = IioTree(tmp_path / 'tree')
    yield tree
    tree.unplug()


def state(ros, name, level, node=DRIVER):
    return ros.diagnostics().until(
        node, lambda s: figures(s).get('device_state') == name and s.level == level, name
    )


def test_it_is_read_lost_and_read_on_and_left_as_it_was(ros, tree):
    node = ros.start(DRIVER, parameters(tree))
    assert "no device 'adxl345', but none" in state(ros, 'MissingDeviceError', ERROR).message
    raw = ros.record('imu/data_raw', Imu)
    with Board(tree):
        tree.plug()
        for message in raw.wait(20):
            force = message.linear_acceleration
            assert [force.x, force.y, force.z] == pytest.approx(
                [0.0, -0.5 * GRAVITY, GRAVITY], abs=1e-3
            )
        assert figures(state(ros, 'reading', OK))['reconnections'] == '0'
        tree.unplug()
        state(ros, 'MissingDeviceError', ERROR)
        tree.plug()
        raw.wait(len(raw) + 10)
        assert figures(state(ros, 'reading', OK))['reconnections'] == '1'
        assert all(b > a for a, b in pairwise(raw.stamps))
        assert np.median(np.diff(raw.stamps)) == pytest.approx(10e6, rel=0.3)
        assert tree.enabled
        assert node.end(signal.SIGINT) == 0
    assert not tree.enabled
    assert 'Traceback' not in node.stderr


def test_the_pipeline_reads_it_itself_and_says_once_how_it_does(ros, tmp_path):
    tree = IioTree(tmp_path / 'tree', buffer=False).plug(in_accel_y_raw='0')
    node = ros.start('pipeline', {**parameters(tree), 'pipeline.source': 'iio'})
    odometry = ros.record('odom', Odometry).wait(20)
    assert abs(odometry[-1].pose.pose.position.x) < 0.01
    state(ros, 'reading', OK, node='pipeline')
    assert node.stderr.count('not one sample') == 1


def test_a_range_it_does_not_have_is_said_and_nothing_goes_out(ros, tree):
    tree.plug()
    ros.start(DRIVER, parameters(tree, **{'driver.range_g': 2.0}))
    raw = ros.record('imu/data_raw', Imu)
    assert 'driver.range_g' in state(ros, 'RefusedSettingError', ERROR).message
    assert not raw.messages


def test_a_bus_that_is_not_there_is_said(ros):
    pytest.importorskip('smbus2')
    ros.start(DRIVER, {'driver.source': 'i2c', 'driver.sensor': 'adxl345', 'driver.i2c.bus': 250})
    assert '/dev/i2c-250' in state(ros, 'MissingDeviceError', ERROR).message


def test_i2c_reads_no_other_sensor(domain_id, tmp_path):
    pytest.importorskip('smbus2')
    node = NodeProcess(DRIVER, domain_id, tmp_path / 'node', {'driver.source': 'i2c'})
    assert node.wait() == 2
    (line,) = node.stderr.splitlines()
    assert 'set it to adxl345' in line
