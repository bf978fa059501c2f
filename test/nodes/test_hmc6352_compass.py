"""An HMC6352 as the kernel shows it, over DDS: headings become yaw, and it calibrates itself."""

import math
import shutil

import pytest
from ros_harness import NodeProcess, figures
from sensor_msgs.msg import Imu

OK, ERROR = b'\0', b'\2'
COMPASS = 'compass_driver'


@pytest.fixture
def folder(tmp_path):
    """Give the folder that the kernel's driver makes, with a heading of 30° in it."""
    folder = tmp_path / '1-0021' / 'hmc6352'
    plug(folder)
    return folder


def plug(folder):
    folder.mkdir(parents=True)
    (folder / 'calibration').write_text('')
    (folder / 'heading0_input').write_text('30.0\n')


def parameters(folder, **more):
    return {
        'compass.source': 'hmc6352',
        'compass.hmc6352.folder': str(folder),
        'compass.declination': math.radians(10.0),
        **more,
    }


def state(ros, name, level):
    return ros.diagnostics().until(
        COMPASS, lambda s: figures(s).get('device_state') == name and s.level == level, name
    )


def test_headings_become_yaw_and_come_again_after_a_loss(ros, folder):
    node = ros.start(COMPASS, parameters(folder))
    compass = ros.record('compass/data', Imu)
    for message in compass.wait(20):
        q = message.orientation
        assert math.degrees(2.0 * math.atan2(q.z, q.w)) == pytest.approx(50.0)
        assert message.orientation_covariance[8] < 0.01
    state(ros, 'reading', OK)
    shutil.rmtree(folder)
    assert 'new_device' in state(ros, 'MissingDeviceError', ERROR).message
    plug(folder)
    compass.wait(len(compass) + 5)
    state(ros, 'reading', OK)
    assert 'Traceback' not in node.stderr


def test_calibration_answers_when_it_is_done(ros, folder):
    ros.start(COMPASS, parameters(folder, **{'compass.calibration_time': 7.0}))
    compass = ros.record('compass/data', Imu)
    compass.wait(5)
    answer = ros.trigger(f'{COMPASS}/calibrate')
    assert answer.success, answer.message
    assert 'calibrated for 7 s' in answer.message
    assert (folder / 'calibration').read_text() == '0'
    compass.wait(len(compass) + 5)
    state(ros, 'reading', OK)


def test_a_calibration_of_a_compass_that_is_gone_fails_with_the_reason(ros, folder):
    ros.start(COMPASS, parameters(folder))
    ros.record('compass/data', Imu).wait(5)
    shutil.rmtree(folder)
    answer = ros.trigger(f'{COMPASS}/calibrate')
    assert not answer.success
    assert 'new_device' in answer.message


def test_a_calibration_longer_than_services_wait_is_refused(domain_id, tmp_path, folder):
    values = parameters(folder, **{'compass.calibration_time': 60.0})
    node = NodeProcess(COMPASS, domain_id, tmp_path / 'node', values)
    assert node.wait() == 2
    (line,) = node.stderr.splitlines()
    assert 'common.service_timeout' in line
