"""What the benchmarks of steps are made of: counters, matching, mobgap's files, simulations."""

import numpy as np
import pytest
from scipy.io import savemat

from benchmarks.accuracy import mobgap, pedometer_cost, simulated_steps, step_counters
from benchmarks.accuracy.step_counters import Published, Walk, published
from benchmarks.accuracy.step_times import common_lag, f1, matched, seconds
from dead_reckoning.core.errors import RecordingError

PACE = 1.8
STEPS = 54
SECONDS = STEPS / PACE
RATE = 100.0


def walk(rest=0.0):
    """A sine of 54 steps at 100 Hz, some rest before and after it."""
    time = np.arange(0.0, SECONDS + 2.0 * rest, 1.0 / RATE)
    within = (time > rest) & (time < rest + SECONDS)
    norm = 9.81 + within * 3.0 * np.sin(2.0 * np.pi * PACE * (time - rest))
    stamps_ns = np.round(1e9 * (1.0 + time)).astype(np.int64)
    return Walk('walk', STEPS, stamps_ns, np.outer(norm, [0.0, 0.6, -0.8]))


@pytest.mark.parametrize('name', step_counters.OTHERS)
def test_each_counter_finds_the_steps_of_a_sine_where_they_are(name):
    found = seconds(walk(2.0), step_counters.OTHERS[name](walk(2.0)))
    assert len(found) == pytest.approx(STEPS, abs=1)
    assert np.diff(found[1:-1]) == pytest.approx(1.0 / PACE, abs=0.05)
    assert 1.5 < found[0] < 3.0


def test_the_order_of_the_stamps_is_no_matter():
    true = walk(1.0)
    order = np.arange(len(true.stamps_ns))
    order[50:52] = 51, 50
    swapped = Walk('', STEPS, true.stamps_ns[order], true.force_s[order])
    for counter in step_counters.OTHERS.values():
        assert counter(swapped).tolist() == counter(true).tolist()


def test_a_walk_is_varied():
    true = walk(1.0)
    varied = true.varied(0.4, 1.3)
    assert varied.seconds == pytest.approx(1.3 * true.seconds)
    swing, before = (np.linalg.norm(w.force_s, axis=1) - 9.81 for w in (varied, true))
    assert swing == pytest.approx(0.4 * before, abs=1e-9)
    assert true.stretched(varied.stamps_ns, 1.0 / 1.3).tolist() == true.stamps_ns.tolist()
    assert len(published(varied).stamps_ns) == pytest.approx(STEPS, abs=1)


def test_too_short_a_walk_is_said():
    short = Walk('short', 1, np.array([1, 2_000_000_000]), np.tile(9.81, (2, 3)))
    with pytest.raises(RecordingError, match='short: 2 s is no walk'):
        step_counters.count(short)


def test_nothing_found_is_nothing_matched():
    still = Walk('', 0, walk().stamps_ns, np.tile((0.0, 0.0, 9.81), (len(walk().stamps_ns), 1)))
    counted = step_counters.count(still)
    assert [len(found) for found in counted.found.values()] == [0] * 4
    assert len(counted.published.steps_late) == 0
    assert common_lag([(np.array([]), np.array([1.0]))]) == 0.0


def test_steps_late_are_those_made_before_one_came_out():
    stamps_ns = np.array([10, 20, 30, 40])
    going = np.array([False, True, True, True])
    told = Published(stamps_ns, np.array([45, 25, 45, 40]), going, 0)
    assert told.steps_late.tolist() == [0, 1, 0]
    assert told.latency == pytest.approx([35e-9, 5e-9, 15e-9, 0.0])


def test_steps_come_out_in_time_once_a_walk_goes_on():
    told = published(walk(2.0))
    assert len(told.steps_late) > STEPS - 10
    assert told.steps_late.max() <= 1
    assert (told.latency > 0.0).all()


def test_a_step_is_matched_at_most_once_and_in_order():
    true = np.array([1.0, 1.15, 2.0, 3.0])
    found = np.array([1.08, 1.12, 2.5, 2.95, 3.05])
    assert matched(found, true) == [(0, 0), (1, 1), (3, 3)]
    assert f1(found, true) == pytest.approx(2 * 3 / 9)
    assert f1(true, true) == 1.0
    assert f1(np.array([]), true) == f1(np.array([]), np.array([])) == 0.0


def test_matching_finds_the_most():
    random = np.random.default_rng(0)
    for _ in range(50):
        found, true = (np.sort(random.uniform(0.0, 2.0, 8)) for _ in range(2))
        most = np.zeros((9, 9), int)
        for k in range(1, 9):
            for j in range(1, 9):
                same = abs(found[k - 1] - true[j - 1]) <= 0.1
                most[k, j] = max(most[k - 1, j], most[k, j - 1], most[k - 1, j - 1] + same)
        pairs = matched(found, true)
        assert len(pairs) == most[8, 8]
        assert all(abs(found[k] - true[j]) <= 0.1 for k, j in pairs)


def test_one_lag_fits_all_recordings():
    random = np.random.default_rng(1)
    true = [np.cumsum(random.uniform(0.4, 0.7, 100)) for _ in range(3)]
    pairs = [(some + 0.23 + random.uniform(-0.09, 0.09, 100), some) for some in true]
    assert common_lag(pairs) == pytest.approx(0.23, abs=0.015)


