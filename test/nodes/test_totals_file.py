"""The file of totals: what it takes for its own, and what a killed process leaves in it."""

import json
import math
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from threading import Event

import pytest
from hypothesis import given
from hypothesis import strategies as st

import dead_reckoning
from dead_reckoning.core.errors import DamagedStateError, SettingsError, StateFileError
from dead_reckoning.core.pedometer import Totals
from dead_reckoning.nodes import totals_file
from dead_reckoning.nodes.totals_file import MOST_STEPS, TotalsFile, decode, encode

LENGTHS = st.floats(0.0, 1e12)
TOTALS = st.builds(Totals, st.integers(0, MOST_STEPS), LENGTHS, LENGTHS)
WALKED = Totals(1234, 864.2000000000001, 0.71)


@pytest.fixture
def path(tmp_path):
    return tmp_path / 'totals.json'


def opened(path):
    """Return what is in a file, as the next node finds it."""
    file = TotalsFile(str(path))
    file.close()
    return file


# Bytes ----------------------------------------------------------------------------------------


@given(TOTALS)
def test_totals_come_back_bit_for_bit(totals):
    assert decode(encode(totals)) == totals
    assert json.loads(encode(totals))['steps'] == totals.steps


@given(
    st.binary()
    | st.text().map(str.encode)
    | st.recursive(
        st.none() | st.floats() | st.text(),
        lambda inner: (
            st.lists(inner)
            | st.dictionaries(
                st.sampled_from(['steps', 'distance', 'step_length', 'crc32']), inner
            )
        ),
    ).map(lambda value: json.dumps(value).encode())
)
def test_any_other_bytes_are_refused(data):
    with pytest.raises(DamagedStateError):
        decode(data)


@given(TOTALS, st.data())
def test_one_byte_changed_added_or_lost_is_noticed(totals, data):
    whole = encode(totals)
    at = data.draw(st.integers(0, len(whole) - 1))
    other = data.draw(st.binary(max_size=2).filter(lambda part: part != whole[at : at + 1]))
    with pytest.raises(DamagedStateError):
        decode(whole[:at] + other + whole[at + 1 :])


@pytest.mark.parametrize('cut', [0, 1, 40, -2, -1])
def test_truncated_file_is_refused(cut):
    with pytest.raises(DamagedStateError):
        decode(encode(WALKED)[:cut])


@pytest.mark.parametrize(
    'wrong',
    [
        Totals(-1, 1.0, 1.0),
        Totals(MOST_STEPS + 1, 1.0, 1.0),
        Totals(True, 1.0, 1.0),
        Totals(1.0, 1.0, 1.0),
        Totals(1, -0.5, 1.0),
        Totals(1, math.nan, 1.0),
        Totals(1, 1.0, math.inf),
        Totals(1, 1, 1.0),
        Totals(1, '1', 1.0),
        Totals(None, [], {}),
    ],
)
def test_what_are_no_totals_is_refused_even_with_its_checksum(wrong):
    with pytest.raises(DamagedStateError, match='are no totals'):
        decode(encode(wrong))


def test_another_version_is_refused(monkeypatch):
    monkeypatch.setattr(totals_file, 'VERSION', 2)
    other = encode(WALKED)
    monkeypatch.undo()
    with pytest.raises(DamagedStateError, match='version'):
        decode(other)


def test_deep_nesting_is_refused():
    with pytest.raises(DamagedStateError):
        decode(b'[' * 100_000)


# File -----------------------------------------------------------------------------------------


def test_what_is_kept_is_found_again(path, monkeypatch):
    monkeypatch.setattr(totals_file, 'LONGEST_WAIT', 60.0)  # whatever else the disk does
    assert opened(path).totals == Totals()
    file = TotalsFile(str(path))
    for steps in range(1, 6):
        file.keep(Totals(steps, 0.7 * steps, 0.7))
        assert decode(path.read_bytes()).steps == steps, 'before keep returns'
    file.close()
    assert opened(path).totals == Totals(5, 3.5, 0.7)


def test_home_and_links_are_followed(tmp_path, monkeypatch):
    monkeypatch.setenv('HOME', str(tmp_path))
    (tmp_path / 'place').mkdir()
    (tmp_path / 'link').symlink_to(tmp_path / 'place' / 'totals')
    opened('~/link')
    assert (tmp_path / 'link').is_symlink()
    assert decode((tmp_path / 'place' / 'totals').read_bytes()) == Totals()


