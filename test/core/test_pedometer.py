"""Totals, calibration, and what a stream of samples can do wrong."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core import step_detectors, step_lengths
from dead_reckoning.core.errors import (
    LateSampleError,
    MissingAccelerationError,
    NotFiniteError,
    RepeatedStampError,
    SettingsError,
    StepCalibrationError,
    ZeroStampError,
)
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import ImuSample

START_NS = 1_700_000_000_000_000_000
SECOND = 1_000_000_000
NAN, INF = math.nan, math.inf


def pedometer(**settings):
    chosen = PedometerSettings(**settings)
    return Pedometer(chosen, chosen.method_part())


def forces(steps=20, rate=100.0, cadence=1.8, rest=3.0, amplitude=2.5):
    """Return specific forces, shape (n, 3), of a rest, a walk and a rest."""
    time = np.arange(0.0, steps / cadence, 1.0 / rate)
    turn = 2.0 * np.pi * cadence * time
    moving = np.column_stack(
        [
            1.2 * np.sin(turn),
            0.5 * np.sin(turn / 2.0),
            GRAVITY + amplitude * (-np.sin(turn) + 0.4 * np.sin(2.0 * turn)),
        ]
    )
    quiet = np.tile([0.0, 0.0, GRAVITY], (round(rest * rate), 1))
    return np.concatenate([quiet, moving, quiet])


def samples(vectors, start_ns=START_NS, rate=100.0):
    stamps = start_ns + np.round(np.arange(len(vectors)) * 1e9 / rate).astype(int)
    return [
        ImuSample(int(stamp), 'imu_link', tuple(vector))
        for stamp, vector in zip(stamps, np.asarray(vectors).tolist(), strict=True)
    ]


def run(estimator, imus):
    return [state for imu in imus for state in estimator.update(imu)]


def plain(states):
    return [dataclasses.astuple(state) for state in states]


def walked(states):
    return [state for state in states if state.duration]


# Totals ---------------------------------------------------------------------------------------


def test_a_walk_is_counted_step_by_step():
    counter = pedometer()
    states = run(counter, samples(forces()))
    assert [state.steps for state in walked(states)] == list(range(1, 21))
    assert counter.steps == 20
    lengths = [state.step_length for state in walked(states)]
    np.testing.assert_allclose(
        [state.distance for state in walked(states)], np.cumsum(lengths), rtol=1e-12
    )
    assert counter.distance == states[-1].distance


def test_cadence_is_that_of_the_walk_and_zero_after_it():
    counter = pedometer()
    states = run(counter, samples(forces()))
    for state in walked(states)[4:]:
        assert state.cadence == pytest.approx(1.8, rel=0.03)
    assert states[-1].duration == states[-1].cadence == counter.cadence == 0.0
    assert not counter.walking


def test_cadence_evens_out_a_limp():
    """AN-900's step times show it; a rhythm's are evened out already."""
    time = np.arange(0.0, 30.0, 0.01)
    phase = 1.6 * time + 0.2 * np.sin(np.pi * 1.6 * time)  # every other step longer
    vectors = np.zeros((len(time), 3))
    vectors[:, 2] = GRAVITY + 2.0 * np.sin(2.0 * np.pi * phase)
    states = walked(run(pedometer(method='an900'), samples(vectors)))[5:]
    durations = [state.duration for state in states]
    assert max(durations) > 1.2 * min(durations)
    for state in states:
        assert state.cadence == pytest.approx(1.6, rel=0.03)


def test_second_walk_adds_to_the_first():
    counter = pedometer()
    run(counter, samples(np.concatenate([forces(), forces()])))
    assert counter.steps == 40


@pytest.mark.parametrize(
    ('method', 'late'),
    # 3.5 samples of the moving sum; a step's time, up to the crest after the landing.
    [('an900', 0.15), ('rhythm', 1.0 / 1.8)],
)
def test_step_is_said_soon_after_it_ended(method, late):
    """Besides: the cell, and what reordering holds back."""
    counter = pedometer(method=method)
    for imu in samples(forces()):
        states = counter.update(imu)
        if states and states[0].steps > 5 and states[0].duration:
            assert imu.stamp_ns - states[-1].stamp_ns < (late + 0.15) * SECOND


def test_exponential_average_is_that_of_the_listing():
    random = np.random.default_rng(8)
    vectors = forces(40) + np.repeat(random.normal(0.0, 0.3, 30), 100)[: len(forces(40)), None]
    raw = [state.step_length for state in walked(run(pedometer(), samples(vectors)))]
    averaged = walked(run(pedometer(averaging=4.0), samples(vectors)))
    expected = raw[:2]
    for length in raw[2:]:
        expected.append((3.0 * expected[-1] + length) / 4.0)
    np.testing.assert_allclose([state.step_length for state in averaged], expected)
    assert np.std(raw) > 1.3 * np.std(expected)


@pytest.mark.parametrize('model', step_lengths.names())
def test_k_multiplies_the_lengths(model):
    once = pedometer(length_model=model, k=1.0)
    twice = pedometer(length_model=model, k=2.0)
    for counter in (once, twice):
        run(counter, samples(forces()))
    assert twice.distance == pytest.approx(2.0 * once.distance)
    assert once.distance > 0.0


def test_height_counts_from_when_it_is_set():
    counter = pedometer(length_model='cadence_height', height=1.6)
    states = walked(run(counter, samples(forces())))
    counter.configure(counter.settings.changed({'pedometer.height': 2.4}))
    later = walked(run(counter, samples(forces(), START_NS + 100 * SECOND)))
    assert [state.step_length for state in later] == pytest.approx(
        [1.5 * state.step_length for state in states]
    )


def test_k_is_that_of_the_model_unless_set():
    assert PedometerSettings().k == PedometerSettings().model.K
    assert PedometerSettings(length_model='constant').k == 0.7
    assert PedometerSettings(length_model='constant', k=0.8).k == 0.8


# Axes -----------------------------------------------------------------------------------------


@given(st.integers(0, 3), st.sampled_from([0.0, 0.3]))
def test_order_of_all_axes_does_not_matter(turns, noise):
    vectors = forces(10) + noise * np.random.default_rng(9).standard_normal(forces(10).shape)
    expected = run(pedometer(), samples(vectors))
    permuted = run(pedometer(), samples(np.roll(vectors, turns, axis=1)))
    assert [s.steps for s in permuted] == [s.steps for s in expected]
    np.testing.assert_allclose(
        [s.distance for s in permuted], [s.distance for s in expected], rtol=1e-9
    )


@pytest.mark.parametrize('axes', [('x', 'y'), ('z',), ('x', 'z')])
def test_other_axes_do_not_count(axes):
    vectors = forces(10)
    expected = plain(run(pedometer(axes=axes), samples(vectors)))
    for index, axis in enumerate('xyz'):
        if axis not in axes:
            vectors[:, index] = 1000.0 * np.random.default_rng(10).standard_normal(len(vectors))
    assert plain(run(pedometer(axes=axes), samples(vectors))) == expected


# Stamps ---------------------------------------------------------------------------------------


def test_jitter_and_disorder_do_not_change_the_count():
    random = np.random.default_rng(12)
    imus = samples(forces(60, 200.0), rate=200.0)
    jittered = [
        dataclasses.replace(imu, stamp_ns=imu.stamp_ns + int(random.integers(-2e6, 2e6)))
        for imu in imus
    ]
    arrivals = sorted(jittered, key=lambda imu: imu.stamp_ns + random.uniform(0.0, 0.09e9))
    assert [a.stamp_ns for a in arrivals] != sorted(a.stamp_ns for a in arrivals)
    counter, expected = pedometer(), pedometer()
    run(counter, arrivals)
    run(expected, imus)
    assert counter.steps == expected.steps == 60
    assert counter.distance == pytest.approx(expected.distance, rel=0.01)


def test_disorder_within_the_hold_changes_nothing_at_all():
    imus = samples(forces(10))
    shuffled = list(
        itertools.chain.from_iterable(imus[k : k + 8][::-1] for k in range(0, len(imus), 8))
    )
    assert plain(run(pedometer(), shuffled)) == plain(run(pedometer(), imus))


BAD = [
    ((NAN, 0.0, 0.0), 0, NotFiniteError),
    ((0.0, INF, 0.0), 0, NotFiniteError),
    ((0.0, 0.0, 1e200), 0, NotFiniteError),
    ((0.0, 0.0, GRAVITY), -1, RepeatedStampError),
    ((0.0, 0.0, GRAVITY), -30, LateSampleError),
]


@pytest.mark.parametrize(('force', 'at', 'error'), BAD)
def test_refused_sample_changes_nothing(force, at, error):
    imus = samples(forces(10))
    expected = plain(run(pedometer(), imus))
    counter, states = pedometer(), []
    for k, imu in enumerate(imus):
        states += counter.update(imu)
        if k % 50 == 45:
            stamp_ns = imu.stamp_ns + 1 if at == 0 else imus[k + 1 + at].stamp_ns + (at < -1)
            with pytest.raises(error):
                counter.update(ImuSample(stamp_ns, 'imu_link', force))
    assert plain(states) == expected


def test_stamp_zero_is_refused():
    with pytest.raises(ZeroStampError):
        pedometer().update(ImuSample(0, 'imu_link', (0.0, 0.0, GRAVITY)))


def test_imu_without_acceleration_is_refused():
    with pytest.raises(MissingAccelerationError):
        pedometer().update(ImuSample(START_NS, 'imu_link', (0.0, 0.0, 0.0), (-1.0, *(0.0,) * 8)))


def test_gap_ends_the_walk_and_counts_nothing_over_it():
    vectors = forces(30, rest=0.0)
    imus = samples(vectors)
    half = len(imus) // 2
    first, second = imus[:half], imus[half + 150 :]
    alone = [pedometer(), pedometer()]
    run(alone[0], first)
    run(alone[1], second)
    counter = pedometer()
    states = run(counter, [*first, *second])
    assert counter.gaps == 1
    # What the hold keeps back before the gap is counted still.
    assert alone[0].steps + alone[1].steps <= counter.steps <= 2 + sum(c.steps for c in alone)
    ends = [state for state in states if state.duration == 0.0]
    assert len(ends) == 1
    assert first[-1].stamp_ns - 0.2 * SECOND < ends[0].stamp_ns <= first[-1].stamp_ns
    for before, after in itertools.pairwise(walked(states)):
        inside = before.stamp_ns < ends[0].stamp_ns < after.stamp_ns
        assert not inside or after.duration < 2.0


def test_gap_within_the_limit_is_bridged():
    imus = samples(forces(30))
    counter = pedometer()
    run(counter, imus[:600] + imus[680:])
    assert counter.gaps == 0
    assert 26 <= counter.steps <= 30


def test_restart_ends_the_walk_and_keeps_the_totals():
    imus = samples(forces(20, rest=0.0))
    some_wait = 0
    for cut in range(1, 60, 10):  # within a step
        counter = pedometer()
        run(counter, imus[:-cut])
        before = counter.steps
        assert counter.walking
        *waited, end = counter.update(imus[0])
        assert counter.restarts == 1
        assert [state.steps for state in waited] == list(range(before + 1, end.steps + 1))
        assert end.duration == end.cadence == 0.0
        assert 14 < end.steps <= 20
        assert not counter.walking
        run(counter, imus[1:-cut])
        assert counter.steps == end.steps + before
        some_wait += len(waited)
    assert some_wait


def test_one_stamp_from_the_future_costs_no_more_than_a_walk():
    counter = pedometer()
    imus = samples(forces(40))
    future = dataclasses.replace(imus[600], stamp_ns=START_NS + 10**17)
    run(counter, [*imus[:600], future, *imus[600:]])
    assert (counter.gaps, counter.restarts) == (0, 1)
    assert 37 <= counter.steps <= 40


# Start, stop, reset ---------------------------------------------------------------------------


def test_stop_holds_the_totals_and_start_clears_them():
    counter = pedometer()
    run(counter, samples(forces()))
    counter.stop()
    held = (counter.steps, counter.distance, counter.step_length)
    assert run(counter, samples(forces(), START_NS + 100 * SECOND)) == []
    assert (counter.steps, counter.distance, counter.step_length) == held
    assert counter.cadence == 0.0
    counter.start()
    assert (counter.steps, counter.distance, counter.step_length) == (0, 0.0, 0.0)
    run(counter, samples(forces(), START_NS + 200 * SECOND))
    assert counter.steps == 20


def test_stop_in_a_walk_ends_it():
    counter = pedometer()
    run(counter, samples(forces(rest=0.0)))
    assert counter.walking
    counter.stop()
    assert not counter.walking
    assert counter.cadence == 0.0


@pytest.mark.parametrize('how', ['stop', 'flush', 'gap'])
def test_end_loses_no_step_that_was_sure(how):
    """Cut 0.3 s after the crest of the last step: the one before it still waits for its time."""
    counter = pedometer()
    imus = samples(forces())[: round(100.0 * (3.0 + 9.75 / 1.8 + 0.3))]
    run(counter, imus)
    waiting = counter.steps
    if how == 'gap':
        run(counter, samples(forces(1, rest=1.0), imus[-1].stamp_ns + 2 * SECOND))
    else:
        getattr(counter, how)()
    assert waiting < counter.steps == 10
    assert not counter.walking


def test_reset_clears_the_totals_and_counts_on():
    counter = pedometer()
    run(counter, samples(forces()))
    counter.reset()
    assert (counter.steps, counter.distance) == (0, 0.0)
    assert counter.running
    run(counter, samples(forces(), START_NS + 100 * SECOND))
    assert counter.steps == 20


def test_reset_while_stopped_stays_stopped():
    counter = pedometer()
    counter.stop()
    counter.reset()
    assert not counter.running
    assert run(counter, samples(forces())) == []


def test_bad_sample_is_refused_while_stopped_too():
    counter = pedometer()
    counter.stop()
    with pytest.raises(NotFiniteError):
        counter.update(ImuSample(START_NS, 'imu_link', (NAN, 0.0, 0.0)))


# Settings -------------------------------------------------------------------------------------


def test_changed_settings_hold_from_the_next_step_on():
    counter = pedometer(length_model='constant')
    imus = samples(forces())
    run(counter, imus[:800])
    steps = counter.steps
    counter.configure(dataclasses.replace(counter.settings, k=2.0))
    run(counter, imus[800:])
    assert counter.distance == pytest.approx(0.7 * steps + 2.0 * (20 - steps))


def test_window_of_time_has_to_admit_something():
    with pytest.raises(SettingsError, match=r'pedometer\.longest_step: 0\.5 s is not longer'):
        PedometerSettings(shortest_step=0.5, longest_step=0.5)


# Calibration ----------------------------------------------------------------------------------


@pytest.mark.parametrize('model', step_lengths.names())
def test_calibration_makes_the_distance_fit(model):
    counter = pedometer(length_model=model, calibration_distance=15.0, k=3.0)
    counter.begin_calibration()
    run(counter, samples(forces()))
    found = counter.end_calibration()
    assert found.steps == 20
    assert counter.settings.k == 3.0
    fitted = pedometer(length_model=model, k=found.k)
    run(fitted, samples(forces()))
    assert fitted.distance == pytest.approx(15.0)


def test_calibration_counts_from_where_it_begins():
    counter = pedometer(length_model='constant', calibration_distance=10.0)
    run(counter, samples(forces(30)))
    counter.begin_calibration()
    run(counter, samples(forces(20), START_NS + 100 * SECOND))
    found = counter.end_calibration()
    assert (found.steps, found.k) == (20, 0.5)
    assert counter.steps == 50


@pytest.mark.parametrize('method', step_detectors.names())
@pytest.mark.parametrize('begin', [3.5, 4.0, 5.0, 6.0, 12.0])
def test_calibration_may_begin_in_a_walk(method, begin):
    """Begin and end on the way: as many steps as were made between, however late they come."""
    counter = pedometer(length_model='constant', calibration_distance=20.0, method=method)
    imus = samples(forces(60))
    first, last = round(100.0 * begin), round(100.0 * (begin + 15.0))
    run(counter, imus[:first])
    counter.begin_calibration()
    run(counter, imus[first:last])
    assert counter.end_calibration().steps == pytest.approx(15.0 * 1.8, abs=1.0)


def test_calibration_goes_on_over_a_restart():
    counter = pedometer(length_model='constant', calibration_distance=10.0)
    run(counter, samples(forces(), START_NS + 1000 * SECOND))
    counter.begin_calibration()
    run(counter, samples(forces()))
    assert counter.end_calibration().steps == 20


def test_change_of_k_meanwhile_does_not_disturb_calibration():
    counter = pedometer(length_model='constant', calibration_distance=10.0)
    counter.begin_calibration()
    imus = samples(forces())
    run(counter, imus[:700])
    counter.configure(dataclasses.replace(counter.settings, k=5.0))
    run(counter, imus[700:])
    assert counter.end_calibration().k == 0.5


def test_calibration_says_what_is_wrong():
    counter = pedometer(calibration_distance=100_000.0)
    with pytest.raises(StepCalibrationError, match='no calibration was begun'):
        counter.end_calibration()
    counter.begin_calibration()
    with pytest.raises(StepCalibrationError, match='0 steps since the start'):
        counter.end_calibration()
    run(counter, samples(forces()))
    with pytest.raises(SettingsError, match=r'pedometer\.k: .* is not allowed'):
        counter.end_calibration()
    counter.configure(dataclasses.replace(counter.settings, calibration_distance=15.0))
    assert counter.end_calibration().steps == 20
    with pytest.raises(StepCalibrationError, match='no calibration was begun'):
        counter.end_calibration()


@pytest.mark.parametrize('what', ['stop', 'reset', 'start'])
def test_stop_and_reset_end_a_calibration(what):
    counter = pedometer()
    counter.begin_calibration()
    getattr(counter, what)()
    with pytest.raises(StepCalibrationError, match='a stop or reset ended it'):
        counter.end_calibration()


def test_stopped_pedometer_calibrates_nothing():
    counter = pedometer()
    counter.stop()
    with pytest.raises(StepCalibrationError, match='stopped'):
        counter.begin_calibration()
