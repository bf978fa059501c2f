"""Stamps by the clock of a board beside those by arrival: ``python -m benchmarks.stamps``.

A board measures at a steady rate by a clock that is 50 ppm off and numbers what it sends; an
adapter hands over what has come every 16 ms, by a clock of its own, and the host wakes up a little
later.  Readings get lost, one by one and in bursts.  docs/serial.md has the figures.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.sources.serial.board_clock import BoardClock
from dead_reckoning.tools.table import table

Array = NDArray[np.float64]

START_NS = 1_700_000_000 * NANOSECONDS
RATES = (50.0, 100.0, 200.0, 500.0)
HELD = 0.016
"""How long the adapter holds bytes [s]."""
ADAPTER_SKEW = 20e-6
"""Relative error of the adapter's clock."""
WAKING = 0.0002
"""Mean time in which the host wakes up [s]; exponential."""
LOST, BURSTS, BURST = 0.02, 0.0005, 20
"""Share of readings that get lost alone, and share at which a burst begins, of so many."""
SETTLING = 180.0
"""What is shown apart [s]: readings and adapter are nearly in step, and until they have slipped by
one another once, nothing tells the least delay there was from none."""
FRAME = 14 * 10 / 115_200
"""How long a reading is on the wire [s]."""


@dataclass(frozen=True)
class Way:
    """Readings that came, shapes (n,).

    ``number`` counts those that were lost too; ``true`` is when each was measured, ``arrival``
    when its first bit seems to have come, both [s] from the start.
    """

    number: Array
    true: Array
    arrival: Array


def way(rate: float, duration: float, skew: float = 50e-6, seed: int = 1) -> Way:
    """Send readings over the simulated way; ``rate`` [Hz], ``duration`` [s]."""
    random = np.random.default_rng(seed)
    number = np.arange(round(rate * duration), dtype=float)
    lost = random.random(len(number)) < LOST
    for begin in np.flatnonzero(random.random(len(number)) < BURSTS):
        lost[begin : begin + BURST] = True
    number = number[~lost]
    true = number / rate * (1.0 + skew)
    period = HELD * (1.0 + ADAPTER_SKEW)
    phase = random.random()
    turn = np.ceil((true + FRAME) / period - phase)  # that of the last bit
    handed = (turn + phase) * period
    woken = handed + random.exponential(WAKING, int(turn[-1]) + 1)[turn.astype(int)]
    # Of those handed over together the last has just come, the others before it, one by one.
    last = np.searchsorted(turn, turn, side='right') - 1
    arrival = np.maximum.accumulate(woken) - (last - np.arange(len(turn)) + 1) * FRAME
    return Way(number, true, arrival)


def stamps(sent: Way) -> Array:
    """Return the stamps by the clock of the board, shape (n,) [s] from the start."""
    clock = BoardClock()
    found = [
        clock.stamp(number, START_NS + round(arrival * NANOSECONDS))
        for number, arrival in zip(sent.number.tolist(), sent.arrival.tolist(), strict=True)
    ]
    return (np.array(found) - START_NS) / NANOSECONDS


def spread(error: Array) -> float:
    """Return the RMS of an error after its mean, which no way in one direction can show."""
    return float(np.std(error))


def rms(error: Array) -> float:
    """Return the RMS of an error, its mean in it."""
    return float(np.sqrt(np.mean(np.square(error))))


def rows(duration: float, seeds: int) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table: for each rate the RMS over all seeds [ms]."""
    for rate in RATES:
        parts: dict[str, list[tuple[float, float]]] = {'all': [], 'first': [], 'then': []}
        for seed in range(1, seeds + 1):
            sent = way(rate, duration, seed=seed)
            ours = stamps(sent) - sent.true
            raw = sent.arrival - sent.true
            parts['all'].append((rms(raw), rms(ours)))
            first = sent.true < SETTLING
            for name, part in (('first', first), ('then', ~first)):
                parts[name].append((spread(raw[part]), spread(ours[part])))
        cells = [f'{rate:.0f}']
        for name in ('all', 'first', 'then'):
            raw_rms, our_rms = np.sqrt(np.mean(np.square(parts[name]), axis=0)) * 1e3
            cells += [f'{raw_rms:.2f}', f'{our_rms:.3f}', f'{our_rms / raw_rms:.3f}']
        yield tuple(cells)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition('\n')[0])
    parser.add_argument(
        '--duration', type=float, default=600.0, help=f'of a run [s], more than {SETTLING:.0f}'
    )
    parser.add_argument('--seeds', type=int, default=5, help='runs at each rate')
    options = parser.parse_args()
    head = ('Hz', 'RMS, all: arrival [ms]', 'stamp [ms]', 'ratio',
            f'after the mean, first {SETTLING:.0f} s: arrival [ms]', 'stamp [ms]', 'ratio',
            'then: arrival [ms]', 'stamp [ms]', 'ratio')  # fmt: skip
    print(table(head, list(rows(options.duration, options.seeds))))


if __name__ == '__main__':
    main()
