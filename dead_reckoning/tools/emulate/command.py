"""The command `emulate`: a board on a pseudo-terminal, in real time."""

from __future__ import annotations

import argparse
import math
import sys
import time
from pathlib import Path
from typing import Any

from dead_reckoning.configuration import Configuration, read_values
from dead_reckoning.core.errors import InputError, SettingsError
from dead_reckoning.sources import motions
from dead_reckoning.sources.serial import protocols
from dead_reckoning.sources.serial.settings import SerialSettings
from dead_reckoning.tools.emulate import faults
from dead_reckoning.tools.emulate.emulator import Emulator
from dead_reckoning.tools.emulate.faults import Faults
from dead_reckoning.tools.emulate.port import Port
from dead_reckoning.tools.options import positive, whole

RATE = 100.0
"""Measurements a second [Hz], unless the board says how many it takes."""

GONE = 1.0
"""How long [s] a board that was pulled out is away."""

QUANTUM = 0.001
"""Shortest time [s] between two writes, unless something is heard."""

STRIDE = 0.1
"""Longest time [s] that is simulated between two looks at what is heard."""

LATE = 10.0
"""So far [s] the sensor may fall behind the clock, as on a machine that is busy."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what the command takes."""
    parser.add_argument(
        '--protocol', choices=protocols.names(), help='what the board sends; default: ascii'
    )
    parser.add_argument(
        '--motion', choices=motions.names(), help='what the sensor does; default: slide'
    )
    parser.add_argument(
        '--config', type=Path, metavar='YAML', help='parameter file, the same as of the driver'
    )
    parser.add_argument(
        '--rate', type=positive, metavar='HZ', help='measurements a second, 100 of most boards'
    )
    parser.add_argument(
        '--faults',
        type=faults.parse,
        default=Faults(),
        metavar='LIST',
        help='drop, flip, double, pause with the probability of each byte, hangup with the time '
        'between two, as drop:0.001,hangup:10',
    )
    parser.add_argument(
        '--seed', type=whole(0), metavar='N', help='of the noise of the sensor and of the faults'
    )
    parser.add_argument(
        '--duration', type=positive, default=math.inf, metavar='S', help='end after so long'
    )
    parser.add_argument(
        '--link', type=Path, metavar='PATH', help='symbolic link to the port, a name that stays'
    )


def main(given: argparse.Namespace) -> int:
    """Emulate until the time is over, Ctrl-C or SIGTERM; return the exit status."""
    if given.faults.hangup and given.link is None:
        raise InputError('--faults hangup: needs --link, the name that stays while it is away')
    configuration = configured(given)
    try:
        emulator = Emulator(configuration, given.faults)
    except SettingsError as error:
        raise InputError(str(error)) from error
    with Port(given.link) as port:
        try:  # from the name on, as whoever reads it may end this at once
            print(port.name, flush=True)
            run(emulator, port, given.faults.hangup, given.duration)
        finally:
            baud = configuration[SerialSettings].baud
            print(said(emulator, port.lost, baud), file=sys.stderr)
    return 0


def configured(given: argparse.Namespace) -> Configuration:
    """Return the settings of the file with those of the command line over them.

    Where they don't say how many bits the ADC has, it has those of the protocol.
    """
    chosen: dict[str, Any] = {
        'driver.serial.protocol': given.protocol,
        'driver.motion': given.motion,
        'driver.simulated.seed': given.seed,
    }
    try:
        values = {} if given.config is None else read_values(given.config)
        values |= {key: value for key, value in chosen.items() if value is not None}
        port = Configuration(values)[SerialSettings]
        board = protocols.board_class(port.protocol)
        values['driver.sample_rate'] = given.rate or getattr(board, 'RATE', RATE)
        bits = protocols.decoder_class(port.protocol).BITS
        if bits is not None:
            values.setdefault('driver.adc_bits', bits)
        return Configuration(values)
    except SettingsError as error:
        raise InputError(str(error)) from error


def run(emulator: Emulator, port: Port, hangup: float, duration: float) -> None:
    """Let a board and a port, which is plugged in, go on in real time."""
    begin = time.monotonic()
    emulator.switch_on(0.0)
    plugged, change = True, hangup or math.inf
    while (now := time.monotonic() - begin) < duration:
        if now >= change:
            plugged = not plugged
            change = now + (hangup if plugged else GONE)
            if plugged:
                port.plug()
                emulator.switch_on(now)
            else:
                port.unplug()
                emulator.switch_off()
        if now - emulator.next > LATE:
            raise InputError('--rate: this machine can not simulate that many measurements')
        # Not all that is due at once, so that what is heard does not wait for it.
        port.write(emulator.advance(min(now, emulator.next + STRIDE)))
        wait = min(emulator.next, change, duration) - (time.monotonic() - begin)
        heard = port.read(max(QUANTUM, wait))
        if heard:
            emulator.hear(heard, time.monotonic() - begin)


def said(emulator: Emulator, lost: int, baud: int) -> str:
    """Return what came of it."""
    text = f'{emulator.measured} measurements'
    if emulator.unsent:
        text += f'; {emulator.unsent} not sent, as the line was busy at {baud} baud'
    return text + f'; {lost} bytes lost, as nobody read them'
