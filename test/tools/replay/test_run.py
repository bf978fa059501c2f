"""One recording through the chain: the numbers of the streaming chain, in files that are whole."""

import csv
import json

import numpy as np
import pytest
from replay_recordings import (
    STEPS,
    WALKING,
    dropped,
    headings,
    spoiled,
    streamed,
    walk,
    without_covariance,
    write_bag,
    write_table,
)
from rosbags.interfaces import QosDurability
from rosbags.rosbag2 import Reader

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import InputError, RecordingError
from dead_reckoning.core.stages import ACCELERATION, IMU, ODOMETRY, RAW, STEP, STEP_ODOMETRY
from dead_reckoning.tables import ODOMETRY_COLUMNS, odometry_row
from dead_reckoning.tools.replay import run as replay
from dead_reckoning.tools.replay.outputs.odometry import seconds
from dead_reckoning.tools.replay.run import Job, run
from dead_reckoning.topics import topics

TABLES = ('odometry.csv', 'odometry.tum', 'pedestrian.csv', 'steps.csv', 'summary.json')


def job(path, folder, wanted=('bag', 'odometry', 'steps', 'summary'), **settings):
    options = {name: settings.pop(name) for name in ('imu', 'rate') if name in settings}
    return Job(path, folder, Configuration(WALKING | settings), wanted, **options)


def raw(samples):
    return [(RAW, sample) for sample in samples]


