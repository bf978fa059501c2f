"""`dead-reckoning emulate` as its user runs it: a process, a port, and who reads it."""

import argparse
import math
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import numpy as np
import pytest
import serial

from dead_reckoning.core.errors import CutError
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.serial import protocols
from dead_reckoning.sources.serial.protocols import Position, Reading
from dead_reckoning.tools.emulate.command import add_arguments, configured
from dead_reckoning.tools.emulate.emulator import Sensor

COMMAND = [sys.executable, '-m', 'dead_reckoning.tools.main', 'emulate']
NAMES = protocols.names()
CLOSE = 1e-5
"""How much of a count or a metre the text or the float of a board may lose."""

LOOK = 0.01
"""Time [s] between two questions of the driver what the board is to be told."""


@contextmanager
def emulated(*arguments):
    """Run the command; give its process and the first line that it prints."""
    process = subprocess.Popen(
        [*COMMAND, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process, process.stdout.readline().strip()
    finally:
        process.kill()
        process.communicate()


def given(*arguments):
    """Return what the command makes of arguments: its settings."""
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    return configured(parser.parse_args([str(argument) for argument in arguments]))


def read(name, decoder, seconds):
    """Read a port as the driver does; return all events."""
    events, told = [], -math.inf
    with serial.Serial(name, 115_200, timeout=LOOK, write_timeout=1.0, exclusive=True) as port:
        begin = time.monotonic()
        while (now := time.monotonic()) - begin < seconds:
            say = decoder.due(now - told)
            if say:
                port.write(say)
                told = now
            data = port.read(1)
            events += decoder.feed(data + port.read(port.in_waiting) if data else b'')
        port.write(decoder.goodbye())
        port.flush()
    return events


def measurements(configuration, seconds):
    sensor = Sensor(configuration)
    many = []
    while sensor.next < seconds:
        many.append(sensor.measure(0.0))
    return many


def found_and_true(name, events, configuration):
    """Return what was read, and what was measured or worked out by the board, a row each."""
    many = measurements(configuration, 15.0)
    readings = [event.values for event in events if isinstance(event, Reading)]
    if readings:
        unit = decoder_of(name, configuration).unit
        found, true = readings, [measurement.values[unit] for measurement in many]
    else:
        board = protocols.board_class(name)(configuration[protocols.decoder_class(name).Settings])
        sent = b''.join(map(board.measure, many))
        found, true = positions(events), positions(decoder_of(name, configuration).feed(sent))
    assert len(found) > 30
    assert np.isfinite(found).all()
    return np.array(found), np.array(true)


def positions(events):
    return [(event.x, event.y) for event in events if isinstance(event, Position)]


def decoder_of(name, configuration):
    kind = protocols.decoder_class(name)
    return kind(configuration[kind.Settings])


@pytest.mark.parametrize('name', NAMES)
def test_what_was_measured_is_read(name):
    """Over a pty, with whatever the board wants to be told, to the last digit it sends."""
    arguments = ('--protocol', name, '--motion', 'vehicle')
    configuration = given(*arguments)
    decoder = decoder_of(name, configuration)
    with emulated(*arguments) as (_, port):
        events = read(port, decoder, 2.0)
    found, true = found_and_true(name, events, configuration)
    if decoder.POLLED:  # some may be missed, and some be read twice
        at = 0
        for row in found:
            near = np.flatnonzero(np.abs(true[at:] - row).max(axis=1) <= CLOSE)
            assert len(near), f'{row} was not measured, or before those that came earlier'
            at += near[0]
    else:
        runs = np.lib.stride_tricks.sliding_window_view(true, len(found), axis=0)
        off = np.abs(runs.swapaxes(1, 2) - found).max(axis=(1, 2))
        assert off.min() <= CLOSE
    damaged = [event for event in events if not isinstance(event, (Reading, Position, CutError))]
    # Where this machine stalls amid an answer, who polls rightly takes it for a damaged one.
    assert len(damaged) <= (3 if decoder.POLLED else 0)


@pytest.mark.parametrize('name', NAMES)
def test_most_is_read_on_a_line_with_faults(name):
    arguments = ('--protocol', name, '--motion', 'vehicle', '--seed', 7)
    configuration = given(*arguments)
    faults = 'drop:0.001,flip:0.001,double:0.001,pause:0.0005'
    with emulated(*arguments, '--faults', faults) as (_, port):
        events = read(port, decoder_of(name, configuration), 3.0)
    found, true = found_and_true(name, events, configuration)
    good = [(np.abs(true - row).max(axis=1) <= CLOSE).any() for row in found]
    assert np.mean(good) > 0.85


def test_the_bits_are_those_of_the_protocol_unless_they_are_given(tmp_path):
    assert given('--protocol', 'hex')[DriverSettings].adc_bits == 10
    assert given('--protocol', 'ascii')[DriverSettings].adc_bits == 12
    file = tmp_path / 'my.yaml'
    file.write_text('/**:\n  ros__parameters:\n    driver.adc_bits: 8\n')
    assert given('--config', file, '--protocol', 'hex')[DriverSettings].adc_bits == 8


def test_the_same_seed_gives_the_same_bytes():
    arguments = ('--protocol', 'hex', '--rate', 200, '--faults', 'drop:0.01,flip:0.01')

    def first(seed):
        with (
            emulated(*arguments, '--seed', seed) as (_, name),
            serial.Serial(name, timeout=5.0) as port,
        ):
            return port.read(3000)

    def numbered(data, number):
        return data[data.find(number) :][:200]

    one, again, other = first(3), first(3), first(4)
    # The ports were opened at different times: compare from a line that both have.
    number = one.split(b'\r\n')[100][:8]
    assert numbered(one, number) == numbered(again, number)
    assert numbered(other, number) != numbered(one, number)


@pytest.mark.parametrize(
    ('number', 'status'), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (None, 0)]
)
def test_it_ends_cleanly(tmp_path, number, status):
    link = tmp_path / 'board'
    duration = () if number else ('--duration', 0.5)
    with emulated('--link', link, *duration) as (process, name):
        assert name == str(link)
        assert link.is_char_device()
        if number:
            process.send_signal(number)
        _, said = process.communicate(timeout=10)
        assert process.returncode == status
    assert not link.is_symlink()
    assert re.search(r'^\d+ measurements; \d+ bytes lost', said, re.MULTILINE)
    assert 'Traceback' not in said


def test_a_host_that_does_not_read_costs_nothing():
    arguments = ('--rate', 500, '--duration', 4.0)
    with emulated(*arguments) as (process, name), serial.Serial(name):
        time.sleep(1.0)
        before = resident(process.pid)
        time.sleep(2.0)
        assert resident(process.pid) - before < 1000
        _, said = process.communicate(timeout=10)
    lost = int(re.search(r'(\d+) bytes lost', said).group(1))
    assert lost > 5000


def resident(pid):
    """Return the memory of a process [KiB]."""
    with open(f'/proc/{pid}/status') as status:
        return int(re.search(r'VmRSS:\s+(\d+)', status.read()).group(1))


def test_a_hang_up_and_the_return_under_the_same_name(tmp_path):
    link = tmp_path / 'board'
    configuration = given('--protocol', 'hex')
    arguments = ('--protocol', 'hex', '--link', link, '--faults', 'hangup:1')
    with emulated(*arguments) as (_, name):
        with pytest.raises(OSError, match=r'.'):
            read(name, decoder_of('hex', configuration), 5.0)
        assert not os.path.lexists(link)
        deadline = time.monotonic() + 5.0
        while not link.exists() and time.monotonic() < deadline:
            time.sleep(0.01)
        events = read(name, decoder_of('hex', configuration), 0.5)
    readings = [event for event in events if isinstance(event, Reading)]
    assert len(readings) > 20
    assert readings[0].clock < 50  # the board began anew


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['--protocol', 'morse'], "'morse'"),
        (['--motion', 'dance'], "'dance'"),
        (['--faults', 'drop:2'], 'drop: 2 is not allowed; a probability'),
        (['--faults', 'hangup:5'], '--faults hangup: needs --link'),
        (['--rate', '0'], '0 is not above 0'),
        (['--rate', '1e9'], 'driver.sample_rate: 1000000000.0 is not allowed'),
        (['--config', 'no.yaml'], 'no.yaml'),
        (['--link', '/no/such/folder/board'], '--link /no/such/folder/board: No such file'),
    ],
)
def test_what_is_wrong_is_said_at_the_start(arguments, words):
    run = subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, timeout=30)
    assert run.returncode == 2
    assert words in run.stderr
    assert run.stdout == ''
    assert 'Traceback' not in run.stderr
