"""Time of `replay` beside only reading the recording: ``python -m benchmarks.replay_speed``.

The recording is an hour of the simulated sensor at 200 Hz, 720,000 Imu in mcap: a square that it
goes round for a while, and rests.  Reading takes each raw message once with rosbags.  Each is a
process of its own, the start of Python in it, warm caches; they take turns, round after round.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.accuracy.report import table
from dead_reckoning.block_wire import encode_imus
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.blocks import ImuBlock
from dead_reckoning.core.stages import RAW
from dead_reckoning.sources.bags import IMU, BagWriter
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.tools.warmup import warm_up

CONFIG = Path(__file__).parents[1] / 'config' / 'mma7260qt.yaml'
START_NS = 1_700_000_000_000_000_000
HOUR = 720_000
BLOCK = 10_000

READING = """
import sys
from pathlib import Path
from rosbags.rosbag2 import Reader
with Reader(Path(sys.argv[1])) as reader:
    print(sum(1 for _ in reader.messages()))
"""

TARGETS = {'summary': 2.5, 'summary,odometry': 4.0}
"""Most time that these outputs may take, as a multiple of reading."""

EVERYTHING = 'all'
"""All outputs that there are, the report and the bag among them; measured once."""


def record(path: Path, count: int) -> None:
    """Write a recording of the simulated sensor at 200 Hz."""
    configuration = Configuration(
        {'driver.sample_rate': 200.0, 'driver.motion': 'square', 'driver.samples_per_message': 1}
    )
    source, front = simulated_sensor(configuration, START_NS), front_end(configuration)
    writer = BagWriter(path, {f'/{RAW}': (IMU, False)})
    left = count
    while left:
        samples = front.add(source.read(min(BLOCK, left)))
        if not samples:
            continue  # the sensor is being calibrated
        samples = samples[:left]
        left -= len(samples)
        block = ImuBlock.of(samples)
        for stamp_ns, message in zip(block.stamp_ns.tolist(), encode_imus(block), strict=True):
            writer.write(f'/{RAW}', stamp_ns, message)
    writer.close()


def timed(command: Sequence[str]) -> float:
    """Return how long a process takes [s]."""
    begin = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return time.perf_counter() - begin


def main() -> int:
    """Print the table; return 1 where a target is missed."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.replay_speed')
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--quick', action='store_true', help='a tenth of it, in one round')
    given = parser.parse_args()
    count, rounds = (HOUR // 10, 1) if given.quick else (HOUR, given.rounds)
    warm_up()
    missed = []
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / 'recording'
        record(bag, count)
        replay = [sys.executable, '-m', 'dead_reckoning.tools.main', 'replay', str(bag)]
        replay += ['--config', str(CONFIG), '--output', f'{folder}/out']
        commands = {
            'reading': [sys.executable, '-c', READING, str(bag)],
            **{outputs: [*replay, '--outputs', outputs] for outputs in TARGETS},
            EVERYTHING: replay,
        }
        seconds: dict[str, list[float]] = {name: [] for name in commands}
        for number in range(rounds):
            for name, command in commands.items():
                if name != EVERYTHING or number == 0:
                    seconds[name].append(timed(command))
    rows = []
    for name, times in seconds.items():
        ratios = [taken / reading for taken, reading in zip(times, seconds['reading'])]  # noqa: B905
        ratio = statistics.median(ratios)
        target = None if given.quick else TARGETS.get(name)  # which hold for an hour
        if target is not None and ratio > target:
            missed.append(name)
        rows.append(
            (
                name,
                f'{statistics.median(times):.2f} s',
                f'{ratio:.2f} ({min(ratios):.2f} to {max(ratios):.2f})',
                '' if target is None else f'at most {target:g}',
            )
        )
    print(table((f'replay of {count} Imu', 'time', 'of reading', 'target'), rows))
    return 1 if missed else 0


if __name__ == '__main__':
    sys.exit(main())
