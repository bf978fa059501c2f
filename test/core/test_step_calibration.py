"""Constants of models fitted to walks, and what their errors are on others."""

import math

import pytest

from dead_reckoning.core import step_lengths
from dead_reckoning.core.step_calibration import AllModels, fit
from dead_reckoning.core.step_detectors import Step


def test_all_models_note_what_each_says():
    models = AllModels()
    steps = [Step(10**18 + n, 0.5, (8.0, 9.0, 9.0 + n), 1.0 / 30.0) for n in range(1, 4)]
    for step in steps:
        models.size(step, 1.8)
    assert models.names == step_lengths.names()
    assert models.stamps_ns == [step.stamp_ns for step in steps]
    for name, total in models.totals().items():
        model = step_lengths.model(name)
        assert total == pytest.approx(sum(model.size(step, 1.8) for step in steps))


def test_without_steps_all_totals_are_zero():
    assert AllModels().totals() == dict.fromkeys(step_lengths.names(), 0)


def test_k_makes_all_walks_together_as_long_as_they_were():
    found = fit([10.0, 20.0], [30.0, 30.0])
    assert found.k == pytest.approx(0.5)


def test_each_error_is_that_of_a_walk_with_the_k_of_the_others():
    found = fit([10.0, 20.0, 30.0], [10.0, 25.0, 20.0])
    expected = (
        50.0 / 45.0 - 1.0,
        40.0 / 30.0 * 25.0 / 20.0 - 1.0,
        30.0 / 35.0 * 20.0 / 30.0 - 1.0,
    )
    assert found.errors == pytest.approx(expected)
    assert found.error == pytest.approx(sum(map(abs, expected)) / 3.0)
    assert found.worst == pytest.approx(abs(expected[1]))


def test_one_walk_says_no_error():
    found = fit([10.0], [20.0])
    assert (found.k, found.errors) == (0.5, ())
    assert found.error == found.worst == math.inf
