"""Cost of each estimator's step: ``python -m benchmarks.estimators``.

Time of the processor, sample by sample and in blocks.  Beside them stand the update of imufusion,
and predict and update of a filterpy filter, on the same data.  Everything is measured in turn,
round after round, in one process.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks.accuracy.report import table
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.block_stages import gravity_block_stage, integrator_block_stage
from dead_reckoning.core.blocks import ImuBlock, LevelledBlock
from dead_reckoning.core.chain import Stage
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import IMU, LEVELLED, RAW, gravity_stage, integrator_stage
from dead_reckoning.tools.warmup import warm_up

RATE = 200
START_NS = 1_700_000_000_000_000_000
BLOCK = 8192
"""Samples in a block."""

STREAMED = 10_000
"""Samples that go one by one."""

Measured = Iterator[tuple[str, str, float]]
"""What was measured, how (streaming or batch), and time per sample [µs]."""


def recording(count: int) -> ImuBlock:
    """Return an Imu with gyro and attitude that swings for 5 s and rests for 5 s, in turn."""
    random = np.random.default_rng(1)
    seconds = np.arange(count) / RATE
    swing = np.where(seconds % 10.0 > 5.0, np.sin(2.0 * np.pi * 1.8 * seconds), 0.0)
    force = random.normal((0.0, 0.0, GRAVITY), 0.03, (count, 3)) + swing[:, None] * (0.5, 0.0, 2.0)
    rate = random.normal(0.0, 0.002, (count, 3)) + swing[:, None] * (0.0, 0.1, 0.0)
    unknown = np.zeros((count, 9))
    attitude = np.tile((0.0, 0.0, 0.0, 1.0), (count, 1))
    stamps = START_NS + np.arange(count) * (NANOSECONDS // RATE)
    return ImuBlock(stamps, 'imu_link', force, unknown, rate, unknown, attitude, unknown)


def timed(run: Callable[[], object], count: int) -> float:
    """Return the time of the processor that a run takes per sample [µs]."""
    begin = time.process_time()
    run()
    return (time.process_time() - begin) / count * 1e6


def push_all(stage: Stage, name: str, samples: Iterable[Any]) -> list[Any]:
    """Put samples or blocks into a stage; return what came out for the next one."""
    take = stage[name]
    return [value for sample in samples for output, value in take(sample) if output == LEVELLED]


def ours(block: ImuBlock, attitude: str, method: str) -> Measured:
    """Measure gravity removal and integrator."""
    values = {'gravity.attitude': attitude, 'integrator.method': method}
    name = IMU if attitude == 'message' else RAW
    levelled: list[Any] = []

    def gravity(stage: Stage, samples: Iterable[Any]) -> None:
        levelled[:] = push_all(stage, name, samples)

    pipeline = Pipeline(Configuration(values))
    assert pipeline.gravity is not None
    assert pipeline.integrator is not None
    stages = gravity_stage(pipeline.gravity), integrator_stage(pipeline.integrator)
    samples = [block.sample(k) for k in range(STREAMED)]
    took = timed(lambda: gravity(stages[0], samples), STREAMED)
    if method == 'trapezoid':
        yield f'gravity removal, {attitude}', 'streaming', took
    if attitude == 'rest':
        took = timed(lambda: push_all(stages[1], LEVELLED, levelled), len(levelled))
        yield f'integrator, {method}', 'streaming', took
    if method == 'kalman':
        return
    yield from in_blocks(block, values, name)


def in_blocks(block: ImuBlock, values: Mapping[str, Any], name: str) -> Measured:
    """Measure the same in blocks."""
    pipeline = Pipeline(Configuration(values))
    assert pipeline.gravity is not None
    assert pipeline.integrator is not None
    gravity = gravity_block_stage(pipeline.gravity)
    integrator = integrator_block_stage(pipeline.integrator)
    spent = [0.0, 0.0]
    for begin in range(0, len(block), BLOCK):
        part = block.part(begin, begin + BLOCK)
        start = time.process_time()
        levelled: list[LevelledBlock] = push_all(gravity, name, [part])
        middle = time.process_time()
        push_all(integrator, LEVELLED, levelled)
        end = time.process_time()
        spent[0] += middle - start
        spent[1] += end - middle
    per_sample = [seconds / len(block) * 1e6 for seconds in spent]
    yield f'gravity removal, {values["gravity.attitude"]}', 'batch', per_sample[0]
    if values['gravity.attitude'] == 'rest':
        yield f'integrator, {values["integrator.method"]}', 'batch', per_sample[1]


ALONE: dict[str, dict[str, Any]] = {
    'pedometer': {'pedometer.heading': 'none'},
    'inertial_navigator': {'navigator.input': RAW},
}
"""Estimators that take the Imu themselves, with settings."""


def alone(block: ImuBlock, name: str) -> Measured:
    """Measure one of these."""
    values = {'pipeline.estimators': [name], **ALONE[name]}
    samples = [block.sample(k) for k in range(STREAMED)]
    chain = Pipeline(Configuration(values)).chain
    took = timed(lambda: [chain.push(RAW, sample) for sample in samples], STREAMED)
    yield name, 'streaming', took
    chain = Pipeline(Configuration(values), blocks=True).chain
    parts = [block.part(begin, begin + BLOCK) for begin in range(0, len(block), BLOCK)]
    yield name, 'batch', timed(lambda: [chain.push(RAW, p) for p in parts], len(block))


def filterpy(block: ImuBlock) -> Measured:
    """Measure predict and update of a filter with six states and three measurements."""
    from filterpy.kalman import KalmanFilter

    kalman = KalmanFilter(dim_x=6, dim_z=3)
    kalman.F = np.eye(6) + np.eye(6, k=3) / RATE
    kalman.H = np.eye(3, 6)
    measurements = block.specific_force[:STREAMED]

    def run() -> None:
        for z in measurements:
            kalman.predict()
            kalman.update(z)

    yield 'filterpy, predict and update, 6 states, 3 measured', 'streaming', timed(run, STREAMED)


def imufusion(block: ImuBlock) -> Measured:
    """Measure imufusion's update, and with it the acceleration in the world."""
    if find_spec('imufusion') is None:
        return
    fusion = import_module('imufusion')
    ahrs = fusion.Ahrs()
    ahrs.set_sample_period(1.0 / RATE)
    # Its units are °/s and g.
    rates = list(np.degrees(block.angular_velocity[:STREAMED]))
    forces = list(block.specific_force[:STREAMED] / GRAVITY)
    pairs = list(zip(rates, forces, strict=True))

    def update() -> None:
        for rate, force in pairs:
            ahrs.update_no_magnetometer(rate, force)

    def update_and_ask() -> None:
        for rate, force in pairs:
            ahrs.update_no_magnetometer(rate, force)
            ahrs.get_earth_acceleration()
            ahrs.get_quaternion()

    yield 'imufusion, update', 'streaming', timed(update, STREAMED)
    yield 'imufusion, update, acceleration, attitude', 'streaming', timed(update_and_ask, STREAMED)


