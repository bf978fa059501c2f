"""The benchmarks of walks and of gravity removal, on tiny stand-ins of their recordings."""

import csv
import gzip

import numpy as np
import pytest

from benchmarks.accuracy import airbrakes, oxford, wrist
from dead_reckoning.core.errors import RecordingError

PACE = 1.8
SECONDS = 30.0
STEPS = 54
CUT = 2
"""The recording begins and ends amid a step: one at each end is not seen whole."""


def bounce(time):
    return 9.81 + 3.0 * np.sin(2.0 * np.pi * PACE * time)


def write_oxford(folder, name='opt_Somebody_1'):
    """Write a walk of 54 steps at 100 Hz, two stamps in the wrong order, a switch that bounces."""
    folder.mkdir(exist_ok=True)
    start = 5_000_000_000
    moments = np.arange(-1.0, SECONDS + 1.0, 0.01)
    rows = [
        f'{start + round(t * 1e9)},3,0.0,{0.6 * f:.6f},{0.8 * f:.6f}'
        for t, f in zip(moments, bounce(moments), strict=True)
    ]
    rows[500], rows[501] = rows[501], rows[500]
    with gzip.open(folder / f'{name}{oxford.ENDING}', 'wt') as file:
        file.write('\n'.join(rows) + '\n')
    times = np.arange(0.0, SECONDS, 0.02)
    phase = times * PACE / 2.0 % 1.0
    left, right = phase > 0.5, (phase < 0.45) & (phase > 0.02)
    left[int(len(left) * 0.5) + 10] ^= True  # a bounce, or a missed contact
    with gzip.open(folder / f'{name}_stepcounter.csv.gz', 'wt') as file:
        for t, a, b in zip(times, left, right, strict=True):
            file.write(f'{start + round(t * 1e9)},{int(a)},{int(b)}\n')


