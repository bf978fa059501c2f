"""The command: what it prints and writes, and what it says of input it can't use."""

import json
import re

import numpy as np
import pytest

from dead_reckoning.tables import ODOMETRY_COLUMNS
from dead_reckoning.tools.main import main

START_NS = 1_700_000_000_123_456_789
COUNT = 400


def poses(scale=1.0, yaw=0.0):
    """Rows of odometry.csv: a loop of 2 m radius at 100 Hz, turned about the vertical."""
    angle = 2 * np.pi * np.arange(COUNT) / COUNT
    x, y = 2 * scale * (np.cos(angle) - 1), 2 * scale * np.sin(angle)
    c, s = np.cos(yaw), np.sin(yaw)
    heading = angle + np.pi / 2 + yaw
    rows = np.zeros((COUNT, len(ODOMETRY_COLUMNS)))
    rows[:, 1], rows[:, 2] = c * x - s * y, s * x + c * y
    rows[:, 6], rows[:, 7] = np.sin(heading / 2), np.cos(heading / 2)
    rows[:, 11:14] = 0.1
    return rows


def lines(rows, columns=ODOMETRY_COLUMNS):
    each = (','.join(map(repr, row[1:].tolist())) for row in rows)
    stamps = (START_NS + 10_000_000 * k for k in range(len(rows)))
    return [','.join(columns), *(f'{s},{row}' for s, row in zip(stamps, each, strict=True))]


def write(path, lines):
    path.parent.mkdir(exist_ok=True)
    path.write_text('\n'.join(lines) + '\n')
    return path


def step_lines(count=10, length=0.7, delay=0.0):
    return [
        'stamp_ns,step,step_length,distance',
        *(
            f'{START_NS + int(1e9 * (0.5 * k + 0.01 * (k % 3) + delay))},{k},{length},{length * k}'
            for k in range(1, count + 1)
        ),
    ]


@pytest.fixture
def folder(tmp_path):
    write(tmp_path / 'out' / 'odometry.csv', lines(poses(scale=1.01, yaw=1.0)))
    write(tmp_path / 'out' / 'steps.csv', step_lines(delay=0.2))
    return tmp_path / 'out'


@pytest.fixture
def truth(tmp_path):
    return write(tmp_path / 'truth.csv', lines(poses()))


def evaluate(folder, *arguments):
    status = main(['evaluate', str(folder), *map(str, arguments)])
    path = folder / 'evaluation.json'
    return status, json.loads(path.read_text()) if path.exists() else None


def test_estimate_one_percent_too_long(folder, truth, capsys):
    status, evaluation = evaluate(folder, '--truth', truth)
    assert status == 0
    found = evaluation['trajectory']
    assert found['pairs'] == COUNT
    assert found['alignment']['kind'] == 'yaw'
    # A circle 1 % too large about the same middle: 20 mm everywhere.
    assert found['ape']['translation_m']['rmse'] == pytest.approx(0.02)
    assert found['ape']['translation_m']['std'] == pytest.approx(0.0, abs=1e-9)
    assert found['ape']['rotation_deg']['max'] == pytest.approx(0.0, abs=1e-6)
    assert found['rpe']['unit'] == 's'
    assert found['rpe']['translation_m']['rmse'] == pytest.approx(0.02 * 2**0.5, rel=1e-3)
    assert found['path_length_m'] == pytest.approx(1.01 * found['truth']['path_length_m'])
    # From the same start on the way is 1 % too long; σ is 0.1 m.
    expected = np.sqrt(np.mean((0.01 * poses(yaw=1.0)[:, 1] / 0.1) ** 2))
    assert found['error_over_sigma']['x']['rms'] == pytest.approx(expected)
    assert found['error_over_sigma']['x']['within_3_sigma'] == 1.0
    printed = capsys.readouterr().out
    assert '400 pairs of 400 poses and 400 of the truth, aligned by heading' in printed
    assert re.search(r'APE position \[m\] +0\.02 +0\.02', printed)
    assert str(folder / 'evaluation.json') in printed


@pytest.mark.parametrize('align', ['se3', 'none'])
def test_alignment_is_chosen(folder, truth, align):
    found = evaluate(folder, '--truth', truth, '--align', align)[1]['trajectory']
    rmse = found['ape']['translation_m']['rmse']
    assert rmse == pytest.approx(0.02) if align == 'se3' else rmse > 1.0


def test_tum_file_is_a_truth(folder, tmp_path):
    rows = poses()
    stamps = (START_NS + 10_000_000 * np.arange(COUNT)) / 1e9
    tum = ['# timestamp tx ty tz qx qy qz qw']
    tum += [
        f'{t:.9f} ' + ' '.join(map(repr, row[1:8].tolist()))
        for t, row in zip(stamps, rows, strict=True)
    ]
    found = evaluate(folder, '--truth', write(tmp_path / 'truth.tum', tum))[1]['trajectory']
    assert found['pairs'] == COUNT
    assert found['ape']['translation_m']['rmse'] == pytest.approx(0.02)


