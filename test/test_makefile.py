"""What `make` says and leaves behind where it cannot do its work."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
INHERITED = {'MAKEFLAGS', 'MFLAGS', 'MAKELEVEL', 'ROS_DISTRO', 'PYTHON'}

pytestmark = pytest.mark.skipif(shutil.which('make') is None, reason='make is not installed')


@pytest.fixture
def checkout(tmp_path):
    shutil.copy(ROOT / 'Makefile', tmp_path)
    shutil.copytree(ROOT / 'requirements', tmp_path / 'requirements')
    return tmp_path


def make(checkout, *arguments, **environment):
    """Run make; return its status and what it wrote, without its own last word."""
    kept = {key: value for key, value in os.environ.items() if key not in INHERITED}
    done = subprocess.run(
        ['make', *arguments],
        cwd=checkout,
        env={**kept, **environment},
        capture_output=True,
        text=True,
    )
    lines = [line for line in done.stderr.splitlines() if not line.startswith('make: ***')]
    return done.returncode, done.stdout, lines


def interpreter(folder, *changes):
    """Write a Python that differs from this one as the statements ``changes`` say."""
    path = folder / 'python3'
    code = '; '.join(('import sys', *changes, 'sys.argv[:1] = []', 'exec(sys.stdin.read())'))
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{code}" "$@"\n')
    path.chmod(0o755)
    return str(path)


@pytest.mark.parametrize(
    ('changes', 'said'),
    [
        (['sys.version_info = (3, 9, 2)'], 'is Python 3.9, too old: install Python 3.12'),
        (["sys.modules['ensurepip'] = None"], 'lacks the venv module: apt install python3.'),
        (['import platform', "platform.machine = lambda: 'aarch64'"], 'this is Linux on aarch64'),
        (['import platform', "platform.libc_ver = lambda: ('glibc', '2.17')"], 'need glibc 2.28'),
        (['import platform', "platform.libc_ver = lambda: ('', '')"], 'need glibc 2.28'),
        (['sys.version_info = (3, 15, 0)'], 'are for CPython 3.10 to 3.14'),
    ],
)
def test_a_missing_prerequisite_is_one_line(checkout, changes, said):
    status, _, errors = make(checkout, 'venv', f'PYTHON={interpreter(checkout, *changes)}')
    assert status != 0
    assert len(errors) == 1
    assert said in errors[0]
    assert not (checkout / '.venv').exists()


def test_no_python_is_one_line(checkout):
    status, _, errors = make(checkout, 'venv', 'PYTHON=no-such-python')
    assert status != 0
    assert errors == [
        'dead_reckoning: no no-such-python here: install Python 3.12 with its venv module '
        '(apt install python3.12-venv)'
    ]


def test_another_distribution_of_ros_is_refused_in_one_line(checkout):
    status, _, errors = make(checkout, 'demo', ROS_DISTRO='humble')
    assert status != 0
    assert len(errors) == 1
    assert 'humble is sourced, this package needs Jazzy' in errors[0]


def test_a_sourced_ros_without_rclpy_is_one_line(checkout):
    python = interpreter(checkout, "sys.modules['rclpy'] = None")
    status, _, errors = make(checkout, 'venv', f'PYTHON={python}', ROS_DISTRO='jazzy')
    assert status != 0
    assert len(errors) == 1
    assert 'cannot import its rclpy: apt install ros-jazzy-ros-base' in errors[0]


def test_accuracy_without_data_is_one_line_and_installs_nothing(checkout):
    status, _, errors = make(checkout, 'accuracy')
    assert status != 0
    assert len(errors) == 1
    assert 'make accuracy DATA=folder' in errors[0]
    assert not (checkout / '.venv').exists()


def test_an_installation_that_broke_off_does_not_count(checkout):
    offline = {'PIP_NO_INDEX': '1', 'PIP_FIND_LINKS': str(checkout)}
    python = f'PYTHON={Path(sys.executable).resolve()}'
    status, _, _ = make(checkout, 'venv', python, **offline)
    assert status != 0
    assert (checkout / '.venv').is_dir()
    assert not list((checkout / '.venv').glob('*ready*'))


def test_help_lists_the_targets(checkout):
    status, said, _ = make(checkout)
    assert status == 0
    for target in ('demo', 'test', 'lint', 'venv', 'accuracy', 'config', 'clean'):
        assert f'make {target}\t' in said
