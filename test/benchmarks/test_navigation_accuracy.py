"""The benchmarks of the inertial navigator, on simulated stand-ins of their recordings."""

import gzip
import sys
from dataclasses import replace
from itertools import pairwise
from math import tau

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks import settings
from benchmarks.accuracy import (
    aided_drives,
    consistency,
    gaitmap,
    gcp,
    inclination,
    openshoe,
    sensors,
    slopes,
    smoothing,
    xio,
)
from benchmarks.accuracy.__main__ import _say_goals
from benchmarks.accuracy.inertial import FOOT, Recording, block_means, in_blocks, landings, live
from benchmarks.accuracy.report import Goal, Report
from benchmarks.accuracy.simulated_walks import walk
from benchmarks.accuracy.trial import Trial
from dead_reckoning.core.errors import GravityError, RecordingError
from dead_reckoning.core.reference import attitude_error
from dead_reckoning.core.rest import GRAVITY

STRIDES = 10
LOOP = walk(strides=STRIDES, turn=tau / STRIDES)
"""Ten strides around a circle, back to where it began."""


def write_npz(path, true, **more):
    path.parent.mkdir(parents=True, exist_ok=True)
    rate = 1.0 / true.time[1]
    np.savez(path, acc_g=true.force / GRAVITY, gyr=true.rate, fs=rate, t=true.time, **more)


def test_a_loop_ends_where_it_began(tmp_path):
    write_npz(tmp_path / 'set' / 'm1.npz', LOOP)
    report = openshoe.measure(tmp_path / 'set', tmp_path)
    for found in report.figures['loops']['m1'].values():
        assert found['strides'] == STRIDES
        assert found['end_percent'] < 0.1
        assert found['way_m'] == pytest.approx(STRIDES * 1.4, rel=0.01)
    of_swings = report.figures['swings']
    assert of_swings['stride by stride']['height_m'] < of_swings['causal']['height_m']
    assert of_swings['smoothed']['height_m'] == of_swings['smoothed']['jumps'] == 0
    assert report.figures['100 Hz']['causal']['worst_percent'] < 0.5
    assert [goal.met for goal in report.goals[:4]] == [True] * 4
    assert report.pictures[0].read_bytes().startswith(b'\x89PNG')


def corners_of(true):
    """Return strides at which the foot stood, and where, in axes of its own: turned, mirrored."""
    at = np.array([0, 3, 5, 8, STRIDES])
    feet = np.array([true.position[round((3.0 + 1.1 * k - 0.1) * 200)] for k in at])
    return at, feet[:, [1, 0]]


def test_corners_are_passed(tmp_path):
    at, corners = corners_of(LOOP)
    more = {'gcp_m': corners, 'gcp_stride': at, 'strides': STRIDES, 'gcp_ok': 1}
    write_npz(tmp_path / 'set' / 'exp1.npz', LOOP, **more)
    report = gcp.measure(tmp_path / 'set', tmp_path)
    assert max(report.figures['corners of exp1']['error_m']) < 0.03
    assert all(goal.met for goal in report.goals)
    write_npz(tmp_path / 'set' / 'exp1.npz', LOOP, **{**more, 'strides': STRIDES + 1})
    wrong = gcp.measure(tmp_path / 'set', tmp_path)
    missed = [goal for goal in wrong.goals if not goal.met]
    assert [(goal.wanted, goal.found) for goal in missed] == [('exact', '-1')]
    write_npz(tmp_path / 'set' / 'exp1.npz', LOOP, **{**more, 'gcp_m': corners[:-1]})
    with pytest.raises(RecordingError, match='not where it began'):
        gcp.measure(tmp_path / 'set', tmp_path)


@pytest.mark.parametrize('mirror', [1.0, -1.0])
def test_corners_are_turned_as_fits_best(mirror):
    corners = np.array([[6.0, 0.0], [6.0, 10.0], [0.0, 10.0], [0.0, 0.0]])
    c, s = np.cos(2.0), np.sin(2.0)
    reached = corners * (1.0, mirror) @ [[c, s], [-s, c]]
    np.testing.assert_allclose(gcp.turned(corners, reached), reached, atol=1e-12)


def test_landings_are_stances_after_a_stride():
    way = live(Recording('', LOOP.time, LOOP.force, LOOP.rate), FOOT)
    found = landings(way.states)
    steps = np.diff(way.states.position[found], axis=0)
    assert np.linalg.norm(steps, axis=1) == pytest.approx(np.full(STRIDES, 1.4), abs=0.05)