def test_steps_file_gives_count_timing_and_distance(folder, tmp_path, capsys):
    truth = write(tmp_path / 'true_steps.csv', step_lines(count=12, length=0.75))
    status, evaluation = evaluate(folder, '--truth', truth)
    assert status == 0
    assert evaluation['steps']['estimate'] == 10
    assert evaluation['steps']['error'] == -2
    assert evaluation['steps']['timing']['matched'] == 10
    assert evaluation['steps']['timing']['lag_s'] == pytest.approx(0.2)
    assert evaluation['steps']['timing']['f1'] == pytest.approx(20 / 22)
    assert evaluation['distance_m']['steps']['error'] == pytest.approx(-2.0)
    assert '10 steps within ±0.1 s after a lag of +0.200 s: F1 0.909' in capsys.readouterr().out


def test_counted_steps_and_paced_distance(folder):
    _, evaluation = evaluate(folder, '--steps', 9, '--distance', 7.5)
    assert evaluation['steps']['error'] == 1
    assert 'timing' not in evaluation['steps']
    assert evaluation['distance_m']['steps']['error_percent'] == pytest.approx(-100 * 0.5 / 7.5)
    assert evaluation['distance_m']['path']['estimate'] == pytest.approx(12.66, abs=0.05)
    assert evaluation['trajectory']['loop_closure_m'] < 0.04


def test_steps_without_a_heading_have_a_count_and_a_distance(folder):
    (folder / 'odometry.csv').unlink()
    write(folder / 'pedestrian.csv', [','.join(ODOMETRY_COLUMNS)])
    status, evaluation = evaluate(folder, '--steps', 9, '--distance', 7.5)
    assert status == 0
    assert evaluation['steps']['estimate'] == 10
    assert list(evaluation['distance_m']) == ['steps']
    assert 'trajectory' not in evaluation


def test_walk_without_steps_is_a_walk(folder):
    write(folder / 'steps.csv', ['stamp_ns,step,step_length,distance'])
    _, evaluation = evaluate(folder, '--steps', 0)
    assert evaluation['steps'] == {'truth': 0, 'estimate': 0, 'error': 0, 'error_percent': None}


def spoil(row, column, cell):
    """Return lines of an odometry.csv with a fault; row 1 is the second line."""
    spoilt = lines(poses())
    cells = spoilt[row].split(',')
    cells[column] = cell
    spoilt[row] = ','.join(cells)
    return spoilt


def without(column):
    keep = [k for k, name in enumerate(ODOMETRY_COLUMNS) if name != column]
    return [','.join(line.split(',')[k] for k in keep) for line in lines(poses())]


FAULTS = {
    'missing column': (without('qw'), 'line 1: no column qw'),
    'no known columns': (['stamp_ns,a,b', '1,2,3'], 'neither a column px'),
    'text in a number': (spoil(3, 2, 'east'), "line 4: py is 'east', no finite number"),
    'nan': (spoil(5, 1, 'nan'), "line 6: px is 'nan', no finite number"),
    'infinity': (spoil(5, 1, '-inf'), "line 6: px is '-inf', no finite number"),
    'stamp with a fraction': (spoil(2, 0, '1.5'), "line 3: stamp_ns is '1.5', no whole number"),
    'row cut off': ([*lines(poses())[:9], '17,1.0,2.0'], 'line 10: 3 columns'),
    'backward stamps': ([*lines(poses()), lines(poses())[2]], 'stamps do not increase'),
    'other times': (spoil(1, 0, '5')[:2], 'no stamps in common'),
    'only a header': (lines(poses())[:1], 'holds no poses'),
    'empty': ([], 'holds no poses'),
    'a TUM line too short': (['1.0 2 3 4 0 0 0 1', '2.0 2 3 4 0 0 0'], 'line 2: 7 columns'),
    'a TUM with text': (['1.0 2 3 4 0 0 0 one'], "line 1: qw is 'one'"),
    'prose': (['Dear reader,', 'this is no table.'], 'line 1: 2 columns'),
}


@pytest.mark.parametrize('fault', FAULTS)
def test_truth_that_can_not_be_used_is_named(folder, tmp_path, capsys, fault):
    content, words = FAULTS[fault]
    path = write(tmp_path / 'bad.csv', content)
    status, evaluation = evaluate(folder, '--truth', path)
    printed = capsys.readouterr()
    assert status == 2
    assert evaluation is None
    assert words in printed.err
    assert 'Traceback' not in printed.err
    assert not printed.out


