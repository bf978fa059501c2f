"""A device in a thread of its own, and the clock of what it collects."""

import threading
import time

import numpy as np
import pytest

from dead_reckoning.core.errors import LostDeviceError
from dead_reckoning.sources import devices
from dead_reckoning.sources.devices import DeviceThread, FifoClock, Opened

START = 1_700_000_000_000_000_000


def until(thread, wanted, patience=10.0):
    """Return the events up to one that is as wanted."""
    events, end = [], time.monotonic() + patience
    while not any(map(wanted, events)):
        assert time.monotonic() < end, events
        events += thread.poll()
        time.sleep(0.001)
    return events


def test_a_lost_device_is_opened_again_and_again_and_nothing_is_left(monkeypatch):
    monkeypatch.setattr(devices, 'RETRY', 0.001)
    opened, closed = [], []

    def session(wait):
        opened.append(1)
        try:
            yield Opened()
            raise LostDeviceError('gone')
        finally:
            closed.append(1)

    before = threading.active_count()
    thread = DeviceThread(session, 'test')
    end = time.monotonic() + 20.0
    while len(opened) < 200:
        assert time.monotonic() < end
        thread.poll()
        time.sleep(0.001)
    thread.close()
    assert len(opened) == len(closed)
    assert threading.active_count() == before


def test_the_end_closes_the_session_at_once():
    closed = []

    def session(wait):
        try:
            yield Opened()
            while True:
                wait(60.0)
                yield None
        finally:
            closed.append(1)

    thread = DeviceThread(session, 'test')
    until(thread, lambda event: event == Opened())
    begun = time.monotonic()
    thread.close()
    assert closed == [1]
    assert time.monotonic() - begun < 1.0


def test_the_end_is_heard_though_nobody_takes_the_events():
    def session(wait):
        while True:
            yield Opened()

    thread = DeviceThread(session, 'test')
    time.sleep(0.05)
    begun = time.monotonic()
    thread.close()
    assert time.monotonic() - begun < 1.0
    assert len(thread.poll()) <= devices.WAITING


@pytest.mark.parametrize('back', [1, 10_000_000, 900_000_000])
def test_stamps_rise_though_the_clock_is_set_back_a_little(back):
    clock = FifoClock(0.01)
    stamps = list(clock.stamps(5, START, START))
    for look in range(1, 50):
        now = START + look * 50_000_000 - back
        stamps += list(clock.stamps(5, now, now))
    assert np.all(np.diff(stamps) > 0)
    assert stamps[-1] == pytest.approx(now, abs=10_000_000)


@pytest.mark.parametrize('leap', [-3600, 3600])
def test_stamps_start_anew_where_the_clock_is_set(leap):
    clock = FifoClock(0.01)
    clock.stamps(5, START, START)
    now = START + leap * 1_000_000_000
    stamps = clock.stamps(5, now, now)
    np.testing.assert_allclose(np.diff(stamps), 10_000_000, atol=1)
    assert abs(now - stamps[-1]) <= 10_000_000