def test_blocks_go_the_way_of_samples():
    recording = Recording('', LOOP.time, LOOP.force, LOOP.rate)
    way, live_way = in_blocks(recording, FOOT), live(recording, FOOT)
    np.testing.assert_array_equal(way.states.stamp_ns, live_way.states.stamp_ns)
    np.testing.assert_array_equal(way.states.position, live_way.states.position)
    assert (way.strides, way.length) == (live_way.strides, live_way.length)


def test_block_means_keep_the_integral():
    """A mean over 2.5 samples takes half of one; that of a straight line is its middle."""
    time = np.arange(1000) / 250.0
    line = np.outer(time, (1.0, 2.0, -3.0))
    slow = block_means(Recording('', time, np.ones((1000, 3)), line), 100.0)
    np.testing.assert_allclose(np.diff(slow.time), 0.01)
    np.testing.assert_allclose(slow.force_s, 1.0)
    # Within a sample the signal is that sample, so the middle is met to half a step of 4 ms.
    assert np.abs(slow.turn_s - np.outer(slow.time, (1.0, 2.0, -3.0))).max() < 0.5 * 3.0 * 0.004
    even = block_means(Recording('', time, line, line), 50.0)
    np.testing.assert_allclose(even.turn_s, line.reshape(200, 5, 3).mean(axis=1), atol=1e-12)


def test_swings_are_compared_and_jumps_are_what_velocity_does_not_explain():
    states = live(Recording('', LOOP.time, LOOP.force, LOOP.rate), FOOT).states
    true = smoothing.Reference(
        states.stamp_ns[10:],
        states.position[10:],
        states.velocity[10:],
        ~states.stationary[10:],
    )
    as_it_is = smoothing.swings(states, true).figures()
    moved = states.position.copy()
    moved[-300:] += 0.02  # within the rest at the end
    moved[~states.stationary, 2] += 0.003
    faster = states.velocity + np.where(states.stationary, 0.0, 0.04)[:, None]
    figures = smoothing.swings(replace(states, position=moved, velocity=faster), true).figures()
    assert as_it_is['height_m'] == as_it_is['velocity_m_s'] == 0.0
    assert figures['jumps'] == as_it_is['jumps'] + 1
    assert figures['largest_jump_m'] == pytest.approx(0.02 * 3**0.5, rel=0.05)
    assert figures['height_m'] == pytest.approx(0.003)
    assert figures['velocity_m_s'] == pytest.approx(0.04 * 3**0.5)
    assert figures['sigma_height_m'] == as_it_is['sigma_height_m'] > 0.01


def write_gaitmap(folder):
    """Write both feet as the same straight walk, after 1 s that the cameras do not see."""
    folder.mkdir()
    true = walk(rate=gaitmap.RATE, strides=STRIDES, mounted=np.eye(3))
    seen = walk(rate=gaitmap.CAMERA_RATE, strides=STRIDES).position * 1000.0
    seen[:100] = np.nan

    def write(name, heads, rows):
        lines = [','.join(head) for head in heads]
        lines += [','.join(map(str, row)) for row in rows]
        with gzip.open(folder / f'{name}.csv.gz', 'wt') as file:
            file.write('\n'.join(lines) + '\n')

    sensor = np.hstack((true.force, np.degrees(true.rate)))
    both = np.stack((sensor, sensor), axis=2).reshape(len(sensor), 12)
    head = ['sensor', *(f'{foot}_sensor' for _ in range(6) for foot in gaitmap.FEET)]
    write('imu_sample', [head, head], np.column_stack((np.arange(len(both)), both)))
    head = ['', *(name for name in ('L_FCC', 'R_FCC') for _ in range(3))]
    write('mocap_sample', [head, head], np.column_stack((np.arange(len(seen)), seen, seen)))
    stood = [round((2.9 + 1.1 * k) * gaitmap.RATE) for k in range(STRIDES + 1)]
    strides = [(0, 10), *pairwise(stood), (stood[-1], 10**6)]
    rows = [(k, foot, a, b) for foot in gaitmap.FEET for k, (a, b) in enumerate(strides)]
    write('stride_events_sample', [['s_id', 'foot', 'start', 'end']], rows)


def test_strides_are_measured_where_the_cameras_saw_them(tmp_path):
    write_gaitmap(tmp_path / 'set')
    for foot in gaitmap.FEET:
        found, _ = gaitmap.stride_lengths(tmp_path / 'set', foot)
        assert found['true'] == pytest.approx(np.full(STRIDES, 1.4), abs=1e-6)
        for way in ('causal', 'smoothed'):
            assert found[way] == pytest.approx(found['true'], abs=0.02)
    report = gaitmap.measure(tmp_path / 'set', tmp_path)
    assert all(goal.met for goal in report.goals)
    assert report.figures['both, causal']['rmse_m'] < 0.02