def measure(block: ImuBlock, rounds: int) -> dict[tuple[str, str], list[float]]:
    """Measure all in turn, so many times; return the times by name and way."""
    found: dict[tuple[str, str], list[float]] = {}
    for _ in range(rounds):
        for measured in (
            ours(block, 'rest', 'trapezoid'),
            ours(block, 'message', 'trapezoid'),
            ours(block, 'estimate', 'trapezoid'),
            ours(block, 'rest', 'kalman'),
            *(alone(block, name) for name in ALONE),
            imufusion(block),
            filterpy(block),
        ):
            for name, way, took in measured:
                found.setdefault((name, way), []).append(took)
    return found


def written(times: Sequence[float] | None) -> str:
    """Write median and spread."""
    if times is None:
        return ''
    return f'{np.median(times):.2f} ({min(times):.2f} to {max(times):.2f})'


def main() -> None:
    """Print a table: median, least and most of the rounds."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.estimators', description=__doc__)
    parser.add_argument('--samples', type=int, default=720_000, help='samples in blocks')
    parser.add_argument('--rounds', type=int, default=5, help='how often each is measured')
    parser.add_argument('--quick', action='store_true', help='a tenth of it, in one round')
    given = parser.parse_args()
    samples, rounds = (given.samples // 10, 1) if given.quick else (given.samples, given.rounds)
    if find_spec('imufusion') is None:
        print('imufusion is left out, as it is not installed: pip install imufusion')
    warm_up()
    found = measure(recording(samples), rounds)
    names = dict.fromkeys(name for name, _ in found)
    rows = [
        (name, *(written(found.get((name, way))) for way in ('streaming', 'batch')))
        for name in names
    ]
    print(table(('µs a sample', 'sample by sample', 'in blocks'), rows))


if __name__ == '__main__':
    main()
