"""AN-900's step finder: its equations, its thresholds, and none of the faults of its listing."""

import numpy as np
import pytest

from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.step_detectors.an900 import An900Detector, An900Settings
from dead_reckoning.core.step_window import StepWindow

START_NS = 1_700_000_000_000_000_000
PERIOD_NS = 1e9 / 30
COUNT = 3.0 / 4096 / 0.3 * GRAVITY
"""One count of AN-900's ADC: 3 V in 4,096 counts, 300 mV/g."""


def detector(shortest=0.25, longest=2.0, **settings):
    return An900Detector(An900Settings(**settings), StepWindow(shortest, longest))


def run(found, magnitudes, first=0):
    return [
        step
        for k, magnitude in enumerate(magnitudes, first)
        for step in found.update(START_NS + round(k * PERIOD_NS), float(magnitude))
    ]


def sine(cadence, seconds=20.0, amplitude=2.0, offset=GRAVITY):
    time = np.arange(round(30.0 * seconds)) / 30.0
    return offset + amplitude * np.sin(2.0 * np.pi * cadence * time)


def test_thresholds_are_those_of_the_listing_in_si():
    assert pytest.approx(0.00244 * GRAVITY, rel=1e-3) == COUNT
    assert An900Settings().slope_threshold == pytest.approx(5.0 * COUNT, rel=0.005)
    assert An900Settings().dead_band == pytest.approx(1.0 * COUNT, rel=0.005)


@pytest.mark.parametrize('cadence', [0.7, 1.0, 1.3, 1.8, 2.2, 2.5, 3.0])
def test_step_is_where_the_force_rises_through_its_mean(cadence):
    """The moving sum lags 3.5 samples; the stamps do not."""
    steps = run(detector(), sine(cadence))[1:]
    times = np.array([step.stamp_ns - START_NS for step in steps]) * 1e-9
    phases = times * cadence
    np.testing.assert_allclose(phases, np.round(phases), atol=0.03)
    np.testing.assert_array_equal(np.diff(np.round(phases)), 1.0)
    assert len(steps) >= 20.0 * cadence - 3


@pytest.mark.parametrize('cadence', [1.0, 1.5, 2.5])
def test_samples_of_a_step_are_those_between_its_landings(cadence):
    """Each sample belongs to one step; the mean over a step is that of the sine."""
    magnitudes = sine(cadence)
    steps = run(detector(), magnitudes)[1:]
    joined = [sample for step in steps for sample in step.samples]
    (at,) = [
        k
        for k in range(len(magnitudes))
        if magnitudes[k : k + 30].tolist() == joined[:30] and k < 90
    ][:1]
    assert magnitudes[at : at + len(joined)].tolist() == joined
    for step in steps:
        assert np.mean(step.samples) == pytest.approx(GRAVITY, abs=0.2)


def test_middle_of_the_extremes_counts_not_half_the_minimum():
    """`(maxavg+minavg/2)` of the listing lies far above, with gravity in the sum."""
    assert len(run(detector(), sine(1.5, offset=GRAVITY))) == len(
        run(detector(), sine(1.5, offset=100.0))
    )


def test_slow_drift_inside_the_dead_band_leaves_nothing_in_the_sum():
    """The listing would overwrite its running sum with each of these samples."""
    drift = np.linspace(GRAVITY, GRAVITY + 3.0, 9000)
    found = detector()
    assert run(found, drift) == []
    steps = run(found, sine(1.5, offset=GRAVITY + 3.0), first=9000)
    assert 0 <= len(steps) - len(run(detector(), sine(1.5))) <= 1


def test_standing_still_for_long_after_a_step_overruns_nothing():
    """The listing's buffer of 50 samples ends 1.4 s after a step."""
    found = detector()
    magnitudes = np.concatenate([sine(1.5, 6.0), np.full(6000, GRAVITY), sine(1.5, 6.0)])
    alone = len(run(detector(), sine(1.5, 6.0)))
    assert 0 <= len(run(found, magnitudes)) - 2 * alone <= 1


def test_jolt_hides_no_more_than_the_longest_step():
    """The listing keeps the highest maximum until the next step, which then never comes."""
    magnitudes = sine(1.5)
    magnitudes[150] = 300.0
    assert len(run(detector(), magnitudes)) >= len(run(detector(), sine(1.5))) - 5


def test_ripple_inside_a_step_is_no_step():
    time = np.arange(600) / 30.0
    ripple = GRAVITY + 2.0 * np.sin(2.0 * np.pi * time) + 0.8 * np.sin(6.0 * np.pi * time)
    assert len(run(detector(), ripple)) == len(run(detector(), sine(1.0)))


def test_window_of_time_ends_a_walk():
    slow = sine(0.45, 30.0)
    assert run(detector(), slow) == []
    assert len(run(detector(longest=3.0), slow)) > 10


def test_window_of_time_skips_what_is_too_fast():
    fast = sine(3.0)
    assert len(run(detector(shortest=0.4), fast)) < 0.6 * len(run(detector(), fast))


def test_first_step_shares_the_samples_of_the_second():
    first, second = run(detector(), sine(1.5))[:2]
    assert first.duration == second.duration
    assert first.samples == second.samples


def test_walk_begins_with_two_rises_of_like_height():
    """What stirs before the first step is none, whichever way it goes."""
    walk = np.concatenate([np.full(60, GRAVITY), GRAVITY - 2.0 * np.cos(np.arange(200) * 0.3)])
    counted = len(run(detector(), walk))
    assert counted == 10
    for stir in (-0.3, -0.1, 0.1, 0.3):
        stirred = walk.copy()
        stirred[40:48] += stir
        assert len(run(detector(), stirred)) == counted


def test_one_rise_alone_is_no_step():
    lifted = np.full(300, GRAVITY)
    lifted[100:110] += 3.0
    assert run(detector(), lifted) == []


def test_smaller_than_the_threshold_is_nothing():
    faint = sine(1.5, amplitude=0.05)
    assert run(detector(), faint) == []
    assert len(run(detector(slope_threshold=0.02), faint)) > 20


def test_changed_thresholds_hold_from_then_on():
    found = detector(slope_threshold=5.0)
    assert run(found, sine(1.5)) == []
    found.configure(An900Settings())
    assert len(run(found, sine(1.5), first=600)) > 20
