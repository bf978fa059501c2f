"""Simulated walks and runs, from slow to fast, through noisy sensors and ADCs of 12 and 8 bits."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.accuracy.report import Report
from benchmarks.accuracy.step_counters import PEDOMETER, Walk, count
from benchmarks.accuracy.trunk_walks import ADXL330, MMA7260QT, MMA7260QT_8_BIT, walked
from benchmarks.accuracy.walks import spread

NAME = 'steps, simulated'

SENSORS = {
    'ADXL330, 12 bits, 30 Hz': ADXL330,
    'MMA7260QT, 12 bits, 100 Hz': MMA7260QT,
    'MMA7260QT, 8 bits, 100 Hz': MMA7260QT_8_BIT,
}

WALKS = (0.8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5)
RUNS = (2.5, 2.75, 3.0, 3.3)
"""Steps per second [Hz]."""

WALK_LENGTH, RUN_LENGTH = 0.7, 1.1
"""Lengths of a step [m]."""

OTHERS = ((1.5, 0.5), (1.5, 0.9), (2.0, 0.5), (2.0, 0.9))
"""Steps per second [Hz] and lengths [m] of gentle and hard walks."""

STEPS = 60
SEEDS = (1, 2)


def measure(output: Path) -> Report:
    """Count each walk and run so many times, with other noise and errors of the sensor."""
    report = Report('simulated-steps', f'{STEPS} steps, simulated, {len(SEEDS)} times each')
    gaits = [('walk', cadence, WALK_LENGTH) for cadence in WALKS]
    gaits += [('walk', *other) for other in OTHERS]
    gaits += [('run', cadence, RUN_LENGTH) for cadence in RUNS]
    for sensor, values in SENSORS.items():
        rows = []
        errors: dict[str, list[float]] = {}
        for kind, cadence, length in gaits:
            found: dict[str, list[int]] = {}
            for seed in SEEDS:
                samples = walked(values, seed, cadence=cadence, step_length=length, steps=STEPS)
                stamps_ns = np.array([imu.stamp_ns for imu in samples])
                force_s = np.array([imu.specific_force for imu in samples])
                counted = count(Walk(f'{kind} {cadence} {length}', STEPS, stamps_ns, force_s))
                for name, steps in counted.found.items():
                    found.setdefault(name, []).append(len(steps))
                    errors.setdefault(name, []).append(len(steps) - STEPS)
            numbers = (', '.join(map(str, counted)) for counted in found.values())
            rows.append((f'{kind}, {cadence:g} Hz, {length:g} m', *numbers))
        report.add_table(f'steps counted of {STEPS}: {sensor}', ('', *errors), rows)
        report.figures[sensor] = {name: spread(of_all) for name, of_all in errors.items()}
        worst = report.figures[sensor][PEDOMETER]['worst']
        report.aim(f'{sensor} (simulated), worst [steps]', worst, 0, '{:.0f}')
    return report
