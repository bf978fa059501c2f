"""The bias is learnt from rests, weighted, and from nothing else."""

import math

import numpy as np
import pytest

from dead_reckoning.core.attitude.gyro_bias import GyroBias
from dead_reckoning.core.errors import CalibrationError
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest import GRAVITY, Rest
from dead_reckoning.core.samples import IDENTITY, ImuSample

STEP_NS = 10_000_000
NOISE = 0.002
LEVEL = (0.0, 0.0, GRAVITY)
STILL = (0.01, -0.02, 0.005)


class Gyro:
    """Feeds a bias with samples, one after the other."""

    def __init__(self, **settings):
        self.bias = GyroBias(GravitySettings(**settings))
        self.bias.set(Rest(STILL, (NOISE,) * 3, 50))
        self._random = np.random.default_rng(4)
        self._step = 0

    def feed(self, count, rate, force=LEVEL):
        """Feed samples; ``rate`` and ``force`` are constant or functions of the time [s]."""
        weights = []
        for k in range(count):
            self._step += 1
            time = k * STEP_NS * 1e-9
            turn = rate(time) if callable(rate) else rate
            push = force(time) if callable(force) else force
            shaken = np.add(turn, self._random.normal(0.0, NOISE, 3))
            pushed = np.add(push, self._random.normal(0.0, 0.03, 3))
            imu = ImuSample(
                self._step * STEP_NS,
                'imu_link',
                tuple(pushed.tolist()),
                angular_velocity=tuple(shaken.tolist()),
            )
            self.bias.wander(STEP_NS * 1e-9)
            weights.append(self.bias.learn(imu, IDENTITY))
        return weights


def test_bias_is_the_mean_rate_of_the_rest_it_is_set_to():
    gyro = Gyro(rate_walk=0.0)
    assert gyro.bias.value == STILL
    assert gyro.bias.variance == pytest.approx(NOISE**2 / 50)


@pytest.mark.parametrize('rate', [(0.2, 0.0, 0.0), (0.06, 0.06, 0.06)])
def test_steady_turn_is_no_bias(rate):
    with pytest.raises(CalibrationError, match=r'rad/s: hold the device still'):
        GyroBias(GravitySettings(rate_offset=0.1)).set(Rest(rate, (NOISE,) * 3, 50))


def test_rest_after_rest_brings_it_to_the_true_bias():
    gyro = Gyro()
    true = (0.012, -0.019, 0.002)
    weights = gyro.feed(5000, true)
    assert sum(weight > 0.0 for weight in weights) > 90
    assert gyro.bias.value == pytest.approx(true, abs=5e-4)
    assert gyro.bias.variance < 5e-4**2


def test_bias_that_drifts_is_followed():
    gyro = Gyro()
    gyro.feed(30_000, lambda time: (0.01 + 2e-5 * time, -0.02, 0.005))
    assert gyro.bias.value[0] == pytest.approx(0.016, abs=1e-3)


def test_variance_grows_between_rests():
    gyro = Gyro(rate_walk=1e-3)
    before = gyro.bias.variance
    gyro.bias.wander(100.0)
    assert gyro.bias.variance == pytest.approx(before + 1e-4)


def test_after_a_long_time_a_bias_far_off_is_believed():
    """Else a gyro that has warmed up would never rest again."""
    off = (0.05, -0.02, 0.005)
    gyro = Gyro()
    assert not any(gyro.feed(500, off))
    gyro.bias.wander(30_000.0)
    assert any(gyro.feed(500, off))
    assert gyro.bias.value == pytest.approx(off, abs=0.002)


NO_REST = {
    'a turn faster than rest_rate': ((0.01, -0.02, 0.025), LEVEL),
    'a turn that grows': (lambda t: (0.01, -0.02, 0.005 + 0.006 * (t - 2.0)), LEVEL),
    'a push that lasts': (STILL, (0.6, 0.0, GRAVITY)),
    'a push that grows': (STILL, lambda t: (0.1 * (t - 2.0), 0.0, GRAVITY)),
    'shaking': (STILL, lambda t: (math.sin(20.0 * t), 0.0, GRAVITY)),
    'swaying': (lambda t: (0.01, -0.02 + 0.1 * math.sin(10.0 * t), 0.005), LEVEL),
}


@pytest.mark.parametrize('name', NO_REST)
def test_what_is_no_rest_teaches_nothing(name):
    gyro = Gyro()
    assert not any(gyro.feed(400, *NO_REST[name]))
    assert gyro.bias.value == STILL


def test_first_window_after_motion_is_not_believed_yet():
    """It takes a second one that shows the same."""
    gyro = Gyro()
    gyro.feed(100, STILL, lambda t: (math.sin(20.0 * t), 0.0, GRAVITY))
    weights = gyro.feed(180, STILL)
    assert 51 < np.flatnonzero(weights)[0] <= 153
