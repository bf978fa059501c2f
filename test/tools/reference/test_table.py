"""Counts from CSV: what is read, and how faults are named."""

import pytest

from dead_reckoning.core.errors import InputError
from dead_reckoning.tools.reference.table import Columns, read

XY = Columns(names=('x', 'y'), minimum=-5, maximum=255, rows=2)


@pytest.fixture
def table(tmp_path):
    def make(content):
        path = tmp_path / 'counts.csv'
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return make


@pytest.mark.parametrize(
    'content',
    [
        'x,y\n1,2\n-3,+255\n',
        '1,2\n-3,255',
        'x,y\r\n1,2\r\n-3,255\r\n\r\n',
        '\ufeffx,y\n1,2\n-3,255\n',
        ' x , "y"\n 1, 2 \n-3,\t255\n',
        'y,time,x\n2,0.5,1\n255,1.0,-3\n',
        'y,x\n2,1\n255,-3\n',
    ],
)
def test_counts_are_read(table, content):
    counts = read(table(content), XY)
    assert counts.tolist() == [[1, 2], [-3, 255]]
    assert counts.dtype == 'int64'


@pytest.mark.parametrize(
    ('content', 'words'),
    [
        ('x,y\n1,2\n1,256\n', 'line 3: y is 256, outside -5 to 255'),
        ('1,2\n-6,2\n', 'line 2: x is -6, outside -5 to 255'),
        ('1,2\n1,2.5\n', "line 2: y is '2.5', which is no whole number"),
        ('1,2\nabc,2\n', "line 2: x is 'abc', which is no whole number"),
        ('1,2\n1_0,2\n', "line 2: x is '1_0', which is no whole number"),
        ('1,2\n٣,2\n', "line 2: x is '٣', which is no whole number"),
        ('1,2\n,2\n', "line 2: x is '', which is no whole number"),
        ('1,nan\n1,2\n', "line 1: y is 'nan', which is no whole number"),
        (b'1,2\n1,\xff\n', r"line 2: y is '\\xff', which is no whole number"),
        ('1,2\n1,' + 19 * '9' + '\n', "line 2: y is '" + 19 * '9' + "', which is no whole number"),
        ('1,2\n' + 50 * 'a' + ',2\n', "line 2: x is '" + 40 * 'a' + "…', which is no"),
        ('1,2\n1\n', "line 2: '1' has 1 columns, not 2"),
        ('1,2,3\n1,2,3\n', "line 1: '1,2,3' has 3 columns, not 2"),
        ('1,2\n\n1,2\n', "line 2: '' has 1 columns, not 2"),
        ('a,y\n1,2\n1,2\n', "line 1: no column x in 'a,y'"),
        ('x,x,y\n1,2,3\n', "line 1: more than one column x in 'x,x,y'"),
        ('x,y\n1,2\n', 'line 2: ends after 1 rows; at least 2 are needed'),
        ('x,y\n', 'line 1: ends after 0 rows; at least 2 are needed'),
        ('1,2\n', 'line 1: ends after 1 rows; at least 2 are needed'),
        ('1,300\n', 'line 1: y is 300, outside -5 to 255'),
        ('', "line 1: '' has 1 columns, not 2"),
    ],
)
def test_fault_is_named_with_line_and_value(table, content, words):
    path = table(content)
    with pytest.raises(InputError) as caught:
        read(path, XY)
    assert str(caught.value).startswith(f'{path}, {words}')


def test_one_column_is_read(table):
    columns = Columns(names=('x',), minimum=0, maximum=9, rows=1)
    assert read(table('x\n1\n2\n'), columns).tolist() == [[1], [2]]
    assert read(table('1\n2\n'), columns).tolist() == [[1], [2]]


def test_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(InputError, match=r'missing\.csv: No such file'):
        read(tmp_path / 'missing.csv', XY)
    with pytest.raises(InputError, match='directory'):
        read(tmp_path, XY)
