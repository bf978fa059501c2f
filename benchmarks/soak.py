"""Memory and CPU of nodes that run for long at a high rate: ``python -m benchmarks.soak``.

A feeder of its own publishes `imu/data_raw` over DDS, an Imu with a gyro that swings and rests in
turn.  Of each node the resident memory and the CPU time are read from /proc once a second.  Growth
is the slope of a robust line (Theil and Sen: the median of the slopes between all pairs) through
the memory after the warm-up, times the time that it covers.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.errors import DeadReckoningError
from dead_reckoning.tools.processes import Nodes, environment, interruptible

ROOT = Path(__file__).parents[1]
WALK: dict[str, Any] = {'pipeline.estimators': ['integrator', 'pedometer']}
ESTIMATE: dict[str, Any] = {'gravity.attitude': 'estimate'}
SHAPES: dict[str, dict[str, dict[str, Any]]] = {
    'pipeline': {'pipeline': {**WALK, 'gravity.attitude': 'rest'}},
    'navigator': {'pipeline': {'pipeline.estimators': ['inertial_navigator']}},
    'stream': {'pipeline': {**WALK, **ESTIMATE}},
    'nodes': {'gravity_removal': ESTIMATE, 'integrator': {}, 'pedometer': {}},
}
"""Nodes, with their parameters, that take the whole way: in one process, compiled or, as there is
no kernel for that attitude, as a stream; or each in a process of its own."""
LISTENERS = {'nodes': 2}
"""Subscriptions of `imu/data_raw`, where it is not one."""
MEGABYTE = 1 << 20
LIMIT = 1.0
"""Growth [MB] that a run may show."""
SHARE = 0.9
"""Part of the samples that has to come through; best-effort queues lose some on a busy machine."""


@dataclass
class Process:
    """Memory and CPU time of a process, as sampled."""

    name: str
    pid: int
    times: list[float] = field(default_factory=list)
    memory: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)

    def sample(self) -> None:
        """Read /proc: time [s], resident memory [MB], CPU time so far [s]."""
        self.times.append(time.monotonic())
        self.memory.append(resident(self.pid))
        self.cpu.append(cpu_time(self.pid))

    def after(self, warm_up: float) -> tuple[NDArray[np.float64], ...]:
        """Return times from the start, memory and CPU time, without the first ``warm_up`` [s]."""
        times = np.array(self.times) - self.times[0]
        kept = times >= warm_up
        return times[kept], np.array(self.memory)[kept], np.array(self.cpu)[kept]


def resident(pid: int) -> float:
    """Return the memory that a process alone has in RAM [MB].

    Shared memory of DDS and libraries is left out; where the kernel does not tell, it is in.
    """
    try:
        text = Path(f'/proc/{pid}/smaps_rollup').read_text(encoding='utf-8')
        kinds = ('Private_Clean', 'Private_Dirty')
        kilobytes = sum(int(re.search(rf'{kind}:\s+(\d+)', text)[1]) for kind in kinds)  # type: ignore[index]
        return kilobytes / 1024.0
    except (OSError, TypeError):
        pages = int(Path(f'/proc/{pid}/statm').read_text(encoding='utf-8').split()[1])
        return pages * os.sysconf('SC_PAGE_SIZE') / MEGABYTE


def cpu_time(pid: int) -> float:
    """Return the CPU time [s] that a process has used, in user and system mode."""
    words = Path(f'/proc/{pid}/stat').read_text(encoding='utf-8').rpartition(')')[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf('SC_CLK_TCK')


def growth(times: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Return by how much values grow over the times, along the line of Theil and Sen.

    A step that lasts shorter than 29 % of the time, or single outliers, do not move it.
    """
    first, second = np.triu_indices(len(times), 1)
    slopes = (values[second] - values[first]) / (times[second] - times[first])
    return float(np.median(slopes) * (times[-1] - times[0]))


@contextmanager
def spawned(
    module: str, *arguments: str, variables: Mapping[str, str] | None = None
) -> Iterator[subprocess.Popen[str]]:
    """Run a module as a process of its own, with more environment; it ends with the context."""
    with subprocess.Popen(
        [sys.executable, '-m', module, *arguments],
        cwd=ROOT,
        env={**os.environ, **environment(), **(variables or {})},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,  # Ctrl-C is for this process, which ends them
    ) as process:
        try:
            yield process
        finally:
            process.terminate()
            try:
                process.wait(5.0)
            except subprocess.TimeoutExpired:
                process.kill()


def soak(shape: str, minutes: float, warm_up: float, rate: float) -> list[str]:
    """Run the nodes, print a line for each, and return what is wrong."""
    faults = []
    with (
        interruptible() as interruption,
        Nodes(environment()) as nodes,
        spawned('benchmarks.feeder', str(rate), str(LISTENERS.get(shape, 1))) as feed,
    ):
        for name, parameters in SHAPES[shape].items():
            nodes.start(name, parameters)
        assert feed.stdin is not None
        assert feed.stdout is not None
        feed.stdout.readline()  # all have found each other, and messages go out
        processes = [Process(name, pid) for name, pid in nodes.pids.items()]
        begun = time.monotonic()
        while time.monotonic() < begun + 60.0 * minutes:
            for process in processes:
                process.sample()
            interruption.check()
            nodes.check()
            time.sleep(1.0)
        for process in processes:
            process.sample()
        lasted = time.monotonic() - begun
        feed.stdin.close()
        sent, received = map(int, feed.stdout.read().split())
    print(f'{shape}: {sent} Imu in {lasted:.0f} s ({sent / lasted:.0f} Hz), {received} Odometry')
    if received < SHARE * sent:
        faults.append(f'{shape}: {received} Odometry of {sent} Imu: is the machine busy?')
    for process in processes:
        times, memory, cpu = process.after(warm_up)
        grown = growth(times, memory)
        used = (cpu[-1] - cpu[0]) / (times[-1] - times[0])
        print(
            f'  {process.name:16} memory {memory[0]:6.1f} to {memory[-1]:6.1f} MB, '
            f'growth {grown:+.3f} MB in {times[-1] - times[0]:.0f} s; '
            f'CPU {100.0 * used:.1f} % of a core, {1e6 * used * lasted / sent:.0f} µs per sample'
        )
        if grown > LIMIT:
            faults.append(f'{process.name}: memory grew by {grown:.2f} MB')
    return faults


def main() -> int:
    """Return 0 if all went well, 1 if memory grew or samples were lost."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.soak', description=__doc__)
    parser.add_argument('--minutes', type=float, default=10.0, help='how long, warm-up included')
    parser.add_argument('--warm-up', type=float, default=30.0, help='seconds left out at first')
    parser.add_argument('--rate', type=float, default=1000.0, help='samples per second')
    parser.add_argument('--shape', choices=[*SHAPES], action='append', help='default: pipeline')
    arguments = parser.parse_args()
    if 60.0 * arguments.minutes < arguments.warm_up + 3.0:
        parser.error('--minutes: shorter than the warm-up; give more minutes, or --warm-up 0')
    faults = []
    for shape in arguments.shape or ['pipeline']:
        try:
            faults += soak(shape, arguments.minutes, arguments.warm_up, arguments.rate)
        except DeadReckoningError as error:
            faults.append(f'{shape}: {error}')
    for fault in faults:
        print(f'FAULT    {fault}', file=sys.stderr)
    return 1 if faults else 0


if __name__ == '__main__':
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
