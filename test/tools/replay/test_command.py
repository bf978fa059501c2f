"""The command `replay`: several inputs, exit status, and wrong input in one line."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress

import pytest
from replay_recordings import STEPS, walk, write_bag, write_table

from dead_reckoning.core import kernels
from dead_reckoning.core.errors import DependencyError, InputError
from dead_reckoning.core.stages import RAW
from dead_reckoning.tools.main import main
from dead_reckoning.tools.replay import many


def flow(samples):
    return [(RAW, sample) for sample in samples]


@pytest.fixture
def bag(tmp_path):
    return write_bag(tmp_path / 'walk', flow(walk()))


def replay(*arguments):
    return main(['replay', *map(str, arguments)])


def refused(capsys, output, *arguments):
    """Return what is said of wrong input: one line, status 2, and no output."""
    before = sorted(output.rglob('*')) if output.is_dir() else output.exists()
    try:
        status = replay(*arguments, '--output', output)
    except SystemExit as end:
        status = end.code
    out, err = capsys.readouterr()
    assert (status, out) == (2, '')
    assert 'Traceback' not in err
    assert (sorted(output.rglob('*')) if output.is_dir() else output.exists()) == before
    return err


def test_one_input_goes_right_into_the_folder(tmp_path, capsys, bag, config):
    assert replay(bag, '--config', config(), '--output', tmp_path / 'out') == 0
    out, err = capsys.readouterr()
    head, line = out.splitlines()
    assert head.split() == [
        'input', 'samples', 'duration', 'steps', 'strides', 'distance', 'path', 'end', 'position',
        'dropped', 'took',
    ]  # fmt: skip
    assert line.split()[:5] == [str(bag), str(len(walk())), '7.8', 's', str(STEPS)]
    assert 'NotLevelledError' in err
    assert '\r' not in err, 'there is no bar where nobody looks'
    summary = json.loads((tmp_path / 'out/summary.json').read_text())
    assert summary['steps'] == STEPS


@pytest.mark.parametrize('jobs', [1, 2])
def test_of_many_inputs_those_that_can_be_used_are(tmp_path, capsys, config, jobs):
    inputs = [
        write_bag(tmp_path / 'a/walk', flow(walk())),
        write_bag(tmp_path / 'broken', flow(walk())),
        write_table(tmp_path / 'walk.csv', walk(2)),
    ]
    file = inputs[1] / 'broken.mcap'
    file.write_bytes(file.read_bytes()[:5000])
    options = ['--config', config(), '--outputs', 'summary', '--jobs', jobs]
    assert replay(*inputs, *options, '--output', tmp_path / 'out') == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:]] == [str(path) for path in inputs]
    assert 'reindex' in lines[2]
    assert lines[2].count(str(inputs[1])) == 1
    assert sorted(path.name for path in (tmp_path / 'out').iterdir()) == ['walk', 'walk-2']
    for name, path in (('walk', inputs[0]), ('walk-2', inputs[2])):
        assert replay(path, *options, '--output', tmp_path / 'alone') == 0
        summary = (tmp_path / 'alone/summary.json').read_text()
        assert (tmp_path / 'out' / name / 'summary.json').read_text() == summary


def test_folders_have_a_name_each(tmp_path):
    inputs = [tmp_path / name for name in ('a/x.bag', 'b/x.bag', 'x-2.csv', 'y.csv')]
    folders = many.folders(inputs, tmp_path)
    assert [folder.name for folder in folders] == ['x', 'x-2', 'x-2-2', 'y']
    assert many.folders(inputs[:1], tmp_path) == [tmp_path]


def test_a_cluster_replays_them_too(tmp_path, capsys, config):
    distributed = pytest.importorskip('distributed', reason='Dask is not installed')
    inputs = [write_bag(tmp_path / name, flow(walk(seed))) for seed, name in enumerate('ab')]
    (tmp_path / 'c').mkdir()
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None
    ) as cluster:
        assert (
            replay(
                *inputs, tmp_path / 'c', '--config', config(), '--output', tmp_path / 'out',
                '--outputs', 'summary', '--scheduler', cluster.scheduler_address,
            )
            == 1
        )  # fmt: skip
    lines = capsys.readouterr().out.splitlines()
    assert 'metadata.yaml' in lines[3]
    for name in 'ab':
        summary = json.loads((tmp_path / 'out' / name / 'summary.json').read_text())
        assert summary['steps'] == STEPS


def test_without_dask_it_is_said_what_to_install(tmp_path, capsys, bag, config, monkeypatch):
    monkeypatch.setitem(sys.modules, 'distributed', None)
    options = ['--config', config(), '--output', tmp_path / 'out', '--scheduler', 'tcp://x:1']
    assert replay(bag, *options) == 1
    assert 'pip install distributed' in capsys.readouterr().err


def test_without_dask_there_is_no_executor(monkeypatch):
    monkeypatch.setitem(sys.modules, 'distributed', None)
    with pytest.raises(DependencyError), many.executor(1, 'tcp://x:1'):
        pass


@pytest.mark.parametrize(
    ('content', 'words'),
    [
        ('', 'line 1: no header'),
        ('1,2,3\n', 'line 1: no header'),
        ('stamp_ns,ax,ay,az\n', 'no line after the header'),
        ('stamp_ns,ax,az\n1,2,3\n', 'line 1: no column ay'),
        ('ax,ay,az\n1,2,3\n', 'give a --rate'),
        ('stamp_ns,ax,ay,az\n1,0,0,9.8\n2,0,zero,9.8\n', "line 3: ay is 'zero'"),
        ('stamp_ns,ax,ay,az\n1,0,,9.8\n', 'line 2: ay is empty'),
        ('stamp_ns,ax,ay,az\n1,0,0,9.8\n2,0,0\n', 'line 3: .* has 3 columns, not 4'),
    ],
)
def test_a_table_that_can_not_be_read_is_refused(tmp_path, capsys, config, content, words):
    import re

    path = tmp_path / 'table.csv'
    path.write_text(content)
    said = refused(capsys, tmp_path / 'out', path, '--config', config())
    assert str(path) in said
    assert re.search(words, said)


def test_a_truncated_bag_is_refused(tmp_path, capsys, bag, config):
    file = bag / 'walk.mcap'
    whole = file.read_bytes()
    for part in (0.0, 0.01, 0.4, 0.99):
        file.write_bytes(whole[: int(part * len(whole))])
        assert 'reindex' in refused(capsys, tmp_path / 'out', bag, '--config', config())


def test_what_is_no_recording_is_refused(tmp_path, capsys, config):
    (tmp_path / 'folder').mkdir()
    (tmp_path / 'file.txt').write_text('')
    for name, words in (
        ('folder', 'without metadata.yaml'),
        ('file.txt', 'no recording'),
        ('nowhere', 'no such file'),
        ('nowhere.csv', 'No such file'),
    ):
        said = refused(capsys, tmp_path / 'out', tmp_path / name, '--config', config())
        assert words in said


def test_a_topic_that_is_not_there_is_refused(tmp_path, capsys, bag, config):
    options = ['--config', config(), '--imu', '/other']
    said = refused(capsys, tmp_path / 'out', bag, *options)
    assert '--imu /other is not in it; there is /imu/data_raw' in said


def test_wrong_settings_are_refused_as_by_the_nodes(tmp_path, capsys, bag, config):
    said = refused(capsys, tmp_path / 'out', bag, '--config', config(**{'gravity.atitude': 'x'}))
    assert "gravity.atitude: no such parameter; did you mean 'gravity.attitude'?" in said
    said = refused(capsys, tmp_path / 'out', bag, '--config', tmp_path / 'nowhere.yaml')
    assert 'nowhere.yaml' in said
    said = refused(capsys, tmp_path / 'out', bag, '--config', config(**{'frames.mounting': 'tf'}))
    assert 'frames.mounting' in said


@pytest.mark.parametrize(
    'options', [['--rate', 'x'], ['--rate', '0'], ['--jobs', '0'], ['--outputs', 'x'], []]
)
def test_wrong_options_are_refused(tmp_path, capsys, bag, config, options):
    config_option = ['--config', config()] if options else []
    assert refused(capsys, tmp_path / 'out', bag, *config_option, *options)


@pytest.mark.parametrize(
    'options', [['--outputs', 'x'], ['--outputs', 'smoothed'], ['--config', 'nowhere.yaml']]
)
def test_what_is_wrong_for_all_is_said_once(tmp_path, capsys, bag, config, options):
    said = refused(capsys, tmp_path / 'out', bag, bag, '--config', config(), *options)
    assert said.count(options[0]) == 1


def test_without_numba_it_says_so_once_and_gives_the_same(
    tmp_path, capsys, bag, config, monkeypatch
):
    options = ['--config', config(), '--outputs', 'summary']
    assert replay(bag, *options, '--output', tmp_path / 'fast') == 0
    assert 'numba is not there' not in capsys.readouterr().err
    monkeypatch.setattr(kernels, '_numba', lambda: None)
    assert replay(bag, bag, *options, '--output', tmp_path / 'slow') == 0
    assert capsys.readouterr().err.count('numba is not there') == 1
    fast, slow = (
        json.loads((tmp_path / folder / 'summary.json').read_text())
        for folder in ('fast', 'slow/walk')
    )
    for name in ('distance_m', 'path_length_m', 'end_position_m'):
        assert slow.pop(name) == pytest.approx(fast.pop(name), abs=1e-9)
    assert slow == fast


def test_a_folder_that_can_not_be_written_is_refused(tmp_path, capsys, bag, config):
    output = tmp_path / 'out'
    output.write_text('a file')
    said = refused(capsys, output, bag, '--config', config())
    assert '--output' in said
    assert output.read_text() == 'a file'


def test_no_scheduler_is_said(tmp_path):
    pytest.importorskip('distributed', reason='Dask is not installed')
    with pytest.raises(InputError, match='--scheduler'), many.executor(1, 'nonsense://x'):
        pass


@pytest.fixture
def begun(tmp_path, config):
    """Begin to replay long recordings in a session of its own."""
    samples = walk()
    later = round(8e9)
    bags = []
    for name in ('a', 'b', 'c'):
        long = [
            type(s)(s.stamp_ns + k * later, s.frame_id, s.specific_force)
            for k in range(60)
            for s in samples
        ]
        bags.append(write_bag(tmp_path / name, flow(long)))
    output = tmp_path / 'out'
    command = [sys.executable, '-m', 'dead_reckoning.tools.main', 'replay', *map(str, bags)]
    command += ['--config', str(config()), '--output', str(output), '--jobs']

    def begin(jobs):
        process = subprocess.Popen(
            [*command, str(jobs)],
            stderr=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        deadline = time.monotonic() + 30.0
        while not list(output.glob('*/.dead-reckoning-*/odometry.csv')):
            assert time.monotonic() < deadline
            assert process.poll() is None
            time.sleep(0.02)
        return process

    return begin


def wait_for_the_last_of(session):
    """Fail where a process of a session goes on."""
    deadline = time.monotonic() + 10.0
    with suppress(ProcessLookupError):
        while True:
            os.killpg(session, 0)
            assert time.monotonic() < deadline
            time.sleep(0.02)


@pytest.mark.parametrize(
    ('jobs', 'end', 'all_hear'),
    [
        (1, signal.SIGINT, True),
        (1, signal.SIGTERM, False),
        (2, signal.SIGINT, True),
        (2, signal.SIGINT, False),
        (2, signal.SIGTERM, True),
    ],
)
def test_who_ends_it_finds_nothing_half_done(tmp_path, begun, jobs, end, all_hear):
    process = begun(jobs)
    (os.killpg if all_hear else os.kill)(process.pid, end)
    out, err = process.communicate(timeout=30.0)
    assert process.returncode == 128 + end
    assert 'Traceback' not in out + err
    assert err.strip() == ('interrupted' if end == signal.SIGINT else '')
    assert not list((tmp_path / 'out').glob('*/.*'))
    wait_for_the_last_of(process.pid)


def test_workers_end_with_a_parent_that_was_killed(begun):
    process = begun(2)
    process.kill()
    process.communicate(timeout=30.0)
    wait_for_the_last_of(process.pid)
