"""Compile all kernels, and keep them: `dead-reckoning warmup`."""

from __future__ import annotations

import argparse
import time
from contextlib import suppress
from typing import Any

import numpy as np

from dead_reckoning.configuration import Configuration
from dead_reckoning.core import stationarity, step_detectors
from dead_reckoning.core.batch.navigator import navigator_run
from dead_reckoning.core.blocks import ImuBlock
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import NotLevelledError
from dead_reckoning.core.kernels import SLOW, accelerated
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.pedometer import load_kernels
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.smoother import Smoother
from dead_reckoning.live import KINDS

CHAINS: tuple[dict[str, Any], ...] = (
    {'gravity.attitude': 'rest', 'pipeline.estimators': ['integrator', 'pedometer']},
    {'gravity.attitude': 'message', 'pipeline.estimators': ['integrator']},
    {'gravity.attitude': 'estimate', 'pipeline.estimators': ['integrator']},
)
"""Settings of chains that together use all kernels."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Take none."""


def main(given: argparse.Namespace) -> int:
    """Compile, and say how long it took; return the exit status."""
    begin = time.perf_counter()
    if not accelerated():
        print(SLOW)
        return 1
    warm_up()
    print(f'all kernels are compiled and kept: {time.perf_counter() - begin:.1f} s')
    return 0


def warm_up() -> None:
    """Take each chain through two seconds of rest, which compiles what is not kept yet.

    What live chains use has a compiled function of its own.
    """
    block = rest(200)
    for values in CHAINS:
        pipeline = Pipeline(Configuration(values), blocks=True)
        for name in pipeline.inputs[:1]:
            pipeline.chain.push(name, block)
    for kind in KINDS:
        kind.compile()
    for method in step_detectors.names():
        load_kernels(method)
    for detector in stationarity.names():
        navigate(NavigatorSettings(detector=(detector,)), block)


def navigate(settings: NavigatorSettings, block: ImuBlock) -> None:
    """Take the inertial navigator through a block, and smooth it."""
    navigator = InertialNavigator(settings, CommonSettings())
    smoother, begin = Smoother(navigator), 0
    while not navigator.aligned:
        with suppress(NotLevelledError):
            navigator.update(block.sample(begin))
        begin += 1
    navigator_run(navigator)(block, begin)
    for _ in smoother.blocks():
        pass


def rest(count: int) -> ImuBlock:
    """Return samples of an Imu at rest, 100 a second."""
    nothing = np.zeros((count, 9))
    return ImuBlock(
        (1 + np.arange(count)) * (NANOSECONDS // 100),
        'imu_link',
        np.tile((0.0, 0.0, 9.8), (count, 1)),
        nothing,
        np.zeros((count, 3)),
        nothing,
        np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)),
        nothing,
    )