def write_wrist(folder, name, magnitudes, true):
    folder.mkdir(exist_ok=True)
    with gzip.open(folder / f'{name}.csv.gz', 'wt', newline='') as file:
        rows = csv.writer(file)
        rows.writerow(('Timestamp', 'Magnitude', 'Steps', 'Header'))
        for number, value in enumerate(magnitudes):
            rows.writerow((number // 25, round(value), true if number == 0 else '', ''))


def write_airbrakes(folder, name, up_s, trembling=0.0):
    """Write 1 s of rest and 2 s of up and down; the sensor's own estimate is the truth."""
    folder.mkdir(exist_ok=True)
    up_s = np.array(up_s)
    head = ['timestamp'] + [
        f'{what}{axis}'
        for what in ('scaledAccel', 'scaledGyro', 'estLinearAccel', 'estGravityVector')
        for axis in 'XYZ'
    ]
    random = np.random.default_rng(1)
    with gzip.open(folder / f'{name}.csv.gz', 'wt', newline='') as file:
        rows = csv.writer(file)
        rows.writerow(head)
        for number in range(3000):
            stamp = 1_000_000_000_000 + 1_000_000 * number
            push = 5.0 * np.sin(np.pi * (number / 1000 - 1.0)) if number > 1000 else 0.0
            force = (push / 9.80665 + 1.0) * up_s
            turn = random.normal(0.0, trembling, 3)
            rows.writerow([stamp, *force, *turn, *[''] * 6])
            if number % 2:
                rows.writerow([stamp, *[''] * 6, *(push * up_s), *(-9.80665 * up_s)])


def test_walks_are_counted_beside_the_switches(tmp_path):
    write_oxford(tmp_path / 'set')
    report = oxford.measure(tmp_path / 'set', tmp_path)
    figures = report.figures['steps']['walks']['Somebody_1']
    names = ('pedometer', 'AN-900, printed', 'AN-900, corrected', 'find_peaks')
    # As printed it loses the first, and the last as the recording ends.
    assert figures.pop('AN-900, printed') == STEPS - 2
    assert figures == {'true': STEPS} | {
        name: pytest.approx(STEPS, abs=CUT) for name in names if 'printed' not in name
    }
    assert report.figures['samples']['refused'] == 0
    times = report.figures['step times']
    assert {name for name in names if times[name]['worst'] > 0.97} == set(names)
    assert all(goal.met for goal in report.goals if 'steps,' not in goal.what)
    assert [picture.name for picture in report.pictures] == [
        'oxford.png',
        'oxford-good.png',
        'oxford-worst.png',
    ]
    assert all(picture.read_bytes().startswith(b'\x89PNG') for picture in report.pictures)


def test_bounces_of_a_switch_are_no_landings():
    time = np.arange(0.0, 10.0, 0.1)
    clean = (time % 1.0 > 0.55).astype(int)
    bouncing = clean.copy()
    bouncing[8::10] = 0
    stamps_ns = np.round(time * 1e9).astype(np.int64)
    landed = oxford.landings(stamps_ns, clean)
    assert len(landed) == 10
    assert oxford.landings(stamps_ns, bouncing).tolist() == landed.tolist()


def test_a_wrist_walks_or_does_other_things(tmp_path):
    time = np.arange(0.0, SECONDS, 0.04)
    folder = tmp_path / 'set'
    write_wrist(folder, 'l2-25hz-bw4__normal-walking1', 2000.0 * bounce(time), STEPS)
    write_wrist(folder, 'l2-25hz-bw4__desk-working1', np.full(len(time), 19_000.0), 0)
    report = wrist.measure(folder, tmp_path)
    walked = report.figures['steps']['walks']['l2-25hz-bw4__normal-walking1']
    assert walked['pedometer'] == pytest.approx(STEPS, abs=CUT)
    assert report.figures['paces']['normal']['pedometer']['worst'] <= 100.0 * CUT / STEPS
    assert report.figures['false steps']['pedometer'] == {'mean': 0.0, 'worst': 0}
    assert [goal.met for goal in report.goals] == [True] * 4
    (tmp_path / 'bad').mkdir()
    write_wrist(tmp_path / 'bad', 'walking', [1.0], 0)
    with pytest.raises(RecordingError, match='none of the rates'):
        wrist.measure(tmp_path / 'bad', tmp_path)


@pytest.mark.parametrize('up_s', [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.6, -0.8)])
def test_gravity_is_removed_in_any_orientation(tmp_path, up_s):
    write_airbrakes(tmp_path / 'set', 'some', up_s)
    report = airbrakes.measure(tmp_path / 'set', tmp_path)
    for attitude in airbrakes.ATTITUDES:
        figures = report.figures[attitude]['some']
        assert figures['itself_rms'] > 1.0
        assert figures['rest_rms'] < 0.001
        assert figures['motion_rms'] < 0.05
        assert figures['tilt_most'] < 0.5


def test_a_hand_that_turns_too_much_is_said_to_find_no_rest(tmp_path):
    write_airbrakes(tmp_path / 'set', 'some', (0.0, 0.0, 1.0), trembling=0.05)
    report = airbrakes.measure(tmp_path / 'set', tmp_path)
    assert report.figures['estimate']['some'] is None
    assert 'no rest' in report.text[0]
    assert report.figures['rest']['some']['motion_rms'] < 0.01


@pytest.mark.parametrize('kind', [airbrakes, oxford, wrist])
def test_what_is_not_readable_is_said(tmp_path, kind):
    with pytest.raises(RecordingError, match=r'in it; docs/accuracy\.md says how'):
        kind.measure(tmp_path, tmp_path)
    with gzip.open(tmp_path / 'l2-25hz-x_accelerometer.csv.gz', 'wt') as file:
        file.write('what\n')
    with pytest.raises(RecordingError, match='l2-25hz-x'):
        kind.measure(tmp_path, tmp_path)
