"""Steps by their rhythm: who walks is counted from the first step on, and nobody else."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core.kernels import rhythm
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.step_detectors.rhythm import RhythmDetector, RhythmSettings
from dead_reckoning.core.step_window import StepWindow

START_NS = 1_700_000_000_000_000_000
RATE = rhythm.RATE
PERIOD_NS = 1_000_000_000 // RATE


def detector(shortest=0.25, longest=2.0, **settings):
    return RhythmDetector(RhythmSettings(**settings), StepWindow(shortest, longest))


def run(found, magnitudes, first=0):
    return [
        step
        for k, magnitude in enumerate(magnitudes, first)
        for step in found.update(START_NS + k * PERIOD_NS, float(magnitude))
    ]


def rest(seconds):
    return np.full(round(seconds * RATE), GRAVITY)


def bounce(steps, cadence=1.8, amplitude=2.0):
    """Return magnitudes of a number of steps, each of them down and up."""
    turn = 2.0 * np.pi * cadence * np.arange(round(RATE * steps / cadence)) / RATE
    return GRAVITY - amplitude * (np.sin(turn) - 0.2 * np.sin(2.0 * turn))


def walk(steps, cadence=1.8, amplitude=2.0, before=3.0, after=3.0):
    return np.concatenate([rest(before), bounce(steps, cadence, amplitude), rest(after)])


def noise(size, seed=5):
    return 0.05 * np.random.default_rng(seed).standard_normal(size)


# Counting -------------------------------------------------------------------------------------


@pytest.mark.parametrize('steps', [6, 7, 10, 31, 200])
@pytest.mark.parametrize('cadence', [1.4, 1.8, 2.2, 2.6])
@pytest.mark.parametrize('amplitude', [2.0, 6.0])
def test_count_is_exact(steps, cadence, amplitude):
    magnitudes = walk(steps, cadence, amplitude)
    assert len(run(detector(), magnitudes + noise(len(magnitudes)))) == steps


@pytest.mark.parametrize('cadence', [0.8, 1.0, 1.2])
@pytest.mark.parametrize('amplitude', [0.5, 2.5, 3.5])
def test_slow_step_is_not_two_however_hard(cadence, amplitude):
    steps = run(detector(), walk(60, cadence, amplitude))
    assert len(steps) == pytest.approx(60, abs=1)


@pytest.mark.parametrize('pause', [4.0, 6.0, 15.0, 120.0])
def test_two_walks_with_a_pause_are_counted_from_their_first_steps_on(pause):
    magnitudes = np.concatenate([walk(12, after=pause), walk(15, 2.0, before=0.0)])
    found = detector()
    assert len(run(found, magnitudes)) == 12 + 15
    assert not found.walking


def test_gate_opens_once_and_credits_all_steps_since_the_first():
    found, begun = detector(), None
    for k, magnitude in enumerate(walk(20)):
        steps = found.update(START_NS + k * PERIOD_NS, float(magnitude))
        if steps and begun is None:
            begun = steps
            assert 3.0 + 3 / 1.8 < k / RATE < 3.0 + 6 / 1.8, 'several consistent steps first'
        elif begun is not None:
            assert len(steps) <= 1
    assert len(begun) >= 3
    first = (begun[0].stamp_ns - START_NS) * 1e-9
    assert 3.0 < first < 3.0 + 1.0 / 1.8 + 0.1


def test_step_is_said_a_step_late_once_the_gate_is_open():
    found, cadence = detector(), 1.8
    for k, magnitude in enumerate(walk(40, cadence)):
        for step in found.update(START_NS + k * PERIOD_NS, float(magnitude)):
            if k > 9 * RATE:
                assert START_NS + k * PERIOD_NS - step.stamp_ns < (1.0 / cadence + 0.1) * 1e9


# The gate -------------------------------------------------------------------------------------


@pytest.mark.parametrize('level', [0.0, GRAVITY, 1e4])
def test_silence_is_no_walk(level):
    assert run(detector(), level + noise(600 * RATE)) == []


@pytest.mark.parametrize('deviation', [1.0, 4.0, 20.0])
def test_shaking_at_random_is_no_walk(deviation):
    random = np.random.default_rng(6)
    assert run(detector(), GRAVITY + deviation * random.standard_normal(600 * RATE)) == []


def test_turns_of_a_hand_at_random_are_seldom_steps():
    """Each another time and another way, so that a few in a row look regular by chance."""
    counted = turns = 0
    for seed in range(20):
        random = np.random.default_rng(seed)
        times = np.cumsum(random.uniform(0.15, 1.5, 73))
        forces = random.normal(0.0, 4.0, len(times))
        shaken = np.interp(np.arange(60 * RATE) / RATE, times, forces)
        counted += len(run(detector(), GRAVITY + shaken))
        turns += len(times)
    assert counted < 0.05 * turns


@pytest.mark.parametrize('height', [3.0, 30.0, 300.0])
def test_jolt_is_no_walk(height):
    magnitudes = rest(20.0)
    magnitudes[500:505] += height
    found = detector()
    assert run(found, magnitudes) == []
    assert found.finish() == []


@pytest.mark.parametrize('interval', [0.4, 0.6, 0.9])
@pytest.mark.parametrize(('knocks', 'height'), [(2, 8.0), (3, 5.0), (3, 20.0), (4, 5.0)])
def test_a_few_knocks_are_no_walk(interval, knocks, height):
    """At the same intervals: who knocks at a door repeats himself, too."""
    magnitudes = rest(20.0)
    for knock in range(knocks):
        at = round((8.0 + knock * interval) * RATE)
        magnitudes[at : at + 3] += height
    found = detector()
    assert run(found, magnitudes) == []
    assert found.finish() == []


def test_walk_ends_after_the_longest_step():
    found = detector(longest=1.0)
    steps = run(found, walk(12, after=0.0))
    assert found.walking
    last_ns = (steps + run(found, rest(1.7), 600))[-1].stamp_ns
    assert not found.walking
    assert last_ns < START_NS + 600 * PERIOD_NS


# Steps ----------------------------------------------------------------------------------------


@pytest.mark.parametrize('cadence', [1.0, 1.8, 2.6])
def test_stamps_rise_and_samples_are_those_between_them(cadence):
    magnitudes = walk(30, cadence, 1.0)
    steps = run(detector(), magnitudes)
    assert len(steps) == 30
    for before, step in pairwise(steps):
        assert step.stamp_ns > before.stamp_ns
        assert step.duration == pytest.approx((step.stamp_ns - before.stamp_ns) * 1e-9, abs=1e-8)
        begin, end = ((each.stamp_ns - START_NS) / PERIOD_NS for each in (before, step))
        expected = magnitudes[int(begin) + 1 : int(end) + 1].tolist()
        assert step.samples == pytest.approx(expected)
        assert len(step.samples) > 0


def test_samples_between_stamps_pass_the_end_of_what_is_kept():
    """The magnitudes are kept in a ring, round which the steps go."""
    steps = run(detector(), walk(400, 2.0))
    assert len(steps) == 400
    for step in steps[2:-2]:
        assert len(step.samples) == pytest.approx(RATE / 2.0, abs=1)
        assert np.ptp(step.samples) > 3.0


def test_no_step_is_filled_in_sooner_than_the_shortest():
    steps = run(detector(shortest=0.6), walk(40, 1.8))
    assert len(steps) == pytest.approx(20, abs=2)
    assert min(step.duration for step in steps) > 0.55


# The end --------------------------------------------------------------------------------------


def test_end_gives_the_steps_that_wait():
    """Cut at any moment, all is counted whose crest was over by then."""
    magnitudes = walk(20)
    for end in range(round(8.0 * RATE), len(magnitudes), 7):
        found = detector()
        steps = [*run(found, magnitudes[:end]), *found.finish()]
        crests = np.floor((end / RATE - 3.0) * 1.8 + 0.25)
        assert 0 <= min(crests, 20) - len(steps) <= 1
        assert all(a.stamp_ns < b.stamp_ns for a, b in pairwise(steps))
        assert steps[-1].stamp_ns < START_NS + (end + 10) * PERIOD_NS
        assert not found.walking
        assert found.finish() == []


def test_nothing_waits_before_the_gate_is_open():
    found = detector()
    assert run(found, walk(3, after=0.0)) == []
    assert found.finish() == []


def test_after_the_end_all_begins_anew():
    found = detector()
    expected = run(found, walk(12))
    found.finish()
    assert [step.samples for step in run(found, walk(12))] == [step.samples for step in expected]


# State ----------------------------------------------------------------------------------------


def test_an_hour_of_walking_takes_no_more_memory_than_a_second():
    found = detector()
    state = found._state
    steps = 0
    for number in range(60):
        steps += len(run(found, bounce(120, 2.0), number * 3000))
    assert found._state is state
    assert state.shape == (rhythm.LENGTH,)
    assert steps == pytest.approx(7200, abs=3)
    assert state[rhythm.QUEUED] <= 2
    assert state[rhythm.HELD_COUNT] == 0


def test_compiled_code_does_what_the_function_does():
    magnitudes = walk(8) + noise(len(walk(8)))
    found = detector()
    memories = [found._memory, found._memory.copy()]
    states = [memory[rhythm.RULES :] for memory in memories]
    kernels = (
        (rhythm.take, rhythm.finish),
        (rhythm.take.__wrapped__, rhythm.finish.__wrapped__),
    )
    said = [
        [take(float(magnitude), 0.25, 2.0, memory) for magnitude in magnitudes[:350]]
        + [finish(memory[rhythm.RULES :])]
        for (take, finish), memory in zip(kernels, memories, strict=True)
    ]
    assert said[0] == said[1]
    assert any(said[0])
    np.testing.assert_allclose(states[0], states[1], rtol=1e-9, atol=1e-9)


EXTREMES = {
    'great': 1e6 * np.abs(np.random.default_rng(1).standard_normal(1000)),
    'greater': 1e100 * np.abs(np.random.default_rng(2).standard_normal(1000)),
    'denormal': np.full(1000, 5e-324) * np.random.default_rng(3).integers(0, 9, 1000),
    'zero': np.zeros(1000),
    'constant': np.full(1000, GRAVITY),
    'one great': np.where(np.arange(1000) == 300, 1e6, GRAVITY),
    'square': np.where(np.arange(1000) // 25 % 2, 1e6, 0.0),
}


@pytest.mark.parametrize('kind', EXTREMES)
def test_extremes_leave_no_nan(kind):
    found = detector()
    steps = [*run(found, EXTREMES[kind]), *found.finish()]
    found = detector()
    run(found, EXTREMES[kind])
    assert np.isfinite(found._state).all()
    assert np.isfinite([step.duration for step in steps]).all()
    assert all(step.duration > 0.0 and step.samples for step in steps)


@pytest.mark.parametrize('wait', [1.0, 5.0])
def test_walk_after_a_jolt_is_counted(wait):
    found, jolted = detector(), rest(10.0)
    jolted[300:305] += 300.0
    run(found, jolted)
    assert len(run(found, walk(40, before=wait), len(jolted))) == 40


# Settings -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('change', 'steps'),
    [
        # The gate was held shut, so the steps of the first walk are credited too.
        ({'open': 100.0}, 40),
        ({'rise': 50.0}, 20),
        ({'faint': 1.0, 'strong': 1.0, 'centre': 1.0}, 20),
    ],
)
def test_changed_settings_hold_from_then_on(change, steps):
    found = detector(**change)
    assert run(found, walk(20)) == []
    found.configure(RhythmSettings())
    assert len(run(found, walk(20), len(walk(20)))) == steps


def test_all_settings_can_change_amid_a_walk():
    found, again = detector(), detector()
    expected = run(found, walk(20))
    magnitudes = walk(20)
    steps = run(again, magnitudes[:400])
    again.configure(RhythmSettings())
    assert [s.stamp_ns for s in steps + run(again, magnitudes[400:], 400)] == [
        step.stamp_ns for step in expected
    ]


@given(st.integers(0, 2**32), st.floats(-3.0, 6.0))
def test_whatever_comes_stamps_rise_and_steps_have_samples(seed, magnitude):
    random = np.random.default_rng(seed)
    shaken = np.abs(10.0**magnitude * random.standard_normal(200))
    found = detector(open=0.1, rise=0.0, likeness=-1.0)
    steps = [*run(found, [*shaken, *bounce(8), *shaken]), *found.finish()]
    assert all(a.stamp_ns < b.stamp_ns for a, b in pairwise(steps))
    assert all(step.duration > 0.0 and step.samples for step in steps)
