"""The command `reference an900`: what goes in, what comes out, what is refused."""

import numpy as np
import pytest

from dead_reckoning.core.reference import an900
from dead_reckoning.tools.main import main

HEADER = 'sample,stride,average_stride,steps,distance'


@pytest.fixture
def walk():
    turn = 2.0 * np.pi * 1.8 * np.arange(300) / 30.0
    counts = np.full((300, 2), an900.ZERO_G)
    counts[:, 0] += np.round(1638.0 - 480.0 * np.cos(turn) + 140.0 * np.cos(2.0 * turn)).astype(
        int
    )
    return counts


def written(path, counts, header='x,y\n'):
    path.write_text(header + ''.join(f'{x},{y}\n' for x, y in counts))
    return str(path)


def rows(capsys):
    output, error = capsys.readouterr()
    assert error == ''
    assert output.endswith('\n')
    return output.splitlines()


@pytest.mark.parametrize('header', ['x,y\n', ''])
@pytest.mark.parametrize(
    ('options', 'keywords'),
    [
        ([], {}),
        (['--corrected'], {'corrected': True}),
        (['--avgconst', '3'], {'average': 3}),
        (['--corrected', '--avgconst', '7'], {'corrected': True, 'average': 7}),
    ],
)
def test_row_per_step_with_six_decimals(tmp_path, capsys, walk, header, options, keywords):
    path = written(tmp_path / 'counts.csv', walk, header)
    assert main(['reference', 'an900', *options, path]) == 0
    steps = an900.run(walk, **keywords)
    assert len(steps) > 10
    assert rows(capsys) == [
        HEADER,
        *(
            f'{step.sample},{step.stride:.6f},{step.average_stride:.6f},{step.steps},'
            f'{step.distance:.6f}'
            for step in steps
        ),
    ]


def test_rest_has_no_steps(tmp_path, capsys):
    path = written(tmp_path / 'counts.csv', [(9830, 8192)] * 9)
    assert main(['reference', 'an900', path]) == 0
    assert rows(capsys) == [HEADER]


@pytest.mark.parametrize(
    ('line', 'text', 'words'),
    [
        (5, '16381,0', '16381'),
        (7, '0,-1', '-1'),
        (9, '8192,heel', 'heel'),
        (4, '8192.5,8192', '8192.5'),
        (6, '8192', '8192'),
    ],
)
def test_fault_is_named_by_line_and_value(tmp_path, capsys, walk, line, text, words):
    path = tmp_path / 'counts.csv'
    lines = written(path, walk) and path.read_text().splitlines()
    lines[line - 1] = text
    path.write_text('\n'.join(lines))
    assert main(['reference', 'an900', str(path)]) == 2
    output, error = capsys.readouterr()
    assert output == ''
    assert f'line {line}:' in error
    assert words in error


@pytest.mark.parametrize('count', [0, 1, 8])
def test_eight_samples_are_too_few(tmp_path, capsys, walk, count):
    path = written(tmp_path / 'counts.csv', walk[:count])
    assert main(['reference', 'an900', path]) == 2
    output, error = capsys.readouterr()
    assert output == ''
    assert f'{count} rows' in error
    assert '9' in error


@pytest.mark.parametrize('value', ['0', '-1', 'two', '1.5', str(2**31)])
def test_average_is_a_whole_number_from_one(tmp_path, capsys, walk, value):
    path = written(tmp_path / 'counts.csv', walk)
    with pytest.raises(SystemExit) as end:
        main(['reference', 'an900', f'--avgconst={value}', path])
    assert end.value.code == 2
    output, error = capsys.readouterr()
    assert output == ''
    assert value in error
