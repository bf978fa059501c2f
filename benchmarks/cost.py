"""What `pipeline` costs live, beside relays that compute nothing: ``python -m benchmarks.cost``.

A publisher, the candidate and a listener are processes of their own (`benchmarks.traffic`), with
reliable, deep queues between them: the stamps that come out must be those that went in, each once
and in order.  CPU time is that of all threads of the candidate, user and system, from /proc.
Candidates take turns, in another order each round, so that what else the machine does hits all.
"""

from __future__ import annotations

import argparse
import json
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any, NamedTuple

import numpy as np

from benchmarks.soak import cpu_time, resident, soak, spawned
from benchmarks.traffic import QOS
from dead_reckoning.core.errors import DeadReckoningError
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import IMU, ODOMETRY, gravity_input
from dead_reckoning.tools.warmup import warm_up

RATE = 1000.0
RATES = (200.0, RATE)
"""Where latency is looked at [Hz]."""

PATIENCE = 20.0
"""How long [s] the first Odometry may take."""

ENOUGH = 0.98
"""Part of the asked rate that a publisher has to reach."""

HIGHEST = 64_000.0
"""Rate [Hz] at which the search ends."""

PIPELINE: dict[str, Any] = {
    'pipeline.estimators': ['integrator', 'pedometer'],
    'gravity.attitude': 'rest',
}
ORIENTED = {'gravity.attitude': 'message', 'pedometer.input': IMU}
NAVIGATOR = {**PIPELINE, 'navigator.look_ahead': 0.0}  # else the last ones would wait for more
PIPELINES: dict[str, dict[str, Any]] = {
    'pipeline': PIPELINE,
    'pipeline, attitude from message': {**PIPELINE, **ORIENTED},
    'pipeline, kalman': {**PIPELINE, 'integrator.method': 'kalman'},
    'pipeline, inertial navigator': {**NAVIGATOR, 'pipeline.estimators': ['inertial_navigator']},
    'pipeline, inertial navigator and pedometer': {
        **NAVIGATOR,
        'pipeline.estimators': ['inertial_navigator', 'pedometer'],
    },
    'pipeline, inertial navigator, smoothing': {
        **NAVIGATOR,
        'pipeline.estimators': ['inertial_navigator'],
        'navigator.smoothing': True,  # odom_smoothed and path
    },
}
NOT_COMPILED = ('pipeline, kalman', 'pipeline, inertial navigator, smoothing')
HELD_TO_TARGETS = tuple(name for name in PIPELINES if name not in NOT_COMPILED)

ORDINARY, LEAN = 'ordinary relay', 'lean relay'
RELAYS = {ORDINARY: 'typed', LEAN: 'lean'}
COMPARED = ('pipeline', ORDINARY, LEAN)
TARGETS = {ORDINARY: 0.45, LEAN: 2.0}
"""Most CPU time that a message may take, as a multiple of what each relay takes."""

LOADING = 5.0
"""How long [s] after the first Odometry memory is looked at: compiled code has come by then."""

START_TARGET = 2.5
"""Most time [s] from exec to the first Odometry."""


class LostError(DeadReckoningError):
    """What came out is not one Odometry for each Imu."""


class Run(NamedTuple):
    """One stretch of traffic: how many went in, how fast, what came out, and what it cost.

    ``latency`` is from publishing to arrival [µs], ``cpu`` the time of the candidate a message
    [µs].
    """

    sent: int
    rate: float
    lost: int
    latency: np.ndarray[Any, np.dtype[np.float64]]
    cpu: float


class Session:
    """A candidate between its publisher and its listener."""

    def __init__(
        self,
        candidate: subprocess.Popen[str],
        publisher: subprocess.Popen[str],
        listener: subprocess.Popen[str],
    ) -> None:
        self.pid = candidate.pid
        self._publisher = publisher
        self._listener = listener

    def warm_up(self, seconds: float) -> None:
        """Publish until all have found each other and Odometry comes, and a while longer."""
        deadline = time.monotonic() + PATIENCE
        while self.run(RATE, 1.0).lost:
            if time.monotonic() > deadline:
                raise LostError(f'no Odometry for each Imu in {PATIENCE:g} s')
        self.run(RATE, seconds)

    def run(self, rate: float, seconds: float) -> Run:
        """Publish at a rate [Hz] and compare what comes back."""
        before = cpu_time(self.pid)
        sent = _asked(self._publisher, f'{rate} {seconds}')
        came = _asked(self._listener, f'{len(sent)}')
        after = cpu_time(self.pid)
        stamps = [stamp for stamp, _ in came]
        those = set(stamps)
        if stamps != [stamp for stamp in sent if stamp in those]:
            raise LostError('Odometry came twice, in another order than Imu, or out of nothing')
        lost = len(sent) - len(stamps)
        while lost and _asked(self._listener, f'{1 << 40}'):
            pass  # what comes still is too late, and not to be taken for the next run's
        latency = np.array([arrival - stamp for stamp, arrival in came]) * 1e-3
        reached = len(sent) / seconds
        return Run(len(sent), reached, lost, latency, 1e6 * (after - before) / len(sent))


