"""The soak reads memory and CPU rightly, sees growth and nothing else, and runs."""

import os
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from benchmarks.soak import MEGABYTE, cpu_time, growth, resident

ROOT = Path(__file__).parents[2]
TIMES = np.arange(0.0, 570.0)


def test_growth_is_slope_times_time():
    assert growth(TIMES, 40.0 + 0.01 * TIMES) == pytest.approx(5.69)
    assert growth(TIMES, np.full(len(TIMES), 40.0)) == 0.0


def test_growth_sees_through_noise_and_outliers():
    random = np.random.default_rng(1)
    values = 40.0 + 0.002 * TIMES + random.normal(0.0, 0.2, len(TIMES))
    values[random.integers(0, len(TIMES), 50)] += 30.0
    assert growth(TIMES, values) == pytest.approx(0.002 * 569.0, abs=0.2)


def test_memory_of_a_process_is_what_it_takes():
    before = resident(os.getpid())
    taken = bytearray(b'x') * (20 * MEGABYTE)  # one piece, without a copy that is freed or not
    assert resident(os.getpid()) - before == pytest.approx(20.0, abs=3.0)
    del taken


def test_cpu_time_is_that_of_the_process():
    before, own = cpu_time(os.getpid()), time.process_time()
    while time.process_time() < own + 0.3:
        pass
    assert cpu_time(os.getpid()) - before == pytest.approx(0.3, abs=0.1)


def test_a_run_shorter_than_its_warm_up_is_refused():
    process = run('--minutes', '0.1')
    assert process.returncode == 2
    assert 'give more minutes, or --warm-up 0' in process.stderr


@pytest.mark.skipif(find_spec('rclpy') is None, reason='needs ROS 2')
@pytest.mark.parametrize('shape', ['pipeline', 'navigator', 'nodes'])
def test_it_runs_and_reports_each_node(domain_id, shape):
    process = run(
        *('--minutes', '0.1', '--warm-up', '1', '--rate', '100', '--shape', shape),
        ROS_DOMAIN_ID=str(domain_id),
    )
    assert 'Traceback' not in process.stderr, process.stderr
    lines = process.stdout.splitlines()
    assert lines[0].startswith(f'{shape}: ')
    names = ['pipeline'] if shape != 'nodes' else ['gravity_removal', 'integrator', 'pedometer']
    assert [line.split()[0] for line in lines[1:]] == names
    assert all('growth' in line and 'µs per sample' in line for line in lines[1:])


def run(*arguments, **environment):
    return subprocess.run(
        [sys.executable, '-m', 'benchmarks.soak', *arguments],
        cwd=ROOT,
        env={
            **os.environ,
            'PYTHONPATH': os.pathsep.join([str(ROOT), os.environ.get('PYTHONPATH', '')]),
            **environment,
        },
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
