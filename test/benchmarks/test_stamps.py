"""The acceptance of the stamps by a board's clock, and the simulation behind it."""

import numpy as np
import pytest

from benchmarks import stamps


@pytest.mark.parametrize('rate', stamps.RATES)
def test_jitter_of_an_adapter_is_taken_off(rate):
    """Held for up to 16 ms, 50 ppm off, readings lost: a tenth of the error of the arrivals."""
    for seed in (1, 2, 3):
        sent = stamps.way(rate, 600.0, seed=seed)
        raw, ours = sent.arrival - sent.true, stamps.stamps(sent) - sent.true
        assert stamps.rms(ours) < 0.1 * stamps.rms(raw)
        then = sent.true >= stamps.SETTLING
        assert stamps.spread(ours[then]) < 0.1 * stamps.spread(raw[then])


@pytest.mark.parametrize('rate', stamps.RATES)
def test_the_way_is_as_it_says(rate):
    sent = stamps.way(rate, 100.0)
    delay = sent.arrival - sent.true
    assert delay.min() >= -1e-9
    assert 0.008 < delay.max() < 0.016 + 10.0 * stamps.WAKING
    assert (np.diff(sent.arrival) > 0.0).all()
    assert 0.95 < len(sent.number) / (100.0 * rate) < 0.985
    assert np.polyfit(sent.number / rate, sent.true, 1)[0] == pytest.approx(1.00005, abs=1e-9)


def test_a_row_for_each_rate():
    rows = list(stamps.rows(duration=200.0, seeds=1))
    assert [row[0] for row in rows] == ['50', '100', '200', '500']
    assert all(len(row) == 10 for row in rows)