def _asked(process: subprocess.Popen[str], line: str) -> Any:
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(line + '\n')
    process.stdin.flush()
    answer = process.stdout.readline()
    if not answer:
        raise LostError(f'{process.args!r} ended by itself')
    return json.loads(answer)


def topic_of(name: str) -> str:
    """Return the topic of the Imu that a candidate takes."""
    return gravity_input(PIPELINES.get(name, PIPELINE)['gravity.attitude'])


def command(name: str) -> list[str]:
    """Return module and arguments of a candidate."""
    if name in RELAYS:
        return ['benchmarks.relays', RELAYS[name]]
    parameters = {**PIPELINES[name], f'qos_overrides./{ODOMETRY}.publisher.depth': QOS.depth}
    subscription = f'qos_overrides./{topic_of(name)}.subscription'
    parameters |= {f'{subscription}.depth': QOS.depth, f'{subscription}.reliability': 'reliable'}
    arguments = ['dead_reckoning.nodes', 'pipeline', '--ros-args', '--log-level', 'error']
    for key, value in parameters.items():
        arguments += ['-p', f'{key}:={value}']
    return arguments


@contextmanager
def session(name: str) -> Iterator[Session]:
    """Start a candidate and both ends of its traffic."""
    with ExitStack() as stack:
        listener = stack.enter_context(spawned('benchmarks.traffic', 'listen'))
        publisher = stack.enter_context(spawned('benchmarks.traffic', 'publish', topic_of(name)))
        candidate = stack.enter_context(spawned(*command(name)))
        assert listener.stdout is not None
        listener.stdout.readline()
        yield Session(candidate, publisher, listener)


def in_turn(names: Sequence[str], rounds: int) -> Iterator[str]:
    """Yield each name once a round, in another order each round."""
    for number in range(rounds):
        yield from (names[(number + place) % len(names)] for place in range(len(names)))


def ratio(own: Sequence[float], others: Sequence[float]) -> float:
    """Return the median of the ratios of the rounds."""
    return statistics.median(a / b for a, b in zip(own, others, strict=True))


def cpu_per_message(rounds: int, seconds: float) -> list[str]:
    """Print row 1: CPU time per message at 1 kHz; return what is wrong."""
    names = [*PIPELINES, *RELAYS]
    costs: dict[str, list[float]] = {name: [] for name in names}
    lost = dict.fromkeys(names, 0)
    for name in in_turn(names, rounds):
        with session(name) as candidate:
            candidate.warm_up(2.0)
            run = candidate.run(RATE, seconds)
        costs[name].append(run.cpu)
        lost[name] += run.lost
    print(f'\n1. CPU time per message at {RATE:g} Hz, {rounds} rounds of {seconds:g} s')
    print(f'   {"":42} {"median":>8} {"spread":>13} {"/ ordinary":>11} {"/ lean":>7}   lost')
    faults = []
    for name in names:
        ratios = {relay: ratio(costs[name], costs[relay]) for relay in RELAYS}
        print(
            f'   {name:42} {statistics.median(costs[name]):5.0f} µs '
            f'{min(costs[name]):5.0f} to {max(costs[name]):4.0f} '
            f'{ratios[ORDINARY]:11.2f} {ratios[LEAN]:7.2f}   {lost[name]}'
        )
        if lost[name]:
            faults.append(f'{name}: {lost[name]} Imu without Odometry')
        if name in HELD_TO_TARGETS:
            faults += [
                f'{name}: {ratios[relay]:.2f} of the {relay}, at most {most:g} allowed'
                for relay, most in TARGETS.items()
                if ratios[relay] > most
            ]
    return faults


def highest_rate(candidate: Session, seconds: float) -> Run:
    """Search the highest rate [Hz] without loss: doubled until it fails, then halved thrice."""

    def passes(rate: float) -> Run | None:
        run = candidate.run(rate, seconds)
        return run if not run.lost and run.rate > ENOUGH * rate else None

    best = None
    rate = RATE
    while rate <= HIGHEST and (run := passes(rate)):
        best, rate = run, 2.0 * rate
    low, high = 0.5 * rate, rate
    if best is None:
        raise LostError(f'loses messages at {RATE:g} Hz already')
    if rate <= HIGHEST:
        for _ in range(3):
            middle = 0.5 * (low + high)
            run = passes(middle)
            if run:
                best, low = run, middle
            else:
                high = middle
    return best


