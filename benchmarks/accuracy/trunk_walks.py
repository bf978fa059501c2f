"""Simulated walks and runs, the sensor on the trunk, with its noise and its ADC."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.samples import ImuSample
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.tools.generate import PRESETS

START_NS = 1_700_000_000_000_000_000

ADXL330: Mapping[str, Any] = next(each for each in PRESETS if each.name == 'an900').values
"""AN-900's sensor, its y axis up: 30 Hz, 12 bits."""

MMA7260QT: Mapping[str, Any] = {
    'driver.motion': 'walk',
    'driver.range_g': 4.0,
    'driver.sample_rate': 3200.0,
    'driver.samples_per_message': 32,
}
"""100 Hz, 12 bits."""

MMA7260QT_8_BIT: Mapping[str, Any] = {**MMA7260QT, 'driver.adc_bits': 8}


def walked(
    sensor: Mapping[str, Any], seed: int = 1, after: float = 4.0, **gait: float
) -> list[ImuSample]:
    """Return the samples of a walk and of the rest ``after`` it [s].

    ``gait`` are settings of the motion.
    """
    walk = {f'driver.walk.{name}': value for name, value in gait.items()}
    configuration = Configuration({**sensor, **walk, 'driver.simulated.seed': seed})
    source = simulated_sensor(configuration, START_NS)
    motion: Any = motions.motion_class('walk')
    duration = motion(configuration[motion.Settings]).duration + after
    conversions = source.read(round(duration * configuration[DriverSettings].sample_rate))
    return list(front_end(configuration).add(conversions))
