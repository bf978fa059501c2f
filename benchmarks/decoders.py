"""How fast protocols are read, beside the line they come over: ``python -m benchmarks.decoders``.

Each decoder reads random bytes, and what its board sends on a simulated drive, over and over, in
pieces as a port gives them; one that polls has asked for each.  Growth is what it holds more at
the end than after the first tenth, with another tenth of the bytes.
"""

from __future__ import annotations

import argparse
import gc
import sys
import time
import tracemalloc
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import cycle, islice
from math import inf

import numpy as np

from benchmarks.accuracy.report import table
from dead_reckoning.configuration import Configuration
from dead_reckoning.sources.serial import protocols
from dead_reckoning.sources.serial.protocols import Decoder, Measurement, Position, Reading
from dead_reckoning.sources.serial.settings import SerialSettings
from dead_reckoning.tools.emulate.emulator import Sensor

PIECE = 4096
"""Bytes that a port gives at once."""

PERIOD = 0.01
"""Time [s] between two measurements of the board."""

MEASUREMENTS = 2000
"""How many different ones it takes."""

TARGET = 100.0
"""Least speed, as a multiple of that of a line at the default baud."""

MOST_GROWTH = 16 * 1024
"""Most bytes that a decoder may hold more in the end."""


def random_pieces(decoder: Decoder, count: int) -> Iterator[bytes]:
    """Give so many random bytes; a decoder that polls has asked for each piece."""
    random = np.random.default_rng(1)
    for _ in range(count // PIECE):
        decoder.due(inf)
        yield random.bytes(PIECE)


@cache
def measurements(bits: int | None) -> list[Measurement]:
    """Return what a sensor measures on its way, behind an ADC of so many bits."""
    values = {'driver.motion': 'vehicle', 'driver.sample_rate': 1.0 / PERIOD}
    sensor = Sensor(Configuration(values if bits is None else {**values, 'driver.adc_bits': bits}))
    return [sensor.measure(0.0) for _ in range(MEASUREMENTS)]


def good_pieces(name: str, decoder: Decoder, count: int) -> Iterator[bytes]:
    """Give about so many bytes that a board sends while it hears what the decoder says."""
    board = protocols.board_class(name)(protocols.decoder_class(name).Settings())
    waited, sent, size = inf, b'', 0
    for measurement in cycle(measurements(protocols.decoder_class(name).BITS)):
        told = decoder.due(waited)
        waited = 0.0 if told else waited + PERIOD
        sent += board.hear(told) + board.measure(measurement)
        if told or len(sent) >= PIECE:
            yield sent
            size += len(sent)
            sent = b''
            if size >= count:
                return


def fed(decoder: Decoder, pieces: Iterable[bytes]) -> tuple[int, int, float]:
    """Feed pieces; return bytes, readings and positions, and the time taken [s]."""
    size = found = 0
    spent = 0.0
    for piece in pieces:
        begin = time.perf_counter()
        events = decoder.feed(piece)
        spent += time.perf_counter() - begin
        size += len(piece)
        found += sum(isinstance(event, (Reading, Position)) for event in events)
    return size, found, spent


def held() -> int:
    """Return the memory in use [bytes], what Python keeps to use again left out."""
    gc.collect()
    return tracemalloc.get_traced_memory()[0]


def measured(name: str, what: str, count: int) -> tuple[str, ...]:
    """Return a row of the table: its last cell says whether a target was missed."""

    def fresh(part: int) -> tuple[Decoder, Iterator[bytes]]:
        kind = protocols.decoder_class(name)
        decoder = kind(kind.Settings())
        if what == 'random':
            return decoder, random_pieces(decoder, part)
        return decoder, good_pieces(name, decoder, part)

    size, found, spent = fed(*fresh(count))
    decoder, pieces = fresh(count // 10)
    tracemalloc.start()
    try:
        fed(decoder, islice(pieces, count // 100 // PIECE))
        before = held()
        fed(decoder, pieces)
        more = held() - before
    finally:
        tracemalloc.stop()
    line = size * SerialSettings().byte_time / spent
    missed = line < TARGET or more > MOST_GROWTH
    return (
        name, what, f'{size / 1e6:.1f} MB', f'{found}', f'{size / spent / 1e6:.1f} MB/s',
        f'{line:.0f}', f'{more / 1024:.1f} KiB', 'missed' if missed else '',
    )  # fmt: skip


def main() -> int:
    """Measure; return 1 if a decoder is too slow or grows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--megabytes', type=float, default=100.0, help='of random bytes for each')
    parser.add_argument('--quick', action='store_true', help='1 MB for each, for a glance')
    parser.add_argument('--only', nargs='+', choices=protocols.names(), default=protocols.names())
    given = parser.parse_args()
    count = round(1e6 * (1.0 if given.quick else given.megabytes))
    head = ('protocol', 'bytes', 'read', 'found', 'speed', 'times the line', 'growth', '')
    rows = [
        measured(name, what, size)
        for name in given.only
        for what, size in (('random', count), ('good', count // 50))
    ]
    print(table(head, rows))
    speed = 1e-3 / SerialSettings().byte_time
    print(f'The line: {speed:.2f} kB/s. Wanted: {TARGET:.0f} times that, and no growth.')
    return int(any(row[-1] for row in rows))


if __name__ == '__main__':
    sys.exit(main())
