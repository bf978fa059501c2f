"""The bar: where someone looks, and nowhere else."""

import io
import sys

import pytest

from dead_reckoning.tools.replay.progress import Progress


@pytest.mark.parametrize(('terminal', 'watched'), [(True, True), (True, False), (False, True)])
def test_a_bar_is_for_a_terminal(monkeypatch, terminal, watched):
    stream = io.StringIO()
    stream.isatty = lambda: terminal
    monkeypatch.setattr(sys, 'stderr', stream)
    monkeypatch.setattr('dead_reckoning.tools.replay.progress.PERIOD', 0.0)
    with Progress('walk', 200, watched) as progress:
        progress.add(100)
    if not (terminal and watched):
        assert stream.getvalue() == ''
        return
    begun, drawn, wiped = stream.getvalue().split('\r')[1:]
    assert begun == 'walk ' + '░' * 30 + '   0% '
    assert drawn == 'walk ' + '█' * 15 + '░' * 15 + '  50% '
    assert wiped == '\x1b[K'