def bout(start, steps, unknown=()):
    """A bout of so many contacts, at the pace of `walk`."""
    contacts = start + np.arange(steps) / PACE
    end = contacts[-1]
    contacts[list(unknown)] = np.nan
    return {
        'Start': start,
        'End': end,
        'InitialContact_Event': contacts,
        'Length': 0.6 * (steps - 1),
        'Stride_Length': np.full(steps - 2, 1.2),
    }


def trial(rest, bouts):
    force = walk(rest).force_s / 9.80665
    lower_back = {'Acc': force, 'Gyr': np.zeros_like(force), 'Fs': {'Acc': 100}}
    return {
        'SU': {'LowerBack': lower_back},
        'Standards': {'INDIP': {'MicroWB': bouts}},
    }


def write_mobgap(folder, tests):
    folder.mkdir(exist_ok=True)
    savemat(folder / 'P_001_data.mat', {'data': {'TimeMeasure1': tests}})


def test_steps_of_mobgap_are_counted_within_the_bouts(tmp_path):
    first, second = bout(4.0 + 0.1, 20, unknown=[1]), bout(4.0 + 30.1 / PACE, 10)
    free = np.array([first, second], dtype=object)
    tests = {
        'Test5': {'Trial1': trial(2.0, bout(2.1, STEPS)), 'Trial2': trial(2.0, [])},
        'Test11': {'Trial1': trial(4.0, free)},
        'Test7': {'Trial1': {}},
    }
    write_mobgap(tmp_path / 'set', tests)
    straight, unseen, freely = mobgap.load(tmp_path / 'set' / 'P_001_data.mat')
    assert straight.walk.name == 'P_001 Test5 Trial1'
    assert np.linalg.norm(straight.force_s, axis=1)[0] == pytest.approx(9.81, abs=1e-6)
    assert unseen.bouts == ()
    assert freely.walk.true == 30
    assert len(freely.walk.landings_ns) == 29
    (one, other) = freely.bouts
    assert (one.length, one.strides.tolist()) == (pytest.approx(0.6 * 19), [1.2] * 18)
    assert one.step == pytest.approx(1.0 / PACE)
    assert freely.inside(freely.walk.landings_ns) == 29
    just = np.array([one.start - 0.51 / PACE, one.start - 0.49 / PACE, other.end + 0.49 / PACE])
    assert freely.inside(freely.stamps_ns[0] + np.round(just * 1e9).astype(np.int64)) == 2

    report = mobgap.measure(tmp_path / 'set', tmp_path)
    assert [goal.met for goal in report.goals] == [True, True]
    found = report.figures['free walking']['P_001 Test11 Trial1']
    assert found['contacts'] == 30
    assert found['pedometer'] == {
        'inside': pytest.approx(30, abs=1),
        'in all': pytest.approx(STEPS, abs=1),
    }
    assert '1 trials have no true contacts' in '\n'.join(report.text)
    assert report.pictures[0].read_bytes().startswith(b'\x89PNG')


def test_what_mobgap_has_not_is_said(tmp_path):
    with pytest.raises(RecordingError, match=r'in it; docs/accuracy\.md says how'):
        mobgap.measure(tmp_path, tmp_path)
    path = tmp_path / 'P_001_data.mat'
    path.write_bytes(b'what')
    with pytest.raises(RecordingError, match=r'P_001_data\.mat'):
        mobgap.load(path)
    savemat(path, {'other': 1})
    with pytest.raises(RecordingError, match='KeyError'):
        mobgap.load(path)
    write_mobgap(tmp_path, {'Test5': {'Trial1': {'SU': {}}}})
    with pytest.raises(RecordingError, match='LowerBack'):
        mobgap.load(path)
    broken = trial(1.0, [])
    broken['SU']['LowerBack']['Acc'][5, 1] = np.nan
    write_mobgap(tmp_path, {'Test5': {'Trial1': broken}})
    with pytest.raises(RecordingError, match='Acc is no force'):
        mobgap.load(path)
    write_mobgap(tmp_path, {'Test5': {'Trial1': trial(1.0, [])}})
    with pytest.raises(RecordingError, match='no walking'):
        mobgap.measure(tmp_path, tmp_path)


def test_simulated_steps_and_cost_are_reported(tmp_path, monkeypatch):
    monkeypatch.setattr(simulated_steps, 'WALKS', (1.75,))
    monkeypatch.setattr(simulated_steps, 'OTHERS', ((2.0, 0.5),))
    monkeypatch.setattr(simulated_steps, 'RUNS', (2.75,))
    monkeypatch.setattr(simulated_steps, 'SEEDS', (1,))
    report = simulated_steps.measure(tmp_path)
    assert [goal.met for goal in report.goals] == [True] * 3
    monkeypatch.setattr(pedometer_cost, 'RATES', (50,))
    report = pedometer_cost.measure(tmp_path)
    assert 0.1 < report.figures['microseconds']['50 Hz']['pedometer'] < 100.0
    assert len(report.goals) == 1
