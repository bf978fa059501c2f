"""What is counted and said of faults, by a clock of the test."""

from types import SimpleNamespace

import pytest

from dead_reckoning.core.errors import MissingMountingError, NotLevelledError
from dead_reckoning.nodes import diagnostics
from dead_reckoning.nodes.diagnostics import PATIENCE, REPEAT, Diagnostics


@pytest.mark.parametrize(
    ('error', 'dropped'), [(MissingMountingError('mounting'), 4), (NotLevelledError('rest'), 0)]
)
def test_a_wait_that_is_soon_over_goes_without_a_word(ros, monkeypatch, capfd, error, dropped):
    now = [1000.0]
    monkeypatch.setattr(diagnostics, 'time', SimpleNamespace(monotonic=lambda: now[0]))
    told = Diagnostics(ros.node, dict, tuple, str)

    def faults_after(*times):
        for seconds in times:
            now[0] += seconds
            told.fault(error)
        return capfd.readouterr().err.count(str(error))

    assert faults_after(0.0, PATIENCE - 0.1) == 0
    told.publish()
    told.publish()  # a second without it: over
    assert faults_after(REPEAT) == 0
    assert faults_after(PATIENCE + 0.1) == 1
    assert told.dropped == dropped
