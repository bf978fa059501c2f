"""The command `reference`: what it prints, and that wrong input prints nothing."""

import os
import subprocess
import sys

import pytest

from dead_reckoning.tools.main import main
from dead_reckoning.tools.reference.programs import programs

REST = ['128,100'] * 1024
SLIDE = ['148,80'] * 128
MBED = {
    '--calibration-count': '2',
    '--sample-count': '2',
    '--window-min': '-3',
    '--window-max': '5',
    '--gain': '0.1',
    '--update-time': '0.5',
    '--no-movement': '5',
}


@pytest.fixture
def table(tmp_path):
    def make(lines):
        path = tmp_path / 'counts.csv'
        path.write_text('\n'.join(lines) + '\n')
        return str(path)

    return make


def options(changed):
    return [f'{name}={value}' for name, value in (MBED | changed).items()]


def printed(capsys, *arguments):
    assert main(['reference', *arguments]) == 0
    return capsys.readouterr().out.splitlines()


def refused(capsys, *arguments):
    """Return what is said of wrong input, which ends with status 2 and prints nothing."""
    try:
        status = main(['reference', *arguments])
    except SystemExit as end:
        status = end.code
    out, err = capsys.readouterr()
    assert (status, out) == (2, '')
    return err


def test_an3397_prints_a_row_per_update(capsys, table):
    expected = [
        'ax,ay,vx,vy,px,py,frame',
        '20,-20,10,-10,5,-5,03110000 0101fe'.replace(' ', ''),
        # The leak: (64 · 80 - 20) >> 6 = 79.
        '20,-21,30,-31,25,-26,03110000 0101fe'.replace(' ', ''),
    ]
    assert printed(capsys, 'an3397', table(REST + SLIDE)) == expected
    assert printed(capsys, 'an3397', table(['x,y', *REST, *SLIDE, '1,1'])) == expected


def test_an3397_corrected_has_no_leak(capsys, table):
    rows = printed(capsys, 'an3397', '--corrected', table(REST + SLIDE))
    assert rows[2].startswith('20,-20,30,-30,25,-25,')


def test_an3397_takes_shift_and_end_of_frame(capsys, table):
    path = table(REST + SLIDE)
    rows = printed(capsys, 'an3397', '--shift', '23', '--end-of-frame', '0x0A', path)
    # 25 · 2^23 is 12.5 · 2^24; -26 · 2^23 is -13 · 2^24.
    assert rows[2] == '20,-21,30,-31,25,-26,03110c0d01010a'


@pytest.mark.parametrize(
    ('lines', 'words'),
    [
        ([*REST, '256,0', *SLIDE], 'line 1025: x is 256, outside 0 to 255'),
        (['x,y', *REST, '1,-1', *SLIDE], 'line 1026: y is -1, outside 0 to 255'),
        ([*REST, 'rest,1'], "line 1025: x is 'rest', which is no whole number"),
        (REST, 'line 1024: ends after 1024 rows; at least 1088 are needed'),
        ([], 'line 1: '),
    ],
)
def test_an3397_refuses(capsys, table, lines, words):
    path = table(lines)
    assert f'{path}, {words}' in refused(capsys, 'an3397', path)


@pytest.mark.parametrize(
    'wrong',
    [('--shift', '32'), ('--shift', '-1'), ('--end-of-frame', '256'), ('--end-of-frame', 'FE')],
)
def test_an3397_refuses_options(capsys, table, wrong):
    assert f'{wrong[0]}: {wrong[1]}' in refused(
        capsys, 'an3397', *wrong, table(REST + SLIDE)
    ).replace("'", '')


def test_mbed_prints_a_row_per_update(capsys, table):
    path = table(['x', '1', '1', '8', '8', '4', '4', '9'])
    rows = printed(capsys, 'mbed', *options({}), path)
    assert rows[0] == 'a,v,p'
    a = 7 * 0.1
    v = (a / 2.0) * 0.5
    p = (v / 2.0) * 0.5
    v_after = v + (a + (0.0 - a) / 2.0) * 0.5
    p_after = p + (v + (v_after - v) / 2.0) * 0.5
    found = [tuple(map(float, row.split(','))) for row in rows[1:]]
    assert found == [(a, v, p), (0.0, v_after, p_after)], 'every digit of the doubles is printed'


@pytest.mark.parametrize(
    ('lines', 'words'),
    [
        (['0', '0', '32768', '0'], 'line 3: x is 32768, outside -32768 to 32767'),
        (['0', '0', '-32769', '0'], 'line 3: x is -32769, outside -32768 to 32767'),
        (['0', '0', '0'], 'line 3: ends after 3 rows; at least 4 are needed'),
        (['0', '0', '0x10', '0'], "line 3: x is '0x10', which is no whole number"),
    ],
)
def test_mbed_refuses(capsys, table, lines, words):
    path = table(lines)
    assert f'{path}, {words}' in refused(capsys, 'mbed', *options({}), path)


@pytest.mark.parametrize(
    'wrong',
    [
        {'--calibration-count': '0'},
        {'--sample-count': '0'},
        {'--no-movement': '-1'},
        {'--gain': 'nan'},
        {'--update-time': 'inf'},
        {'--window-min': 'low'},
    ],
)
def test_mbed_refuses_options(capsys, table, wrong):
    (name,) = wrong
    said = refused(capsys, 'mbed', *options(wrong), table(['0'] * 9))
    assert f'argument {name}: ' in said


@pytest.mark.parametrize('name', MBED)
def test_mbed_needs_each_option(capsys, table, name):
    left = [option for option in options({}) if not option.startswith(name)]
    assert name in refused(capsys, 'mbed', *left, table(['0'] * 9))


def test_missing_file_is_named(capsys, tmp_path):
    said = refused(capsys, 'an3397', str(tmp_path / 'none.csv'))
    assert 'none.csv: No such file' in said


def test_unknown_program_is_refused(capsys):
    assert 'invalid choice' in refused(capsys, 'an3398')


@pytest.mark.parametrize('name', programs())
def test_programs_say_what_they_are(capsys, name):
    with pytest.raises(SystemExit) as end:
        main(['reference', name, '--help'])
    assert end.value.code == 0
    assert programs()[name].SUMMARY.split()[0] in capsys.readouterr().out


def test_reader_that_stops_early_is_no_fault(table):
    path = table(REST + SLIDE * 500)
    command = [sys.executable, '-m', 'dead_reckoning.tools.main', 'reference', 'an3397', path]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=os.environ
    ) as process:
        assert process.stdout.readline() == b'ax,ay,vx,vy,px,py,frame\n'
        process.stdout.close()
        assert process.stderr.read() == b''
        assert process.wait(timeout=30) == 0
