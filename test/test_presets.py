"""The presets do what they are for: the chain on their own simulated sensor."""

import math
from pathlib import Path

import numpy as np
import pytest

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.compass import Compass, CompassSettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.pipeline import Pipeline, PipelineSettings
from dead_reckoning.core.rotation import yaw_from_quaternion
from dead_reckoning.core.stages import COMPASS, ODOMETRY, RAW
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings

CONFIG = Path(__file__).parents[1] / 'config'
START_NS = 1_700_000_000_000_000_000


def run(preset, seconds, compass_every=0):
    """Return states and true positions; a compass speaks with every so many-th message."""
    configuration = Configuration.load(CONFIG / f'{preset}.yaml')
    rate = configuration[DriverSettings].sample_rate
    source = simulated_sensor(configuration, START_NS)
    chain = Pipeline(configuration).chain
    settings = configuration[CompassSettings]
    compass, random = Compass(settings, 'compass_link'), np.random.default_rng(1)
    states = []
    for k, sample in enumerate(front_end(configuration).add(source.read(round(seconds * rate)))):
        if compass_every and k % compass_every == 0:
            yaw = yaw_from_quaternion(source.truth(sample.stamp_ns).attitude)
            heading = math.pi / 2.0 - yaw + random.normal(0.0, settings.noise)
            assert chain.push(COMPASS, compass.sample(sample.stamp_ns, heading)) == []
        states += [value for name, value in chain.push(RAW, sample) if name == ODOMETRY]
    truth = np.array([source.truth(state.stamp_ns).position for state in states])
    return states, truth


def off(states, truth):
    """Return the error in the plane, shape (n,) [m]."""
    positions = np.array([state.position for state in states])
    return np.linalg.norm((positions - truth)[:, :2], axis=1)


def test_mbed_follows_the_heading_of_its_compass_round_an_eight():
    """18 m in curves within the 15 s of the page: 1 % off on the way, 0.5 % at its end."""
    states, truth = run('mbed', 15.0, compass_every=5)
    way = np.linalg.norm(np.diff(truth, axis=0), axis=1).sum()
    assert way == pytest.approx(18.3, abs=0.2)
    error = off(states, truth)
    assert error.max() < 0.01 * way
    assert error[-1] < 0.005 * way
    assert states[-1].stationary
    assert 1400 < len(states) < 1500


def test_mbed_ends_when_the_page_does_and_logs():
    settings = Configuration.load(CONFIG / 'mbed.yaml')[PipelineSettings]
    assert settings.duration == 15.0
    assert settings.log_csv.endswith('.csv')


def test_an3397_comes_back_round_its_square():
    """1.2 m round a square with an 8-bit sensor and the documents' wide window: within 2 cm."""
    states, truth = run('an3397', 9.5)
    assert np.abs(truth).max() == pytest.approx(0.3)
    assert off(states, truth).max() < 0.02
    assert states[-1].stationary


def test_an3397_window_is_three_counts():
    configuration = Configuration.load(CONFIG / 'an3397.yaml')
    count = configuration[DriverSettings].model().force_per_count
    window = configuration[IntegratorSettings].window_maximum
    assert window == pytest.approx(3.0 * count[0], abs=1e-3)
    assert configuration[IntegratorSettings].window_minimum == -window
