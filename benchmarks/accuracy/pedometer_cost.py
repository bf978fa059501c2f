"""What a sample costs the pedometer, at some rates."""

from __future__ import annotations

from pathlib import Path

from benchmarks.accuracy.navigator_cost import fastest
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.trunk_walks import MMA7260QT, walked
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.core.samples import ImuSample

NAME = 'cost of the pedometer'

RATES = (50, 100, 200, 400)
"""Samples per second [Hz]."""

SUMMED = 8
"""Conversions of a sample."""

MOST = 3.0
"""Goal [µs a sample]."""


def measure(output: Path) -> Report:
    """Measure a simulated walk, sample by sample, beside AN-900's method."""
    report = Report('pedometer-cost', 'Cost of the pedometer')
    methods = {'pedometer': PedometerSettings(), 'AN-900': PedometerSettings(method='an900')}
    times: dict[str, dict[str, float]] = {}
    for rate in RATES:
        sensor = {
            **MMA7260QT,
            'driver.sample_rate': float(rate * SUMMED),
            'driver.samples_per_message': SUMMED,
        }
        samples = walked(sensor)
        times[f'{rate} Hz'] = {
            name: fastest(lambda s=settings, i=samples: stream(s, i), len(samples))
            for name, settings in methods.items()
        }
    rows = [(rate, *(f'{took:.2f}' for took in of.values())) for rate, of in times.items()]
    report.add_table('a sample [µs], fastest of some rounds', ('', *methods), rows)
    report.figures['microseconds'] = times
    for rate, of in times.items():
        report.aim(f'cost of a sample [µs], pedometer at {rate}', of['pedometer'], MOST)
    return report


def stream(settings: PedometerSettings, samples: list[ImuSample]) -> None:
    """Count sample by sample."""
    update = Pedometer(settings, settings.method_part()).update
    for imu in samples:
        update(imu)
