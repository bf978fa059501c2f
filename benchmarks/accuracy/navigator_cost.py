"""What a sample costs the inertial navigator, beside one covariance propagation by numpy."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import process_time
from timeit import repeat

import numpy as np

from benchmarks.accuracy.inertial import FOOT
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.simulated_walks import measured, walk
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.batch.navigator import navigator_run
from dead_reckoning.core.blocks import ImuBlock
from dead_reckoning.core.errors import NotLevelledError
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import ImuSample
from dead_reckoning.core.smoother import Smoother

NAME = 'cost of the inertial navigator'

ROUNDS = 7
"""Each is run so often; the first warms up, then the fastest counts: others only add to it."""

STREAMING, BATCH = 10.0, 3.0
"""Goals [µs a sample]."""


def measure(output: Path) -> Report:
    """Measure a simulated walk, sample by sample and in one block, and the smoother with it."""
    block = measured(walk(strides=60), 0).block()
    samples = [block.sample(k) for k in range(len(block))]
    size = 15
    f, p, q = np.eye(size), np.eye(size), np.eye(size)
    times = {
        'sample by sample': fastest(lambda: stream(samples), len(samples)),
        'in a block': fastest(lambda: batch(block, samples), len(samples)),
        'in a block, smoothed': fastest(lambda: smoothed(block, samples), len(samples)),
        f'F P Fᵀ + Q, {size} × {size}, by numpy': fastest(
            lambda: [f @ p @ f.T + q for _ in range(1000)], 1000
        ),
    }
    report = Report('navigator-cost', f'Cost of the inertial navigator, {len(samples)} samples')
    report.add_table(
        'a sample [µs], fastest of some rounds',
        ('', ''),
        [(name, f'{took:.2f}') for name, took in times.items()],
    )
    report.figures['microseconds'] = times
    for name, most in zip(times, (STREAMING, BATCH), strict=False):
        report.aim(f'cost of a sample [µs], {name}', times[name], most)
    return report


def fastest(run: Callable[[], object], count: int) -> float:
    """Return the least time of the processor for one of ``count`` things [µs]."""
    return min(repeat(run, timer=process_time, number=1, repeat=ROUNDS)[1:]) / count * 1e6


def built() -> InertialNavigator:
    """Return a navigator for a foot."""
    navigator = Pipeline(Configuration(FOOT)).navigator
    assert navigator is not None
    return navigator


def stream(samples: list[ImuSample]) -> None:
    """Navigate sample by sample."""
    take(built(), samples)


def batch(block: ImuBlock, samples: list[ImuSample]) -> None:
    """Navigate in one block, but for the rest at the start."""
    in_a_block(built(), block, samples)


def smoothed(block: ImuBlock, samples: list[ImuSample]) -> None:
    """Navigate in one block, and go back."""
    navigator = built()
    smoother = Smoother(navigator)
    in_a_block(navigator, block, samples)
    for _ in smoother.blocks():
        pass


def in_a_block(navigator: InertialNavigator, block: ImuBlock, samples: list[ImuSample]) -> None:
    """Give what aligns it sample by sample, and all else in one block."""
    begin = 0
    while not navigator.aligned:
        take(navigator, samples[begin : begin + 1])
        begin += 1
    done, _ = navigator_run(navigator)(block, begin)
    assert begin + done == len(block)
    navigator.flush()


def take(navigator: InertialNavigator, samples: list[ImuSample]) -> None:
    """Give samples one by one."""
    for imu in samples:
        with suppress(NotLevelledError):
            navigator.update(imu)
