"""One default for sensors of 1 to 10 times the noise: simulated walks, a run, a vehicle.

The thresholds of the detector follow the noise that the alignment finds, and the gait.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.accuracy.inertial import FOOT, Recording, Way, live
from benchmarks.accuracy.report import Goal, Report
from benchmarks.accuracy.simulated_drives import VEHICLE, driven, from_its_start, shaken
from benchmarks.accuracy.simulated_walks import Walk, measured, walk

NAME = 'sensors, simulated'

TIMES = (1.0, 3.0, 10.0)
NOISE = {'force_noise': 2.5e-3, 'rate_noise': 1e-4}
"""Densities of an ordinary sensor [m/s²/√Hz, rad/s/√Hz]; ten times of that still aligns."""

GAITS: dict[str, dict[str, Any]] = {
    'slow walk': {
        'stride_time': 2.0, 'stride_length': 0.8, 'pitch': 0.7, 'shock': 8.0, 'stance': 0.45,
    },
    'walk': {},
    'run': {
        'stride_time': 0.7, 'stride_length': 2.4, 'pitch': 1.4, 'shock': 80.0, 'stance': 0.25,
    },
}  # fmt: skip
STRIDES = 20
SEEDS = 4

LENGTH, MISSED = 2.0, 5.0
"""Goals: error of the way [%], and part of the rests that is missed [%]."""


def measure(output: Path) -> Report:
    """Measure each motion with each noise, so many times."""
    report = Report('sensors', f'Sensors of other noise, simulated, {SEEDS} times each')
    rows, off, lengths, missed = [], [], [], []
    for name, gait in GAITS.items():
        true = walk(rate=100.0, strides=STRIDES, turn=0.1, **gait)
        for times in TIMES:
            ways = [walked(true, times, seed) for seed in range(SEEDS)]
            off.append(max((way.strides - STRIDES for way in ways), key=abs))
            lengths.append(max(length_error(true, way) for way in ways))
            missed.append(100.0 * max(rest_missed(true, way) for way in ways))
            cells = (f'{off[-1]:+d}', f'{lengths[-1]:.2f} %', f'{missed[-1]:.1f} %')
            rows.append((name, f'{times:g}', *cells))
    report.aim('foot, 1 to 10 times the noise (simulated), way [%]', max(lengths), LENGTH)
    exact = not any(off)
    strides = 'exact' if exact else ', '.join(f'{each:+d}' for each in off)
    report.goals.append(Goal('its strides', 'exact', strides, exact))
    drive = from_its_start(driven())
    for times in TIMES:
        ways = [driven_way(drive, times, seed) for seed in range(SEEDS)]
        worst = max(largest_error(drive, way) for way in ways)
        missed.append(100.0 * max(rest_missed(drive, way) for way in ways))
        rows.append(('vehicle', f'{times:g}', '', f'{worst:.1f} m', f'{missed[-1]:.1f} %'))
    of_vehicle = max(missed[-len(TIMES) :])
    report.aim('vehicle, rests that are missed [%]', of_vehicle, MISSED)
    head = ('', 'noise', 'strides off by', 'way or place off by', 'rest missed')
    report.add_table('worst, causal', head, rows)
    report.figures['rest_missed_percent'] = missed
    return report


def walked(true: Walk, times: float, seed: int) -> Way:
    """Navigate a walk, with so many times the noise."""
    return live(recorded(measured(true, seed, **noise(times))), FOOT)


def driven_way(true: Walk, times: float, seed: int) -> Way:
    """Navigate a drive on a road that shakes the sensor, with so many times the noise."""
    values = {**FOOT, **{f'navigator.{name}': value for name, value in VEHICLE.items()}}
    return live(recorded(shaken(true, seed, **noise(times))), values)


def noise(times: float) -> dict[str, float]:
    """Return the densities of a sensor of so many times the noise."""
    return {name: times * density for name, density in NOISE.items()}


def recorded(found: Walk) -> Recording:
    """Return what a sensor measured as a recording."""
    return Recording('', found.time, found.force, found.rate)


def rest_missed(true: Walk, way: Way) -> float:
    """Return the part of the true rests, after the alignment, that was not found."""
    rests = np.linalg.norm(true.velocity[-len(way.states) :], axis=1) < 1e-6
    return 1.0 - float(way.states.stationary[rests].mean())


def length_error(true: Walk, way: Way) -> float:
    """Return by how much the distance from start to end is wrong [%]."""
    distance = float(np.linalg.norm(true.position[-1] - true.position[0]))
    return 100.0 * abs(float(np.linalg.norm(way.end)) / distance - 1.0)


def largest_error(true: Walk, way: Way) -> float:
    """Return the largest error of the position [m]."""
    error = way.states.position - true.position[-len(way.states) :]
    return float(np.linalg.norm(error, axis=1).max())
