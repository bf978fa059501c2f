"""Laws that every model of step lengths keeps, and the equations of each."""

import math
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core import step_lengths
from dead_reckoning.core.step_detectors import Step

NAMES = step_lengths.names()
HEIGHT = 1.7
FORCES = st.lists(st.floats(0.0, 200.0), min_size=1, max_size=60)


def step(samples, rate=30.0):
    samples = tuple(float(sample) for sample in samples)
    return Step(10**18, len(samples) / rate, samples, 1.0 / rate)


def size_of(name, step, height=HEIGHT):
    return step_lengths.model(name).size(step, height)


def bounce(height, cadence, rate=30.0, phase=0.0, firmness=0.3):
    """Return a step in which the hip goes up and down by ``height`` [m] peak to peak."""
    time = (np.arange(round(rate / cadence)) + 0.5) / rate
    turn = 2.0 * np.pi * cadence * time + phase
    square = (2.0 * np.pi * cadence) ** 2
    return step(9.8 + 0.5 * height * square * (np.sin(turn) - firmness * np.cos(2.0 * turn)), rate)


@pytest.mark.parametrize('name', NAMES)
def test_constant_and_unit_are_there(name):
    model = step_lengths.model(name)
    assert 0.1 < model.K < 10.0
    assert model.UNIT in ('m', '√m', '√s', 'm^¾ s^½', 'm^⅔ s^⅔')


@pytest.mark.parametrize('name', NAMES)
def test_equation_and_source_are_in_the_docstring(name):
    assert ' k' in type(step_lengths.model(name)).__doc__


@pytest.mark.parametrize('name', NAMES)
@given(samples=FORCES)
def test_length_is_finite_and_not_negative(name, samples):
    size = size_of(name, step(samples))
    assert math.isfinite(size)
    assert size >= 0.0


@pytest.mark.parametrize('name', NAMES)
def test_step_without_samples_or_without_motion_has_a_length(name):
    for samples in ((), (9.8,), (9.8,) * 15):
        still = Step(10**18, 0.5, samples, 1.0 / 30.0)
        assert 0.0 <= step_lengths.model(name).K * size_of(name, still) <= 1.0
    assert size_of(name, Step(10**18, 0.0, (), 0.0)) <= 1.0


@pytest.mark.parametrize('name', NAMES)
def test_what_is_usual_gives_a_usual_length(name):
    assert 0.4 < step_lengths.model(name).K * size_of(name, bounce(0.04, 1.8)) < 1.1


@pytest.mark.parametrize('name', NAMES)
@pytest.mark.parametrize('rate', [50.0, 100.0])
def test_rate_of_the_samples_does_not_matter(name, rate):
    usual = size_of(name, bounce(0.04, 1.8, rate=400.0))
    assert size_of(name, bounce(0.04, 1.8, rate=rate)) == pytest.approx(usual, rel=0.03)


def test_constant_is_k():
    assert size_of('constant', step([1.0, 2.0])) == 1.0


def test_equation_1():
    """d = k (avg − min) / (max − min)."""
    assert size_of('an900_equation1', step([1.0, 2.0, 6.0])) == pytest.approx(
        (3.0 - 1.0) / (6.0 - 1.0)
    )


@given(FORCES, st.floats(0.01, 100.0), st.floats(-50.0, 50.0))
def test_equation_1_knows_no_amplitude(samples, scale, offset):
    if max(samples) - min(samples) > 1e-3:
        other = step([scale * s + offset for s in samples])
        size = size_of('an900_equation1', step(samples))
        assert size_of('an900_equation1', other) == pytest.approx(size, abs=1e-6)


def test_equation_2():
    """d = k √((max − min)/(avg − min) · |ΣΣ(f − avg)|), the sum from where it is largest."""
    samples = [3.0, 1.0, 2.0, 6.0, 8.0, 4.0]
    mean, low, high = np.mean(samples), min(samples), max(samples)
    turned = [samples[k:] + samples[:k] for k in range(6)]
    sums = [abs(np.cumsum(np.subtract(way, mean)).sum()) for way in turned]
    expected = math.sqrt((high - low) / (mean - low) * max(sums)) / 30.0
    size = partial(size_of, 'an900_equation2')
    assert size(step(samples)) == pytest.approx(expected)
    for way in turned:
        assert size(step(way)) == pytest.approx(expected)


def test_equation_2_follows_the_bounce_at_any_pace():
    size = partial(size_of, 'an900_equation2')
    slow = size(bounce(0.04, 1.0))
    for cadence in (1.5, 2.0, 2.5):
        assert size(bounce(0.04, cadence)) == pytest.approx(slow, rel=0.05)
    assert size(bounce(0.08, 1.0)) == pytest.approx(math.sqrt(2.0) * slow)


def test_equation_2_forgives_where_the_step_was_cut():
    size = partial(size_of, 'an900_equation2')
    sizes = [size(bounce(0.04, 1.5, phase=phase)) for phase in np.linspace(0.0, 6.0, 25)]
    assert max(sizes) == pytest.approx(min(sizes), rel=0.05)


def test_weinberg():
    """d = k ⁴√(max − min)."""
    assert size_of('weinberg', step([3.0, 19.0, 10.0])) == pytest.approx(2.0)


def test_kim():
    """d = k ∛(mean |f − avg|)."""
    assert size_of('kim', step([2.0, 18.0, 2.0, 18.0])) == pytest.approx(2.0)


@pytest.mark.parametrize(('name', 'power'), [('weinberg', 4), ('kim', 3)])
def test_roots_know_no_gravity_and_grow_slowly(name, power):
    samples = [3.0, 1.0, 2.0, 6.0, 8.0, 4.0]
    size = size_of(name, step(samples))
    assert size_of(name, step([s + 9.8 for s in samples])) == pytest.approx(size)
    assert size_of(name, step([2.0**power * s for s in samples])) == pytest.approx(2.0 * size)


def test_cadence_and_height():
    """d = k h √(1/T)."""
    quick = Step(10**18, 0.25, (9.8, 10.0), 0.125)
    assert size_of('cadence_height', quick, 1.8) == pytest.approx(3.6)


@pytest.mark.parametrize('name', [name for name in NAMES if name != 'cadence_height'])
def test_height_matters_to_one_alone(name):
    walked = bounce(0.04, 1.8)
    assert size_of(name, walked, 1.5) == size_of(name, walked, 1.9)