def rows(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def numbers(path, columns):
    return np.array([[float(row[name]) for name in columns] for row in rows(path)])


def stamps(path):
    return [int(row['stamp_ns']) for row in rows(path)]


def check_states(path, states):
    expected = [odometry_row(state) for state in states]
    assert stamps(path) == [state.stamp_ns for state in states]
    np.testing.assert_allclose(
        numbers(path, ODOMETRY_COLUMNS[1:]),
        np.array(expected, dtype=float)[:, 1:],
        rtol=0.0,
        atol=1e-9,
    )


@pytest.mark.parametrize('kind', ['mcap', 'sqlite3', 'ros1', 'csv'])
def test_states_and_steps_are_those_of_the_streaming_chain(tmp_path, kind):
    samples = walk()
    if kind == 'csv':
        samples = without_covariance(samples)
        path = write_table(tmp_path / 'walk.csv', samples)
    else:
        path = write_bag(tmp_path / 'walk', raw(samples), kind)
    outputs = streamed(raw(samples))
    run(job(path, tmp_path / 'out'))
    check_states(tmp_path / 'out/odometry.csv', [state for _, state in outputs[ODOMETRY]])
    expected = [state for _, state in outputs[STEP]]
    assert len(expected) == STEPS
    assert stamps(tmp_path / 'out/steps.csv') == [state.stamp_ns for state in expected]
    np.testing.assert_allclose(
        numbers(tmp_path / 'out/steps.csv', ('step', 'step_length', 'distance')),
        [(state.steps, state.step_length, state.distance) for state in expected],
        rtol=0.0,
        atol=1e-9,
    )


def test_steps_walk_along_the_compass(tmp_path):
    flow = list(headings(walk()))
    path = write_bag(tmp_path / 'walk', flow)
    run(job(path, tmp_path / 'out'))
    outputs = streamed(flow)
    states = [state for _, state in outputs[STEP_ODOMETRY]]
    assert len(states) == STEPS
    check_states(tmp_path / 'out/pedestrian.csv', states)
    check_states(tmp_path / 'out/odometry.csv', [state for _, state in outputs[ODOMETRY]])


def test_tum_holds_the_same_poses(tmp_path):
    run(job(write_bag(tmp_path / 'walk', raw(walk())), tmp_path / 'out'))
    lines = (tmp_path / 'out/odometry.tum').read_text().splitlines()
    table = rows(tmp_path / 'out/odometry.csv')
    assert len(lines) == len(table) > 500
    for line, row in zip(lines, table, strict=True):
        time, *pose = line.split(' ')
        seconds, fraction = time.split('.')
        assert len(fraction) == 9
        assert int(seconds) * 10**9 + int(fraction) == int(row['stamp_ns'])
        assert pose == [row[name] for name in ('px', 'py', 'pz', 'qx', 'qy', 'qz', 'qw')]


def test_seconds_have_nine_decimals():
    stamps = ['1700000000123456789', '-1700000000123456789', '10000000000', '-1000000001']
    wanted = ['1700000000.123456789', '-1700000000.123456789', '10.000000000', '-1.000000001']
    assert seconds(stamps) == wanted
    stamps += ['1', '-1', '999999999', '-1000000000']
    wanted += ['0.000000001', '-0.000000001', '0.999999999', '-1.000000000']
    assert seconds(stamps) == wanted


def test_summary_says_what_the_tables_do(tmp_path):
    samples = spoiled(walk())
    run(job(write_bag(tmp_path / 'walk', raw(samples)), tmp_path / 'out'))
    summary = json.loads((tmp_path / 'out/summary.json').read_text())
    assert list(summary) == [
        'samples', 'duration_s', 'rate_hz', 'steps', 'strides', 'distance_m', 'path_length_m',
        'end_position_m', 'stationary_fraction', 'dropped',
    ]  # fmt: skip
    table, steps = rows(tmp_path / 'out/odometry.csv'), rows(tmp_path / 'out/steps.csv')
    position = numbers(tmp_path / 'out/odometry.csv', ('px', 'py', 'pz'))
    path = np.linalg.norm(np.diff(position, axis=0), axis=1).sum()
    assert summary['samples'] == len(samples)
    assert summary['duration_s'] == (samples[-1].stamp_ns - samples[0].stamp_ns) / 1e9
    assert summary['rate_hz'] == pytest.approx(100.0, rel=0.01)
    assert summary['steps'] == len(steps) == int(steps[-1]['step'])
    assert summary['strides'] == len(steps) // 2
    assert summary['distance_m'] == float(steps[-1]['distance'])
    assert summary['path_length_m'] == pytest.approx(path, rel=1e-12)
    assert summary['end_position_m'] == [float(table[-1][name]) for name in ('px', 'py', 'pz')]
    fraction = np.mean([int(row['stationary']) for row in table])
    assert summary['stationary_fraction'] == pytest.approx(fraction, rel=1e-12)
    assert summary['dropped'] == dropped(streamed(raw(samples)))
    assert summary['dropped'].keys() >= {
        'NotFiniteError', 'LateSampleError', 'RepeatedStampError', 'ZeroStampError'
    }  # fmt: skip


def test_what_is_not_estimated_is_null(tmp_path):
    path = write_bag(tmp_path / 'walk', raw(walk()))
    run(job(path, tmp_path / 'out', None, **{'pipeline.estimators': ('pedometer',)}))
    summary = json.loads((tmp_path / 'out/summary.json').read_text())
    assert summary['steps'] == STEPS
    assert summary['stationary_fraction'] is summary['path_length_m'] is None
    assert not (tmp_path / 'out/odometry.csv').exists()


def test_the_bag_has_the_bytes_of_the_live_nodes(tmp_path):
    flow = list(headings(walk()))
    run(job(write_bag(tmp_path / 'walk', flow, namespace='/robot/'), tmp_path / 'out'))
    spoken = topics(Configuration(WALKING)[FrameSettings])
    expected = {
        name: [spoken[name].encode(value) for _, value in outputs]
        for name, outputs in streamed(flow).items()
        if name in spoken
    }
    found = {name: [] for name in expected}
    with Reader(tmp_path / 'out/bag') as reader:
        latched = {
            connection.topic
            for connection in reader.connections
            for qos in connection.ext.offered_qos_profiles
            if qos.durability == QosDurability.TRANSIENT_LOCAL
        }
        last = 0
        for connection, time_ns, data in reader.messages():
            name = connection.topic.removeprefix('/robot/')
            assert connection.msgtype == spoken[name].type
            assert time_ns >= last
            last = time_ns
            if spoken[name].encode_block is not None:
                sec, nanosec = np.frombuffer(data, '<u4', 2, 4).tolist()
                assert time_ns == sec * 10**9 + nanosec
            found[name].append(data)
    assert {name for name in spoken if spoken[name].latched and name in expected} == {
        topic.removeprefix('/robot/') for topic in latched
    }
    for name, messages in expected.items():
        assert len(found[name]) == len(messages) > 0
        check_bytes(name, found[name], messages)


DOUBLES = {IMU: 37, ACCELERATION: 42, ODOMETRY: 85, STEP_ODOMETRY: 85}


def check_bytes(name, found, expected):
    """Compare messages: all of their bytes but the doubles, and those to within 1e-9."""
    begin = -8 * DOUBLES.get(name, 0) or None
    assert [data[:begin] for data in found] == [data[:begin] for data in expected]
    if begin is not None:
        np.testing.assert_allclose(
            [np.frombuffer(data[begin:]) for data in found],
            [np.frombuffer(data[begin:]) for data in expected],
            rtol=1e-9,
            atol=1e-9,
        )


def test_a_table_is_a_source_whose_samples_are_in_the_bag(tmp_path):
    path = write_table(tmp_path / 'walk.csv', walk())
    run(job(path, tmp_path / 'out', ('bag',)))
    with Reader(tmp_path / 'out/bag') as reader:
        counts = {c.topic: c.msgcount for c in reader.connections}
    assert counts['/imu/data_raw'] == len(walk())
    assert set(counts) >= {'/imu/data', '/odom', '/stationary', '/pedometer/steps'}


def test_what_is_left_out_is_said(tmp_path):
    path = write_bag(tmp_path / 'walk', raw(walk()))
    with pytest.raises(InputError, match='no such output; there are bag, odometry'):
        run(job(path, tmp_path / 'out', ('summary', 'trajectory')))
    with pytest.raises(InputError, match='--outputs steps: nothing gives pedometer/steps'):
        run(job(path, tmp_path / 'out', ('steps',), **{'pipeline.estimators': ('integrator',)}))
    assert not (tmp_path / 'out').exists()


def test_only_what_is_asked_for_is_written(tmp_path):
    path = write_bag(tmp_path / 'walk', raw(walk()))
    run(job(path, tmp_path / 'out', ('summary',)))
    assert [p.name for p in (tmp_path / 'out').iterdir()] == ['summary.json']


def test_another_replay_replaces_all_of_it(tmp_path):
    path = write_bag(tmp_path / 'walk', raw(walk()))
    run(job(path, tmp_path / 'out'))
    before = contents(tmp_path / 'out')
    assert set(before) >= {*TABLES, 'bag/metadata.yaml', 'bag/bag.mcap'}
    run(job(path, tmp_path / 'out'))
    assert contents(tmp_path / 'out') == before
    run(job(write_bag(tmp_path / 'other', raw(walk(2))), tmp_path / 'out'))
    after = contents(tmp_path / 'out')
    assert after.keys() == before.keys()
    assert after['odometry.csv'] != before['odometry.csv']
    assert after['bag/bag.mcap'] != before['bag/bag.mcap']


def contents(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob('*')
        if path.is_file()
    }


@pytest.mark.parametrize('problem', [KeyboardInterrupt, RecordingError, OSError(28, 'full')])
def test_what_breaks_off_leaves_nothing_behind(tmp_path, monkeypatch, problem):
    path = write_bag(tmp_path / 'walk', raw(walk()))
    run(job(path, tmp_path / 'before'))
    before = contents(tmp_path / 'before')
    flow = replay.flow

    def broken(*arguments):
        yield from flow(*arguments)
        raise problem

    monkeypatch.setattr(replay, 'flow', broken)
    expected = InputError if isinstance(problem, OSError) else problem
    for folder in ('before', 'new'):
        with pytest.raises(expected):
            run(job(path, tmp_path / folder))
    assert contents(tmp_path / 'before') == before
    assert not (tmp_path / 'new').exists()


def test_a_recording_is_not_replaced_by_what_comes_of_it(tmp_path):
    folder = tmp_path / 'out'
    run(job(write_table(tmp_path / 'walk.csv', walk()), folder, ('bag',)))
    with pytest.raises(InputError, match='would be replaced'):
        run(job(folder / 'bag', folder, ('bag',)))
    with pytest.raises(InputError, match='would be replaced'):
        run(job(folder / 'bag/bag.mcap', folder, ('bag',)))


def test_a_folder_that_no_replay_wrote_is_not_replaced(tmp_path):
    path = write_table(tmp_path / 'walk.csv', walk())
    precious = tmp_path / 'out/bag/bag_0.mcap'
    precious.parent.mkdir(parents=True)
    precious.write_text('precious')
    with pytest.raises(InputError, match='would be replaced'):
        run(job(path, tmp_path / 'out'))
    assert contents(tmp_path / 'out') == {'bag/bag_0.mcap': b'precious'}


def test_a_message_that_is_none_costs_that_message(tmp_path):
    flow = raw(walk())
    path = write_bag(tmp_path / 'walk', [*flow[:300], (RAW, b'\0\1\0\0no Imu'), *flow[300:]])
    result = run(job(path, tmp_path / 'out', ('summary',)))
    assert result.figures['samples'] == len(flow)
    assert result.figures['dropped']['WireError'] == 1


def test_a_restart_is_no_jump(tmp_path):
    """A bag that was recorded while another was looped: the way goes on from the origin."""
    samples = walk()
    alone = run(job(write_bag(tmp_path / 'one', raw(samples)), tmp_path / '1', ('summary',)))
    twice = run(
        job(write_bag(tmp_path / 'two', raw([*samples, *samples])), tmp_path / '2', ('summary',))
    )
    assert twice.faults['RestartError'].count == 3  # gravity removal, integrator, pedometer
    assert twice.figures['duration_s'] == pytest.approx(2.0 * alone.figures['duration_s'])
    assert twice.figures['path_length_m'] == pytest.approx(2.0 * alone.figures['path_length_m'])
