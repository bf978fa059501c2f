"""The demo as its user runs it: real nodes over DDS, pictures, a page, and a clean end."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from browser import assert_self_contained, opened

pytest.importorskip('rclpy', reason='the demo runs ROS nodes, and rclpy is not installed')

DEMO = [sys.executable, '-m', 'dead_reckoning.tools.main', 'demo']
COMMAND = [*DEMO, 'slide', 'square']
LONGER = [*DEMO, 'walk', 'mbed']
MARK = 'DEAD_RECKONING_TEST_RUN'


def environment(mark, domain):
    return {**os.environ, MARK: mark, 'ROS_DOMAIN_ID': str(domain), 'PYTHONUNBUFFERED': '1'}


def processes_of(mark):
    """List the processes that carry a mark in their environment."""
    found = []
    for folder in Path('/proc').glob('[0-9]*'):
        try:
            if f'{MARK}={mark}'.encode() in (folder / 'environ').read_bytes().split(b'\0'):
                found.append((folder / 'cmdline').read_bytes().replace(b'\0', b' ').decode())
        except OSError:  # it has ended, or is not ours
            continue
    return found


@pytest.fixture(scope='module')
def longer(tmp_path_factory, other_module_domain_id):
    """Start the cases that take long, beside the others; return what waits for them."""
    output = tmp_path_factory.mktemp('longer')
    run = subprocess.Popen(
        [*LONGER, '--output', str(output)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment('longer', other_module_domain_id),
    )
    yield lambda: (*run.communicate(timeout=180), run.returncode)
    run.terminate()
    run.wait()


@pytest.fixture(scope='module')
def demo(tmp_path_factory, module_domain_id, longer):
    output = tmp_path_factory.mktemp('demo')
    run = subprocess.run(
        [*COMMAND, '--output', str(output)],
        capture_output=True,
        text=True,
        timeout=120,
        env=environment('demo', module_domain_id),
        check=False,
    )
    return run, output


def test_it_ends_well_and_says_nothing_on_stderr(demo):
    run, _ = demo
    assert (run.returncode, run.stderr) == (0, '')


def test_the_table_shows_the_slide(demo):
    run, _ = demo
    number = r'\s+([-+]?[0-9.]+)'
    row = re.search(rf'displacement \[m\]{number}{number}{number}', run.stdout)
    truth, estimate, error = map(float, row.groups())
    assert truth == pytest.approx(0.5)
    assert estimate == pytest.approx(0.5, rel=0.05)
    assert error == pytest.approx(estimate - truth, abs=2e-4)


def test_the_square_comes_back(demo):
    run, _ = demo
    for axis in 'xy':
        row = re.search(rf'{axis} at the end \[m\]\s+(\S+)\s+(\S+)', run.stdout)
        assert float(row.group(1)) == 0.0
        assert abs(float(row.group(2))) < 0.02


def test_a_case_that_is_not_there_is_named():
    run = subprocess.run(
        [*COMMAND, 'spiral'], capture_output=True, text=True, timeout=60, check=False
    )
    assert run.returncode == 1
    assert "no case 'spiral'; there are slide, " in run.stderr


def test_it_says_where_pictures_and_page_are(demo):
    run, output = demo
    named = [Path(path) for path in re.findall(r'^(?:picture|page) +(.*)$', run.stdout, re.M)]
    assert [path.suffix for path in named] == ['.png'] * 5 + ['.html']
    assert all(path.parent == output and path.stat().st_size > 5000 for path in named)
    for path in named[:5]:
        assert path.read_bytes().startswith(b'\x89PNG')


def test_the_page_is_self_contained(demo):
    _, output = demo
    page = (output / 'index.html').read_text(encoding='utf-8')
    assert page.count('src="data:image/png;base64,') == 5
    assert_self_contained(page)
    assert 'Slide of 0.5 m' in page


def test_the_page_opens_in_a_browser(demo):
    _, output = demo
    document, widths = opened(output / 'index.html')
    assert len(widths) == 5
    assert min(widths) > 0
    assert 'displacement [m]' in document


def test_no_process_is_left_after_the_demo(demo):
    assert processes_of('demo') == []


def test_steps_are_exact_and_the_eight_closes(longer):
    said, errors, status = longer()
    assert (status, errors) == (0, '')
    assert re.search(r'^ +steps +60 +60 +\+0$', said, re.M)
    distance = re.search(r'distance \[m\] +42.00 +(\S+)', said)
    assert float(distance.group(1)) == pytest.approx(42.0, rel=0.1)
    length = re.search(r'length of the way \[m\] +(\S+) +(\S+)', said)
    assert float(length.group(2)) == pytest.approx(float(length.group(1)), rel=0.02)
    for axis in 'xy':
        for end in re.findall(rf'{axis} at the end \[m\] +0\.00 +(\S+)', said):
            assert abs(float(end)) < 1.0
    assert processes_of('longer') == []


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('delay', [0.6, 1.5, 4.0])
def test_a_signal_at_any_time_leaves_no_process(number, delay, tmp_path, module_domain_id):
    mark = f'{number}-{delay}'
    run = subprocess.Popen(
        [*COMMAND, '--output', str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(mark, module_domain_id),
    )
    time.sleep(delay)
    run.send_signal(number)
    _, errors = run.communicate(timeout=30)
    assert run.returncode in (130, -number)  # the latter: before the program had begun
    assert 'Traceback' not in errors
    assert processes_of(mark) == []