def write_xio(path):
    """Write each sample twice."""
    path.parent.mkdir()
    columns = np.column_stack((LOOP.time, np.degrees(LOOP.rate), LOOP.force / GRAVITY))
    with gzip.open(path, 'wt') as file:
        file.write('time\n')
        np.savetxt(file, np.repeat(columns, 2, axis=0), delimiter=',')


def test_units_and_repeated_samples_of_x_io(tmp_path):
    path = tmp_path / 'xio_gait_tracking' / 'short_walk.csv.gz'
    write_xio(path)
    read = xio.load(path)
    np.testing.assert_allclose(read.force_s[::2], LOOP.force, rtol=1e-12)
    np.testing.assert_allclose(read.turn_s[1::2], LOOP.rate, atol=1e-12)
    report = xio.measure(path, tmp_path)
    assert report.figures['loops']['short_walk']['causal']['end_3d_m'] < 0.02
    assert [goal.met for goal in report.goals] == [True, True]


def test_settings_are_halved_and_doubled(tmp_path, monkeypatch, capsys):
    at, corners = corners_of(LOOP)
    write_npz(tmp_path / 'openshoe' / 'm1.npz', LOOP)
    more = {'gcp_m': corners, 'gcp_stride': at, 'strides': STRIDES, 'gcp_ok': 1}
    write_npz(tmp_path / 'koroglu_gcp' / 'exp1.npz', LOOP, **more)
    write_gaitmap(tmp_path / gaitmap.PATTERN)
    write_xio(tmp_path / 'xio_gait_tracking' / 'short_walk.csv.gz')
    monkeypatch.setattr(settings, 'SETTINGS', ('rest_factor',))
    monkeypatch.setattr(settings, 'OTHERWISE', {'swings are rest': {'shoe.share': 1.0}})
    monkeypatch.setattr(sys, 'argv', ['settings', str(tmp_path)])
    settings.main()
    _, *rows = (line.split() for line in capsys.readouterr().out.splitlines())
    names = [' '.join(row[:-13]) for row in rows]
    assert names == ['default', 'rest_factor × 0.5', 'rest_factor × 2', 'swings are rest']
    assert rows[0][-12:-1:2] == ['×1.00'] * 6
    assert all(float(cell[1:]) > 5.0 for cell in rows[-1][-12:-1:2])
    assert [row[-1] for row in rows] == ['0', '0', '0', '1']


def test_inclination_is_the_angle_between_verticals():
    half = np.radians(5.0)
    turned = np.array([[np.sin(half), 0.0, 0.0, np.cos(half)], [0.0, 0.0, 0.6, 0.8]])
    level = np.tile((0.0, 0.0, 0.0, 1.0), (2, 1))
    found = inclination.angles(inclination.vertical(turned), inclination.vertical(level))
    assert found == pytest.approx([10.0, 0.0])
    assert inclination.windowed(np.array([3.0, np.nan, 4.0, 4.0, 1.0]), 2) == pytest.approx([3, 4])


def test_a_sensor_that_is_late_is_compared_with_the_same_instant():
    """A rate that varies, 1.2 samples late, as that of BROAD is."""
    rate, late = 285.0, 1.2
    time = np.arange(3000) / rate
    axis = np.array([0.6, 0.0, 0.8])

    def angle(t):
        return np.sin(2.0 * t) + 0.5 * np.sin(5.0 * t)

    attitude = Rotation.from_rotvec(angle(time)[:, None] * axis).as_quat()
    attitude[100:110] = np.nan
    sensed = time - late / rate
    turn = (2.0 * np.cos(2.0 * sensed) + 2.5 * np.cos(5.0 * sensed))[:, None] * axis + 0.01
    still = np.zeros((len(time), 3))
    trial = Trial(rate, still, turn, attitude, still, time > 1.0)
    assert inclination.lateness(trial) == pytest.approx(late, rel=0.02)
    found = inclination.vertical(Rotation.from_rotvec(angle(sensed)[:, None] * axis).as_quat())
    errors = inclination.angles(inclination.later(found, late), inclination.vertical(attitude))
    assert np.nanmax(errors[:-2]) < 0.01


def test_a_held_sensor_without_vqf(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'vqf', None)
    random = np.random.default_rng(0)
    count, rate = 2000, 100.0
    np.savez(
        tmp_path / '1_still.npz',
        fs=rate,
        acc=random.normal((0.0, 0.0, GRAVITY), 0.01, (count, 3)),
        gyr=random.normal(0.0, 0.001, (count, 3)),
        quat_wxyz_enu=np.tile((1.0, 0.0, 0.0, 0.0), (count, 1)),
        pos=np.zeros((count, 3)),
        movement=np.arange(count) > 1000,
    )
    report = inclination.measure(tmp_path / '1_still.npz', tmp_path)
    assert report.figures['causal']['motion_rmse_deg'] < 0.1
    assert 'not installed' in report.text[0]
    assert [goal.met for goal in report.goals] == [True, None, True, None]


