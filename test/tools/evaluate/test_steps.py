"""Step times beside the true ones."""

import numpy as np
import pytest

from dead_reckoning.tools.evaluate.steps import timing


def walk(count=40, period=0.55, seed=1):
    jitter = np.random.default_rng(seed).uniform(-0.05, 0.05, count)
    return np.rint(1e9 * (1_700_000_000 + period * np.arange(count) + jitter)).astype(np.int64)


def test_constant_lag_costs_nothing_and_is_told():
    truth = walk()
    found = timing(truth, truth + 230_000_000)
    assert found['f1'] == 1.0
    assert found['lag_s'] == pytest.approx(0.23)


def test_missing_and_extra_steps_count():
    truth = walk()
    made = np.sort(np.append(np.delete(truth, [5, 17]), truth[30] + 250_000_000))
    found = timing(truth, made)
    assert found['matched'] == 38
    assert found['recall'] == pytest.approx(38 / 40)
    assert found['precision'] == pytest.approx(38 / 39)
    assert found['f1'] == pytest.approx(2 * 38 / 79)


def test_each_step_is_matched_once():
    truth = walk()
    doubled = np.sort(np.concatenate([truth, truth + 30_000_000]))
    assert timing(truth, doubled)['matched'] == 40
    assert timing(doubled, truth)['matched'] == 40


def test_no_lag_helps_steps_at_another_cadence():
    truth = walk(200)
    assert timing(truth, walk(200, period=0.45))['f1'] < 0.6


def test_nothing_walked_and_nothing_counted():
    nothing = np.zeros(0, np.int64)
    assert timing(nothing, nothing)['f1'] is None
    assert timing(walk(), nothing)['f1'] == 0.0
    assert timing(walk(), nothing)['precision'] is None
