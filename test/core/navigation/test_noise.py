"""One default serves sensors of 1 to 10 times the noise, slow walks, runs and vehicles."""

from contextlib import suppress

import numpy as np
import pytest
from simulated_drives import VEHICLE, driven, shaken, way
from simulated_walks import GRAVITY, START_NS, blocks_of, measured, navigator, walk

from benchmarks.accuracy.sensors import GAITS, STRIDES, noise
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.errors import NotLevelledError
from dead_reckoning.core.navigation.window_detector import WindowDetector
from dead_reckoning.core.samples import ImuSample

NOISES = [0.0, 1.0, 3.0, 10.0]
DRIVE = driven()


def navigated(moved, **settings):
    """Return navigator and states for what a sensor measured."""
    found = navigator(**settings)
    blocks = blocks_of(found, moved.block())
    return found, StateBlock.join([*blocks, StateBlock.of(found.flush())])


def rests_found(true, states):
    """Return the part of the true rests that was found, and the greatest speed at a rest [m/s]."""
    stamps = START_NS + np.round(true.time * 1e9).astype(np.int64)
    speed = np.linalg.norm(true.velocity, axis=1)[np.searchsorted(stamps, states.stamp_ns)]
    return states.stationary[speed < 1e-6].mean(), speed[states.stationary].max(initial=0.0)


@pytest.mark.parametrize('times', NOISES)
@pytest.mark.parametrize('name', GAITS)
def test_strides_are_exact_with_any_noise(name, times):
    true = walk(rate=100.0, strides=STRIDES, turn=0.1, **GAITS[name])
    found, states = navigated(measured(true, 1, **noise(times)))
    assert found.strides.count == STRIDES
    end = states.position[-1] - states.position[0]
    assert np.linalg.norm(end) == pytest.approx(np.linalg.norm(true.position[-1]), rel=0.02)
    assert rests_found(true, states)[0] > 0.9


@pytest.mark.parametrize('times', NOISES)
def test_rests_of_a_vehicle_are_found_with_any_noise(times):
    _, states = navigated(shaken(DRIVE, 1, **noise(times)), **VEHICLE)
    error = np.linalg.norm(states.position - way(DRIVE, states), axis=1)
    assert error.max() < 15.0
    found, fastest = rests_found(DRIVE, states)
    assert found > 0.95
    assert fastest < 2.0


def test_without_learning_the_noise_no_rest_is_found_in_it(monkeypatch):
    monkeypatch.setattr(WindowDetector, 'learn', lambda *_: None)
    _, states = navigated(shaken(DRIVE, 1, **noise(10.0)), **VEHICLE)
    assert rests_found(DRIVE, states)[0] < 0.05


def test_levelling_learns_anew():
    """A gyro whose bias has wandered far looks like a motion until then."""
    found = navigator()
    random = np.random.default_rng(2)

    def rest(begin, bias):
        for k in range(begin, begin + 150):
            turn = random.normal((0.0, bias, 0.0), 0.001)
            imu = ImuSample(
                START_NS + k * 10_000_000, '', (0.0, 0.0, GRAVITY), angular_velocity=tuple(turn)
            )
            with suppress(NotLevelledError):
                found.update(imu)
        return found.stationary

    assert rest(0, 0.0)
    assert not rest(150, 0.1)
    found.level()
    assert rest(300, 0.1)
    assert found.threshold == pytest.approx(0.15, rel=0.02)