def rates_and_latencies(rounds: int, seconds: float) -> list[str]:
    """Print row 2: highest rate without loss, and latencies; return what is wrong."""
    highest: dict[str, list[float]] = {name: [] for name in COMPARED}
    runs: dict[tuple[str, float], list[Run]] = {(n, r): [] for n in COMPARED for r in RATES}
    for name in in_turn(COMPARED, rounds):
        with session(name) as candidate:
            candidate.warm_up(2.0)
            for rate in RATES:
                runs[name, rate].append(candidate.run(rate, seconds))
            highest[name].append(highest_rate(candidate, seconds / 2.0).rate)
    print(f'\n2. Highest rate without loss, {rounds} rounds of {seconds / 2.0:g} s')
    print(f'   {"":16} {"median":>9} {"spread":>16} {"/ ordinary":>11}')
    for name in COMPARED:
        print(
            f'   {name:16} {statistics.median(highest[name]):6.0f} Hz '
            f'{min(highest[name]):6.0f} to {max(highest[name]):6.0f} '
            f'{ratio(highest[name], highest[ORDINARY]):11.2f}'
        )
    print(f'   Latency from publishing to Odometry received, {seconds:g} s, medians of the rounds')
    print(f'   {"":16} {"":>8} {"p50":>6} {"spread":>14} {"/ ordinary":>11} {"p99":>6} {"max":>6}')
    faults = []
    for (name, rate), each in runs.items():
        p50, p99, most = np.percentile([run.latency for run in each], (50.0, 99.0, 100.0), axis=1)
        ordinary = [float(np.median(run.latency)) for run in runs[ORDINARY, rate]]
        print(
            f'   {name:16} {rate:5.0f} Hz {np.median(p50):6.0f} {p50.min():5.0f} to '
            f'{p50.max():5.0f} {ratio(p50.tolist(), ordinary):11.2f} {np.median(p99):6.0f} '
            f'{np.median(most):6.0f} µs'
        )
        lost = sum(run.lost for run in each)
        if lost:
            faults.append(f'{name}: {lost} lost at {rate:.0f} Hz')
    return faults


def first_odometry(variables: Mapping[str, str]) -> tuple[float, float]:
    """Return the time from exec to the first Odometry [s], and the memory a while later [MB].

    The Imu comes already, at 1 kHz, with an attitude: nothing has to rest first.
    """
    name = 'pipeline, attitude from message'
    with (
        spawned('benchmarks.traffic', 'listen') as listener,
        spawned('benchmarks.traffic', 'publish', IMU) as publisher,
    ):
        assert listener.stdout is not None
        assert publisher.stdin is not None
        listener.stdout.readline()
        publisher.stdin.write(f'{RATE} {PATIENCE}\n')
        publisher.stdin.flush()
        start_ns = time.monotonic_ns()
        with spawned(*command(name), variables=variables) as candidate:
            while not (came := _asked(listener, '1')):
                if time.monotonic_ns() - start_ns > PATIENCE * NANOSECONDS:
                    raise LostError(f'no Odometry in {PATIENCE:g} s')
            time.sleep(LOADING)
            memory = resident(candidate.pid)
        publisher.kill()
    return (came[0][1] - start_ns) / NANOSECONDS, memory


def start_and_memory(rounds: int, minutes: float) -> list[str]:
    """Print row 3: time to the first Odometry, memory and its growth; return what is wrong."""
    with tempfile.TemporaryDirectory() as compiled:
        # What Python compiles goes there, whatever the environment says.
        cache = {'PYTHONPYCACHEPREFIX': compiled, 'PYTHONDONTWRITEBYTECODE': ''}
        cold, _ = first_odometry(cache)
        warm = [first_odometry(cache) for _ in range(rounds)]
    times = [seconds for seconds, _ in warm]
    median = statistics.median(times)
    print('\n3. Start and memory of pipeline')
    print(
        f'   exec to first Odometry: {median:.2f} s ({min(times):.2f} to {max(times):.2f}) warm, '
        f'{cold:.2f} s with nothing compiled by Python'
    )
    print(f'   resident, code loaded: {statistics.median(m for _, m in warm):.1f} MB, its own')
    faults = []
    if median > START_TARGET:
        faults.append(f'first Odometry after {median:.2f} s, at most {START_TARGET:g} allowed')
    if minutes > 0.0:
        for shape in ('pipeline', 'navigator'):
            faults += soak(shape, minutes, 30.0, RATE)
    return faults


def main() -> int:
    """Return 0 if all is as cheap as it has to be, else 1."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.cost', description=__doc__)
    parser.add_argument('--rounds', type=int, default=5)
    parser.add_argument('--seconds', type=float, default=6.0, help='how long one run takes')
    parser.add_argument('--minutes', type=float, default=10.0, help='how long memory is watched')
    parser.add_argument('--quick', action='store_true', help='one short round, no growth')
    parser.add_argument('--rows', type=int, nargs='+', choices=(1, 2, 3), default=(1, 2, 3))
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # and leave nothing running
    rounds, seconds, minutes = arguments.rounds, arguments.seconds, arguments.minutes
    if arguments.quick:
        rounds, seconds, minutes = 1, 2.0, 0.0
    rows = {
        1: lambda: cpu_per_message(rounds, seconds),
        2: lambda: rates_and_latencies(rounds, seconds),
        3: lambda: start_and_memory(rounds, minutes),
    }
    warm_up()  # else a candidate compiles while it is measured, or longer than it may
    faults = []
    for row in arguments.rows:
        try:
            faults += rows[row]()
        except DeadReckoningError as error:
            faults.append(f'row {row}: {error}')
    for fault in faults:
        print(f'FAULT    {fault}', file=sys.stderr)
    return 1 if faults else 0


if __name__ == '__main__':
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(130)
