"""What robot_localization is given: a page that parses, and a twist as uncertain as it says."""

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from dead_reckoning.configuration import Configuration, read_values
from dead_reckoning.core import stages
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.pipeline import Pipeline, PipelineSettings
from dead_reckoning.core.rotation import matrix_from_quaternion
from dead_reckoning.core.stages import ODOMETRY, RAW
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings

ROOT = Path(__file__).parents[1]
PRESET = ROOT / 'config' / 'robot_localization.yaml'
START_NS = 1_700_000_000_000_000_000
POSE, TWIST, ACCELERATION = slice(0, 6), slice(6, 12), slice(12, 15)
ROLL_AND_PITCH = [False, False, False, True, True, False] + [False] * 9


@pytest.fixture(scope='module')
def filter_settings():
    """The parameters that the page gives ekf_node."""
    page = (ROOT / 'docs' / 'robot_localization.md').read_text(encoding='utf-8')
    (block,) = re.findall(r'```yaml\n(.*?)```', page, re.DOTALL)
    return yaml.safe_load(block)['ekf_filter_node']['ros__parameters']


def test_filter_takes_the_twist_and_nothing_else_of_odom(filter_settings):
    chosen = filter_settings['odom0_config']
    assert len(chosen) == 15
    assert chosen[TWIST] == [True] * 6
    assert not any(chosen[POSE] + chosen[ACCELERATION])


def test_filter_takes_from_the_imu_what_the_twist_does_not_hold(filter_settings):
    assert filter_settings['imu0_config'] == ROLL_AND_PITCH


def test_topics_and_frames_are_those_of_the_preset(filter_settings):
    assert filter_settings['odom0'] == stages.ODOMETRY
    assert filter_settings['imu0'] == stages.IMU
    frames = Configuration.load(PRESET)[FrameSettings]
    assert filter_settings['world_frame'] == filter_settings['odom_frame'] == frames.world
    assert filter_settings['base_link_frame'] == frames.body


def test_the_filter_is_the_one_that_broadcasts(filter_settings):
    assert filter_settings['publish_tf'] is True
    assert read_values(PRESET)['frames.publish_tf'] is False


def test_values_have_the_types_that_the_filter_declares(filter_settings):
    for key, value in filter_settings.items():
        if key.endswith('_config'):
            assert all(type(each) is bool for each in value)
        elif key == 'frequency':
            assert type(value) is float
        elif key.endswith('_queue_size'):
            assert type(value) is int
        else:
            assert type(value) in (bool, str)


def test_preset_runs_the_integrator_alone_on_a_topic():
    settings = Configuration.load(PRESET)[PipelineSettings]
    assert settings.source == 'topic'
    assert settings.estimators == ('integrator',)


# The covariance of the twist ------------------------------------------------------------------

DRIVE = {
    'driver.motion': 'vehicle',
    'driver.range_g': 2.0,
    'driver.gyro.enabled': True,
    'driver.vehicle.loops': 1,
}


def drive(seed):
    """Return error and deviation of the twist in the body, shapes (n, 6), over a drive."""
    random = np.random.default_rng(seed)
    configuration = Configuration(
        {
            **read_values(PRESET),
            **DRIVE,
            'driver.simulated.seed': seed,
            'driver.simulated.offset': random.uniform(-0.3, 0.3, 3).tolist(),
            'driver.gyro.bias': random.normal(0.0, 0.01, 3).tolist(),
            'frames.mounting_translation': [0.2, 0.0, 0.3],
        }
    )
    source = simulated_sensor(configuration, START_NS)
    chain = Pipeline(configuration).chain
    conversions = source.read(round(12.0 * configuration[DriverSettings].sample_rate))
    errors, deviations = [], []
    lever = np.array([0.2, 0.0, 0.3])
    for sample in front_end(configuration).add(conversions):
        truth = source.truth(sample.stamp_ns)
        for name, state in chain.push(RAW, sample):
            if name != ODOMETRY:
                continue
            rot_wb = np.reshape(matrix_from_quaternion(state.attitude), (3, 3))
            rot_true = np.reshape(matrix_from_quaternion(truth.attitude), (3, 3))
            true_v = rot_true.T @ truth.velocity - np.cross(truth.angular_velocity, lever)
            errors.append(
                [
                    *(rot_wb.T @ state.velocity - true_v),
                    *np.subtract(state.angular_velocity, truth.angular_velocity),
                ]
            )
            linear = rot_wb.T @ np.reshape(state.velocity_covariance, (3, 3)) @ rot_wb
            deviations.append(
                np.sqrt([*linear.diagonal(), *state.angular_velocity_covariance[::4]])
            )
    return np.array(errors), np.array(deviations)


def test_twist_is_as_uncertain_as_it_says_and_never_certain():
    drives = [drive(seed) for seed in range(8)]
    for errors, deviations in drives:
        assert len(errors) > 1000
        assert (deviations > 1e-6).all()
        assert np.isfinite(errors).all()
    ratios = np.concatenate([errors / deviations for errors, deviations in drives])
    rms = np.sqrt(np.mean(ratios**2, axis=0))
    assert (rms < 1.2).all()
    assert (rms > 0.3).all()
