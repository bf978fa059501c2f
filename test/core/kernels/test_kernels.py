"""Compiling: kept as long as nothing changed, missing without harm, paid by those who use it."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

import dead_reckoning
from dead_reckoning.core import checks, kernels, rotation
from dead_reckoning.core.kernels import headings

ROOT = Path(dead_reckoning.__file__).parents[1]
TURN = (1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0)
SPREAD = (4.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0)


def run(code, **environment):
    """Run code in a Python of its own; return what it printed."""
    result = subprocess.run(
        [sys.executable, '-c', code],
        env={**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path), **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_kernels_are_kept_and_taken_again(tmp_path):
    pytest.importorskip('numba')
    code = (
        'from dead_reckoning.core import kernels, rotation\n'
        'made = kernels._kept(rotation.similarity)\n'
        f'assert made({TURN}, {SPREAD}) == rotation.similarity({TURN}, {SPREAD})\n'
        'print(sum(made.stats.cache_hits.values()))'
    )
    assert [run(code, NUMBA_CACHE_DIR=str(tmp_path)).strip() for _ in range(2)] == ['0', '1']


def test_what_is_kept_depends_on_all_that_a_kernel_calls(monkeypatch):
    pytest.importorskip('numba')

    def meaning():
        for cached in (kernels._closed, kernels._callee):
            cached.cache_clear()
        return kernels._closed(headings.find_headings.__wrapped__)[1]

    first = meaning()
    assert meaning() == first
    with monkeypatch.context() as changed:
        changed.setattr(headings, 'unit', rotation.inverse)
        assert meaning() != first
    with monkeypatch.context() as changed:
        changed.setattr(headings, 'SPACING_NS', 1)
        assert meaning() != first
    with monkeypatch.context() as changed:  # further down
        changed.setattr(rotation, 'NO_ROTATION', (1.0, 0.0, 0.0, 0.0))
        assert meaning() != first
    assert meaning() == first


def test_without_a_place_to_keep_it_a_kernel_works(monkeypatch):
    caching = pytest.importorskip('numba.core.caching')

    def fail(error):
        def method(*given):
            raise error

        return method

    monkeypatch.setattr(caching.FunctionCache, '__init__', fail(RuntimeError('no locator')))
    assert kernels._kept(rotation.similarity)(TURN, SPREAD) == rotation.similarity(TURN, SPREAD)
    monkeypatch.undo()
    monkeypatch.setattr(caching.FunctionCache, 'save_overload', fail(OSError('no space')))
    assert kernels._kept(checks.is_measurable)((0.0, 1e7, 0.0)) is False


WITHOUT_NUMBA = """
import sys
sys.modules['numba'] = None  # as if it were not installed
sys.path.insert(0, {tests!r})
from random_recordings import assert_same, in_blocks, recording, streamed
from dead_reckoning.core.kernels import accelerated
name, samples = 'imu/data_raw', recording(0, seconds=3.0)
assert_same(in_blocks({{}}, name, samples, [100]), streamed({{}}, name, samples))
assert not accelerated()
"""


def test_without_numba_the_stream_does_it():
    run(WITHOUT_NUMBA.format(tests=str(Path(__file__).parents[2])))


def test_numba_can_be_switched_off():
    code = 'from dead_reckoning.core.kernels import accelerated; print(accelerated())'
    assert run(code, NUMBA_DISABLE_JIT='1').strip() == 'False'


def test_a_live_chain_imports_neither_numba_nor_the_kernels_it_does_not_use():
    """The settings of detectors stand beside their statistic, so those kernels are known."""
    run(
        'import sys\n'
        'from dead_reckoning.configuration import Configuration\n'
        'from dead_reckoning.core.pipeline import Pipeline\n'
        "estimators = ['integrator', 'pedometer']\n"
        "Pipeline(Configuration({'pipeline.estimators': estimators}))\n"
        "heavy = ('numba', 'filterpy', 'dead_reckoning.core.kernels')\n"
        "names = ('', '.columns', '.resampler', '.rhythm', '.stationarity')\n"
        "light = [f'{heavy[2]}{name}' for name in names]\n"
        'found = {module for module in sys.modules if module.startswith(heavy)}\n'
        'assert found <= set(light), found'
    )


def test_warmup_compiles_every_kernel():
    pytest.importorskip('numba')
    kernels_of = {
        '.'.join((*path.relative_to(ROOT).with_suffix('').parts, node.name))
        for path in (ROOT / 'dead_reckoning' / 'core').rglob('*.py')
        for node in ast.parse(path.read_text(encoding='utf-8')).body
        if isinstance(node, ast.FunctionDef)
        and any(getattr(decorator, 'id', '') == 'compiled' for decorator in node.decorator_list)
    }
    assert len(kernels_of) >= 5
    code = (
        'from dead_reckoning.core import kernels\n'
        'from dead_reckoning.tools.main import main\n'
        'made = []\n'
        'kernels._kept = lambda function: (made.append(function), function)[1]\n'
        "assert main(['warmup']) == 0\n"
        "print(*(f'{f.__module__}.{f.__name__}' for f in made))"
    )
    made = run(code).splitlines()[-1].split()
    assert sorted(made) == sorted(kernels_of)