@pytest.mark.parametrize('content', [b'', b'{}', encode(WALKED)[:-1], os.urandom(100_000)])
def test_damaged_file_is_set_aside_and_named(path, content):
    for number in (1, 2, 3):
        path.write_bytes(content)
        file = opened(path)
        assert file.totals == decode(path.read_bytes()) == Totals()
        aside = path.with_name(f'totals.json.damaged{number}')
        assert str(aside) in str(file.damage)
        assert aside.read_bytes() == content
    assert opened(path).damage is None


@pytest.mark.parametrize(
    'wrong',
    ['missing/totals', '.', 'pipe', 'file/totals', '~nosuchuser/totals', 'a\0b', 'x' * 300],
)
def test_path_that_can_not_be_kept_is_refused(tmp_path, monkeypatch, wrong):
    monkeypatch.chdir(tmp_path)
    os.mkfifo('pipe')
    Path('file').touch()
    with pytest.raises(SettingsError, match=r'pedometer\.state_file: .* can not be kept'):
        TotalsFile(wrong)


def test_second_one_is_refused_until_the_first_ends(path):
    first = TotalsFile(str(path))
    for _ in range(2):
        with pytest.raises(SettingsError, match='another node keeps its totals there'):
            TotalsFile(str(path))
    first.close()
    opened(path)


def test_what_a_killed_process_left_is_written_over(path):
    opened(path)
    before = set(path.parent.iterdir())
    path.with_name('.totals.json.part').write_bytes(b'half')
    assert opened(path).totals == Totals()
    assert set(path.parent.iterdir()) == before


def test_full_disk_is_told_and_tried_again(path, monkeypatch):
    monkeypatch.setattr(totals_file, 'LONGEST_WAIT', 60.0)
    file = TotalsFile(str(path))
    file.keep(Totals(1, 0.7, 0.7))
    with monkeypatch.context() as full:

        def no_room(totals):
            raise OSError(28, 'No space left on device')

        full.setattr(totals_file, 'encode', no_room)
        for steps in (2, 3):
            assert file.keep(Totals(steps, 0.7, 0.7))()
            assert isinstance(file.error, StateFileError)
            assert 'No space left on device' in str(file.error)
    assert decode(path.read_bytes()).steps == 1, 'the old one stays whole'
    file.keep(Totals(4, 0.7, 0.7))
    assert file.error is None
    assert decode(path.read_bytes()).steps == 4
    file.close()


def test_slow_disk_does_not_hold_samples_up(path, monkeypatch):
    file, goes_on = TotalsFile(str(path)), Event()
    plain = os.fsync
    monkeypatch.setattr(os, 'fsync', lambda descriptor: goes_on.wait() and plain(descriptor))
    begin = time.monotonic()
    safe = [file.keep(Totals(steps, 0.7 * steps, 0.7)) for steps in range(1, 6)]
    assert time.monotonic() - begin < 5 * totals_file.LONGEST_WAIT + 1.0
    assert decode(path.read_bytes()) == Totals()
    assert file.error is None
    assert not any(each() for each in safe)
    with monkeypatch.context() as later:
        later.setattr(totals_file, 'PATIENCE', 0.01)
        assert 'the disk has not answered' in str(file.error)
        assert all(each() for each in safe), 'what can not be kept is waited for no longer'
    assert file._writer._work_queue.qsize() <= 1, 'however many are to be written'
    goes_on.set()
    file.close()
    assert file.error is None
    assert all(each() for each in safe)
    assert decode(path.read_bytes()).steps == 5


STEADY = """
import sys
from dead_reckoning.core.pedometer import Totals
from dead_reckoning.nodes import totals_file
totals_file.LONGEST_WAIT = 60.0
file = totals_file.TotalsFile(sys.argv[1])
assert file.damage is None
steps = file.totals.steps
while True:
    steps += 1
    file.keep(Totals(steps, 0.7 * steps, 0.7))
    print(steps, flush=True)
"""


def test_killed_process_loses_nothing_that_was_kept(path, tmp_path):
    chance, said = random.Random(5), tmp_path / 'said'
    root = Path(dead_reckoning.__file__).parents[1]
    for _ in range(12):
        with said.open('ab') as out:
            process = subprocess.Popen(
                [sys.executable, '-c', STEADY, str(path)], stdout=out, cwd=root
            )
        size = said.stat().st_size
        while said.stat().st_size == size and process.poll() is None:
            time.sleep(0.01)
        time.sleep(chance.uniform(0.0, 0.1))
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
        kept = decode(path.read_bytes())
        last = int(said.read_text().split()[-1])
        assert last <= kept.steps <= last + 1
        assert kept.distance == 0.7 * kept.steps
