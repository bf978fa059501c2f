"""Simulated slides of a phone without a gyroscope: ``python -m benchmarks.slides --runs 100``.

A phone lies on a tilted table; a hand that trembles pushes it 0.3 to 1 m along one of its axes,
with rests before and after.  Everything is drawn from the seed; the settings of the chain are the
defaults.  docs/integrator.md, "Slides", has the figures.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import NavigationState
from dead_reckoning.core.stages import ODOMETRY, RAW
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.tools.table import table

Array = NDArray[np.float64]

START_NS = 1_700_000_000_000_000_000

REST = 2.0
"""Rest before the slide and after it [s]."""

TILT = 3.0
"""Largest tilt of the table [°]."""

SPEEDS = (0.3, 0.8)
"""Mean speed of a slide [m/s], from which its duration follows."""

LETS_GO = 0.2
"""How long after the slide the hand lets go, where it does [s]."""


@dataclass(frozen=True)
class Result:
    """How a slide of ``distance`` [m] ended: ``error`` and ``deviation``, shapes (3,) [m].

    Both count from the first state, that is, from the levelling on.
    """

    error: Array
    deviation: Array
    distance: float
    stationary: bool

    @property
    def share(self) -> float:
        """Error of the displacement as a part of it."""
        return float(np.linalg.norm(self.error)) / self.distance

    @property
    def covered(self) -> bool:
        """Whether the error along each axis is within three published deviations."""
        return bool((np.abs(self.error) <= 3.0 * self.deviation).all())


def slide(seed: int, lets_go: bool = False, **values: Any) -> Result:
    """Slide once; ``values`` are settings of the sensor or of the chain by their full keys."""
    random = np.random.default_rng(seed)
    distance = random.uniform(0.3, 1.0)
    duration = distance / random.uniform(*SPEEDS)
    tilt, towards = np.radians(random.uniform(0.0, TILT)), random.uniform(0.0, 2.0 * np.pi)
    configuration = Configuration(
        {
            'driver.range_g': 2.0,
            'driver.adc_bits': 12,
            'driver.slide.distance': distance * random.choice([-1.0, 1.0]),
            'driver.slide.duration': duration,
            'driver.slide.start': REST,
            'driver.slide.axis': str(random.choice(['x', 'y'])),
            'driver.simulated.seed': seed,
            'driver.simulated.attitude': (tilt * np.cos(towards), tilt * np.sin(towards), 0.0),
            'driver.simulated.offset': random.uniform(-0.5, 0.5, 3),
            'driver.simulated.sensitivity_error': random.uniform(-0.01, 0.01, 3),
            'driver.hand.enabled': True,
            **({'driver.hand.release': REST + duration + LETS_GO} if lets_go else {}),
            **values,
        }
    )
    source = simulated_sensor(configuration, START_NS)
    chain = Pipeline(configuration).chain
    count = round((REST + duration + REST) * configuration[DriverSettings].sample_rate)
    states: list[NavigationState] = [
        output
        for sample in front_end(configuration).add(source.read(count))
        for name, output in chain.push(RAW, sample)
        if name == ODOMETRY
    ]
    first, last = states[0], states[-1]
    moved = np.subtract(
        source.truth(last.stamp_ns).position, source.truth(first.stamp_ns).position
    )
    return Result(
        np.subtract(last.position, moved),
        np.sqrt(last.position_covariance[::4]),
        distance,
        last.stationary,
    )


CALIBRATED = {
    'driver.calibrate_on_start': False,
    'driver.simulated.offset': (0.06, -0.05, 0.08),
}
"""Calibrated on a level table before: what is left of the offsets."""

CASES: Mapping[str, Mapping[str, Any]] = {
    'no hand': {'driver.hand.enabled': False},
    'lets go after the slide': {'lets_go': True},
    'stays': {},
    'stays, calibrated level': CALIBRATED,
    'stays, movement_end off': {'integrator.movement_end': 'off'},
    'stays, trembles a lot': {'driver.hand.tremor': 0.25},
    'no hand, ±6 g': {'driver.hand.enabled': False, 'driver.range_g': 6.0},
}

METHODS = ('trapezoid', 'kalman')


def main() -> None:
    """Print a table of all cases and methods."""
    parser = argparse.ArgumentParser(prog='python -m benchmarks.slides', description=__doc__)
    parser.add_argument('--runs', type=int, default=100, help='seeds for each line')
    runs = parser.parse_args().runs
    head = ('hand', 'method', 'median', '95 %', 'most', 'within 3σ', 'at rest in the end')
    rows = []
    for name, values in CASES.items():
        for method in METHODS:
            results = [
                slide(seed, **{'integrator.method': method, **values}) for seed in range(runs)
            ]
            share = 100.0 * np.array([result.share for result in results])
            covered = np.mean([result.covered for result in results])
            rests = np.mean([result.stationary for result in results])
            rows.append(
                (
                    name if method == METHODS[0] else '',
                    method,
                    f'{np.median(share):.1f} %',
                    f'{np.percentile(share, 95):.1f} %',
                    f'{share.max():.1f} %',
                    f'{100 * covered:.0f} %',
                    f'{100 * rests:.0f} %',
                )
            )
    print(table(head, rows))


if __name__ == '__main__':
    main()