def test_simulations_report_what_they_find(tmp_path, monkeypatch):
    monkeypatch.setattr(consistency, 'RUNS', 2)
    report = consistency.measure(tmp_path)
    told, _, driven, by_default = report.figures.values()
    assert 0.1 < told['position'] < 10.0
    assert 0.1 < driven['position'] < 10.0
    assert by_default['position'] < 0.5
    assert len(report.goals) == 5
    monkeypatch.setattr(slopes, 'SEEDS', 1)
    monkeypatch.setattr(slopes, 'SLOPES', dict([*slopes.SLOPES.items()][:1]))
    (found,) = slopes.measure(tmp_path).figures['worst_percent'].values()
    assert 0.0 < found['causal'] < 3.0
    monkeypatch.setattr(smoothing, 'SEEDS', 1)
    monkeypatch.setattr(smoothing, 'COUNT', 6)
    report = smoothing.measure(tmp_path)
    (goal,) = report.goals
    assert goal.met
    of_swings = report.figures['swings']
    assert of_swings['smoothed']['height_m'] < 0.5 * of_swings['causal']['height_m'] < 0.005
    assert of_swings['smoothed']['largest_jump_m'] < 1e-3 < of_swings['causal']['largest_jump_m']
    assert report.pictures[0].exists()
    monkeypatch.setattr(sensors, 'SEEDS', 1)
    report = sensors.measure(tmp_path)
    assert [goal.met for goal in report.goals] == [True, True, True]
    assert len(report.figures['rest_missed_percent']) == 12


def test_aided_drives_report_what_they_find(tmp_path, monkeypatch):
    monkeypatch.setattr(aided_drives, 'RUNS', 1)
    monkeypatch.setattr(aided_drives, 'AIDS', dict(list(aided_drives.AIDS.items())[:1]))
    angles = dict(list(attitude_error.ACCELERATIONS.items())[:1])
    monkeypatch.setattr(attitude_error, 'ACCELERATIONS', angles)
    report = aided_drives.measure(tmp_path)
    tilt, outage, *_, table = report.goals
    assert tilt.met
    assert outage.met
    assert table.met
    assert 0.05 < report.figures['anees']['attitude'] < 5.0
    assert all(picture.exists() for picture in report.pictures)


def test_goals_are_told_apart(capsys):
    goals = [Goal('one', '≤ 1', '0', True), Goal('two', '', '9', False), Goal('c', '', '', None)]
    _say_goals([Report('', '', goals=goals), Report('', '')])
    lines = capsys.readouterr().out.split('\n')
    assert [line.split()[-1] for line in lines[3:6]] == ['met', 'missed', 'open']
    _say_goals([Report('', '')])
    assert capsys.readouterr().out == ''


@pytest.mark.parametrize('kind', [openshoe, gcp])
def test_what_is_not_there_is_said(tmp_path, kind):
    with pytest.raises(RecordingError, match=r'in it; docs/accuracy\.md says how'):
        kind.measure(tmp_path, tmp_path)
    np.savez(tmp_path / 'half.npz', gyr=np.zeros((5, 3)))
    with pytest.raises(RecordingError, match=r'half\.npz: no .*acc_g'):
        kind.measure(tmp_path, tmp_path)


def test_what_is_not_readable_is_said(tmp_path):
    with pytest.raises(RecordingError, match='imu_sample'):
        gaitmap.measure(tmp_path, tmp_path)
    with gzip.open(tmp_path / 'imu_sample.csv.gz', 'wt') as file:
        file.write('what\nelse\n')
    with pytest.raises(RecordingError, match='no left_sensor'):
        gaitmap.measure(tmp_path, tmp_path)
    path = tmp_path / 'walk.csv.gz'
    with gzip.open(path, 'wt') as file:
        file.write('what\n1,2\n')
    with pytest.raises(RecordingError, match='columns instead of 7'):
        xio.load(path)
    force = np.random.default_rng(0).normal((0.0, 0.0, GRAVITY), 3.0, (200, 3))
    shaken = Recording('shaken', np.arange(200) / 100.0, force, np.zeros((200, 3)))
    with pytest.raises(RecordingError, match='shaken: no rest'):
        live(shaken, FOOT)
    weightless = Recording('', shaken.time, np.zeros((200, 3)), shaken.turn_s)
    with pytest.raises(GravityError, match='the specific force is 0'):
        live(weightless, FOOT)
