"""Files are complete or absent."""

import subprocess
import sys

import pytest

from dead_reckoning.core.errors import InputError
from dead_reckoning.tools.files import complete_or_absent

NAMES = ('a.txt', 'b.txt', 'folder')


def listed(folder):
    return {
        str(path.relative_to(folder)): path.read_text() for path in folder.rglob('*.txt')
    }  # fmt: skip


def write(folder, text):
    (folder / 'a.txt').write_text(text)
    (folder / 'folder').mkdir()
    (folder / 'folder/c.txt').write_text(text)


def break_off(folder, error):
    with complete_or_absent(folder, NAMES) as part:
        write(part, 'new')
        raise error


def test_what_is_written_takes_its_place_in_the_end(tmp_path):
    with complete_or_absent(tmp_path / 'new/out', NAMES) as folder:
        write(folder, 'new')
        assert folder.parent == tmp_path / 'new/out'
        assert not (tmp_path / 'new/out/a.txt').exists()
    assert listed(tmp_path / 'new/out') == {'a.txt': 'new', 'folder/c.txt': 'new'}
    assert sorted(path.name for path in (tmp_path / 'new/out').iterdir()) == ['a.txt', 'folder']


def test_names_that_were_not_written_are_gone_and_others_stay(tmp_path):
    for name in ('b.txt', 'other.txt'):
        (tmp_path / name).write_text('old')
    write(tmp_path, 'old')
    (tmp_path / 'folder/old.txt').write_text('old')
    with complete_or_absent(tmp_path, NAMES) as folder:
        write(folder, 'new')
    assert listed(tmp_path) == {'a.txt': 'new', 'folder/c.txt': 'new', 'other.txt': 'old'}


def test_what_breaks_off_leaves_all_as_it_was(tmp_path):
    write(tmp_path, 'old')
    with pytest.raises(KeyboardInterrupt):
        break_off(tmp_path, KeyboardInterrupt())
    assert listed(tmp_path) == {'a.txt': 'old', 'folder/c.txt': 'old'}
    assert not list(tmp_path.glob('.*'))


def test_a_folder_that_was_not_there_is_gone_again(tmp_path):
    with pytest.raises(ValueError, match='broken'):
        break_off(tmp_path / 'new/out', ValueError('broken'))
    assert not (tmp_path / 'new').exists()


def test_a_folder_that_can_not_be_is_refused(tmp_path):
    (tmp_path / 'file').write_text('')
    for path in (tmp_path / 'file', tmp_path / 'file/out'):
        with pytest.raises(InputError, match='--output'), complete_or_absent(path, NAMES):
            pass


KILLED = """
import os, signal, sys
from pathlib import Path
from dead_reckoning.tools.files import complete_or_absent
with complete_or_absent(Path(sys.argv[1]), ['a.txt']) as folder:
    (folder / 'a.txt').write_text('half')
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_process_left_is_taken_away_by_the_next_one(tmp_path):
    subprocess.run([sys.executable, '-c', KILLED, str(tmp_path)], check=False)
    assert list(tmp_path.glob('.*/a.txt'))
    with complete_or_absent(tmp_path, NAMES) as folder:
        assert list(tmp_path.iterdir()) == [folder]


def test_what_others_still_write_is_left_alone(tmp_path):
    with complete_or_absent(tmp_path, ['a.txt']) as first:
        write(first, 'first')
        with complete_or_absent(tmp_path, ['b.txt']) as second:
            (second / 'b.txt').write_text('second')
    assert listed(tmp_path) == {'a.txt': 'first', 'b.txt': 'second'}
