"""Distances of simulated walks and runs by each model, calibrated at another pace."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from benchmarks.accuracy.report import Report
from benchmarks.accuracy.step_lengths import judged
from benchmarks.accuracy.trunk_walks import ADXL330, MMA7260QT, MMA7260QT_8_BIT, walked
from dead_reckoning.core.pedometer import PedometerSettings
from dead_reckoning.core.step_calibration import AllModels

NAME = 'step lengths at other paces, simulated'

SENSORS = {
    'ADXL330, 12 bits, 30 Hz': ADXL330,
    'MMA7260QT, 12 bits, 100 Hz': MMA7260QT,
    'MMA7260QT, 8 bits, 100 Hz': MMA7260QT_8_BIT,
}


class Gait(NamedTuple):
    """Steps of ``length`` [m] at ``calibrated`` [Hz], growing with a ``power`` of the cadence."""

    calibrated: float
    cadences: tuple[float, ...]
    length: float
    power: float


WALKING = (0.8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5)
GAITS = {
    'walks, steps alike at every pace': Gait(1.75, WALKING, 0.7, 0.0),
    'walks, steps as the root of the cadence': Gait(1.75, WALKING, 0.7, 0.5),
    'runs, steps alike at every pace': Gait(2.75, (2.5, 2.75, 3.0, 3.3), 1.1, 0.0),
}

STEPS = 60
MOST = 3.0
"""Goal [% of the distance]; AN-900 has 6 %."""


def measure(output: Path) -> Report:
    """Walk each at all paces, through each sensor."""
    report = Report('paces', f'Distance of {STEPS} steps after calibration at one pace, simulated')
    names = AllModels().names
    default = PedometerSettings().length_model
    for caption, gait in GAITS.items():
        errors: dict[str, dict[str, list[float]]] = {name: {} for name in names}
        for sensor, values in SENSORS.items():
            ks: dict[str, dict[float, float]] = {name: {} for name in names}
            for cadence in gait.cadences:
                length = gait.length * (cadence / gait.calibrated) ** gait.power
                samples = walked(values, cadence=cadence, step_length=length, steps=STEPS)
                for name, total in judged(samples).totals().items():
                    ks[name][cadence] = STEPS * length / total
            for name, k in ks.items():
                errors[name][sensor] = [
                    100.0 * (k[gait.calibrated] / k[cadence] - 1.0) for cadence in gait.cadences
                ]
        report.add_table(
            f'{caption}, {gait.cadences[0]:g} to {gait.cadences[-1]:g} Hz, calibrated at '
            f'{gait.calibrated:g} Hz: error of the distance',
            ('', *SENSORS),
            [
                (
                    f'{name}{" (default)" if name == default else ""}',
                    *(f'{min(e):+.1f} … {max(e):+.1f} %' for e in of_all.values()),
                )
                for name, of_all in errors.items()
            ],
        )
        worst = max(abs(error) for of_one in errors[default].values() for error in of_one)
        report.aim(f'{caption} (simulated), distance [%]', worst, MOST, '{:.1f}')
        report.figures[caption] = errors
    return report
