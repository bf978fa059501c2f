"""Laws that every step detector keeps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core import step_detectors
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.step_window import StepWindow

START_NS = 1_700_000_000_000_000_000
METHODS = step_detectors.names()


def detector(method):
    kind = step_detectors.detector_class(method)
    return kind(kind.Settings(), StepWindow(0.25, 2.0))


def run(found, magnitudes, start_ns=START_NS):
    period = 1e9 / found.RATE
    return [
        step
        for k, magnitude in enumerate(magnitudes)
        for step in found.update(start_ns + round(k * period), float(magnitude))
    ]


def walk(rate, steps=40, cadence=1.8, amplitude=2.5, rest=2.0):
    """Return magnitudes of a rest, a walk of a number of steps, and another rest."""
    time = np.arange(0.0, steps / cadence, 1.0 / rate)
    turn = 2.0 * np.pi * cadence * time
    quiet = np.full(round(rest * rate), GRAVITY)
    moving = GRAVITY + amplitude * (-np.sin(turn) + 0.4 * np.sin(2.0 * turn))
    return np.concatenate([quiet, moving, quiet])


@pytest.mark.parametrize('method', METHODS)
def test_settings_carry_the_name(method):
    kind = step_detectors.detector_class(method)
    assert kind.Settings.prefix == f'pedometer.{method}'


@pytest.mark.parametrize('method', METHODS)
def test_walk_is_counted(method):
    found = detector(method)
    steps = run(found, walk(found.RATE))
    assert len(steps) == 40
    stamps = [step.stamp_ns for step in steps]
    assert stamps == sorted(stamps)
    np.testing.assert_allclose(np.diff(stamps)[2:] * 1e-9, 1.0 / 1.8, atol=0.03)


@pytest.mark.parametrize('method', METHODS)
def test_step_carries_its_samples_and_its_time(method):
    found = detector(method)
    magnitudes = walk(found.RATE)
    for step in run(found, magnitudes)[5:-5]:
        assert step.interval == pytest.approx(1.0 / found.RATE)
        assert len(step.samples) * step.interval == pytest.approx(step.duration, abs=0.04)
        assert step.duration == pytest.approx(1.0 / 1.8, abs=0.03)
        assert set(step.samples) <= set(magnitudes.tolist())


@pytest.mark.parametrize('method', METHODS)
def test_first_step_comes_with_the_second_and_is_as_long(method):
    found = detector(method)
    steps = []
    for k, magnitude in enumerate(walk(found.RATE)):
        steps = found.update(START_NS + k * 10**9 // found.RATE, float(magnitude))
        if steps:
            break
    first, second = steps[:2]
    assert first.stamp_ns < second.stamp_ns
    assert first.duration == pytest.approx(second.duration, abs=1.0 / found.RATE)


@pytest.mark.parametrize('method', METHODS)
@given(shift_ns=st.integers(1, 10**15))
def test_time_shift_shifts_the_steps(method, shift_ns):
    magnitudes = walk(step_detectors.detector_class(method).RATE, steps=6)
    steps = run(detector(method), magnitudes)
    later = run(detector(method), magnitudes, START_NS + shift_ns)
    assert [step.stamp_ns + shift_ns for step in steps] == [step.stamp_ns for step in later]
    assert [step.samples for step in steps] == [step.samples for step in later]


@pytest.mark.parametrize('method', METHODS)
@pytest.mark.parametrize('level', [0.0, GRAVITY, 50.0])
@pytest.mark.parametrize('noise', [0.0, 0.01])
def test_silence_gives_no_steps(method, level, noise):
    found = detector(method)
    random = np.random.default_rng(7)
    assert run(found, level + noise * random.standard_normal(600 * found.RATE)) == []
    assert not found.walking


@pytest.mark.parametrize('method', METHODS)
def test_walk_ends(method):
    found = detector(method)
    run(found, walk(found.RATE, rest=1.0))
    assert found.walking
    run(found, np.full(2 * found.RATE, GRAVITY), START_NS + 100 * 10**9)
    assert not found.walking


@pytest.mark.parametrize('method', METHODS)
def test_reset_forgets_all(method):
    found = detector(method)
    magnitudes = walk(found.RATE, steps=8)
    before = [step.samples for step in run(found, magnitudes[: len(magnitudes) // 2])]
    found.reset()
    assert not found.walking
    after = [step.samples for step in run(found, magnitudes)]
    assert before == after[: len(before)]
    assert len(after) == 8


@pytest.mark.parametrize('method', METHODS)
@given(seed=st.integers(0, 2**32), scale=st.sampled_from([1e-9, 1.0, 100.0, 1e12]))
def test_noise_never_breaks_it(method, seed, scale):
    found = detector(method)
    random = np.random.default_rng(seed)
    steps = run(found, np.abs(scale * random.standard_normal(300)))
    stamps = [step.stamp_ns for step in steps]
    assert stamps == sorted(set(stamps))
    assert all(step.samples and 0.25 <= step.duration <= 2.0 for step in steps)