def test_quaternion_of_zeros_is_no_rotation(folder, tmp_path, capsys):
    path = write(tmp_path / 'bad.tum', ['1.0 2 3 4 0 0 0 1', '2.0 2 3 4 0 0 0 0'])
    assert evaluate(folder, '--truth', path)[0] == 2
    assert 'the quaternion of pose 2 is no rotation' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('missing', 'arguments', 'words'),
    [
        ('odometry.csv', ['--truth', 'truth.csv'], 'no odometry.csv or smoothed.csv'),
        ('steps.csv', ['--steps', '3'], 'no steps.csv'),
        (None, ['--truth', 'nowhere.csv'], 'No such file'),
        (None, ['--truth', 'truth.csv', '--track', 'smoothed'], 'no smoothed.csv'),
        (None, ['--truth', 'truth.csv', '--delta', '1000'], '--delta 1000 s is more than'),
        (None, ['--truth', 'truth.csv', '--delta', '1.5', '--delta-unit', 'frames'], 'whole'),
        (None, ['--truth', 'nowhere.bag'], 'no such file'),
        (None, ['--topic', '/odom', '--steps', '1'], 'which is missing'),
        (None, [], 'nothing to compare with'),
        (None, ['--steps', '3', '--output', 'truth.csv/figures.json'], 'truth.csv'),
    ],
)
def test_what_is_missing_is_named(folder, truth, capsys, monkeypatch, missing, arguments, words):
    monkeypatch.chdir(truth.parent)
    if missing:
        (folder / missing).unlink()
    assert evaluate(folder, *arguments)[0] == 2
    assert words in capsys.readouterr().err


def test_no_folder(tmp_path, capsys):
    assert main(['evaluate', str(tmp_path / 'nowhere'), '--steps', '1']) == 2
    assert 'no folder' in capsys.readouterr().err


def test_earlier_figures_stay_where_the_next_ones_fail(folder, truth):
    evaluate(folder, '--truth', truth)
    before = (folder / 'evaluation.json').read_text()
    assert evaluate(folder, '--truth', truth, '--delta', '1000')[0] == 2
    assert (folder / 'evaluation.json').read_text() == before
    assert sorted(path.name for path in folder.iterdir()) == [
        'evaluation.json',
        'odometry.csv',
        'steps.csv',
    ]


@pytest.mark.parametrize('kind', ['Odometry', 'PoseStamped'])
def test_topic_of_a_recording_is_a_truth(folder, tmp_path, kind):
    path = record(tmp_path / 'bag', kind)
    status, evaluation = evaluate(folder, '--truth', path, '--topic', '/truth')
    assert status == 0
    assert evaluation['trajectory']['pairs'] == COUNT
    assert evaluation['trajectory']['ape']['translation_m']['rmse'] == pytest.approx(0.02)
    assert evaluate(folder, '--truth', path, '--topic', '/lies')[0] == 2


def record(path, kind):
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    t = store.types
    name = {'Odometry': 'nav_msgs/msg/Odometry', 'PoseStamped': 'geometry_msgs/msg/PoseStamped'}
    name = name[kind]
    zero = t['geometry_msgs/msg/Vector3'](0.0, 0.0, 0.0)
    with Writer(path, version=9) as writer:
        connection = writer.add_connection('/truth', name, typestore=store)
        for k, row in enumerate(poses()):
            stamp_ns = START_NS + 10_000_000 * k
            stamp = t['builtin_interfaces/msg/Time'](*divmod(stamp_ns, 10**9))
            header = t['std_msgs/msg/Header'](stamp, 'odom')
            pose = t['geometry_msgs/msg/Pose'](
                t['geometry_msgs/msg/Point'](*row[1:4].tolist()),
                t['geometry_msgs/msg/Quaternion'](*row[4:8].tolist()),
            )
            if kind == 'PoseStamped':
                message = t[name](header, pose)
            else:
                message = t[name](
                    header,
                    'base_link',
                    t['geometry_msgs/msg/PoseWithCovariance'](pose, np.zeros(36)),
                    t['geometry_msgs/msg/TwistWithCovariance'](
                        t['geometry_msgs/msg/Twist'](zero, zero), np.zeros(36)
                    ),
                )
            writer.write(connection, stamp_ns, store.serialize_cdr(message, name))
    return path


def test_a_folder_is_no_output(folder, truth, capsys):
    (folder / 'more').mkdir()
    (folder / 'more/precious').write_text('')
    assert evaluate(folder, '--truth', truth, '--output', folder / 'more')[0] == 2
    assert '--output' in capsys.readouterr().err
    assert (folder / 'more/precious').exists()


@pytest.mark.parametrize(
    ('line', 'words'),
    [
        ('1.7e18 0 0 0 0 0 0 1', '1.7e\\+18 is no timestamp in seconds'),
        ('2 1e300 0 0 0 0 0 1', 'pose 2 is at'),
    ],
)
def test_numbers_without_a_meaning_are_refused(folder, tmp_path, capsys, line, words):
    truth = write(tmp_path / 'truth.tum', ['1 0 0 0 0 0 0 1', line])
    assert evaluate(folder, '--truth', truth) == (2, None)
    assert re.search(words, capsys.readouterr().err)
