"""All parts' settings in one place, and the YAML files that hold them.

A file is what ROS takes: one section ``/**: ros__parameters:``, every key with the prefix of its
part.  The nodes get the same values from rcl; tools read the file here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import yaml

from dead_reckoning.core import stationarity, step_detectors
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.compass import CompassSettings
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.parameters import Settings, refuse_unknown
from dead_reckoning.core.pedometer import PedometerSettings
from dead_reckoning.core.pipeline import PipelineSettings
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.hand import HandSettings
from dead_reckoning.sources.i2c.adxl345 import I2cSettings
from dead_reckoning.sources.i2c.hmc6352 import Hmc6352Settings
from dead_reckoning.sources.iio.settings import IioSettings
from dead_reckoning.sources.serial import protocols
from dead_reckoning.sources.serial.settings import SerialSettings
from dead_reckoning.sources.simulated import SimulatedSettings
from dead_reckoning.sources.simulated_compass import SimulatedCompassSettings
from dead_reckoning.sources.simulated_gyroscope import GyroSettings

SettingsType = TypeVar('SettingsType', bound=Settings)

COMMON = (CommonSettings, FrameSettings)
"""Parts that every node declares."""

DRIVER = (
    DriverSettings,
    SimulatedSettings,
    GyroSettings,
    HandSettings,
    IioSettings,
    I2cSettings,
    SerialSettings,
    *(protocols.decoder_class(name).Settings for name in protocols.names()),
    *(motions.motion_class(name).Settings for name in motions.names()),
)
"""Parts of the accelerometer driver."""

COMPASS = (CompassSettings, SimulatedCompassSettings, Hmc6352Settings)
"""Parts of the compass driver."""

PEDOMETER = (
    PedometerSettings,
    *(step_detectors.detector_class(name).Settings for name in step_detectors.names()),
)
"""Parts of the pedometer."""

NAVIGATOR = (
    NavigatorSettings,
    *(stationarity.detector_class(name).Settings for name in stationarity.names()),
)
"""Parts of the inertial navigator."""

PARTS: tuple[type[Settings], ...] = (
    *DRIVER,
    *COMPASS,
    GravitySettings,
    IntegratorSettings,
    *PEDOMETER,
    *NAVIGATOR,
    PipelineSettings,
    *COMMON,
)
"""All parts, in the order of the reference page."""


DRIVER_SOURCES = next(p.choices for p in DriverSettings.parameters() if p.name == 'source')
"""Where a driver's samples may come from."""


class _Loader(yaml.SafeLoader):
    """Read scalars as rcl does: 1e-3 is a number, and y and n are booleans."""

    bool_values: ClassVar = {**yaml.SafeLoader.bool_values, 'y': True, 'n': False}


_Loader.add_implicit_resolver(
    'tag:yaml.org,2002:float', re.compile(r'[-+]?\d+[eE][-+]?\d+$'), list('-+0123456789')
)
_Loader.add_implicit_resolver('tag:yaml.org,2002:bool', re.compile('[yYnN]$'), list('yYnN'))


class Configuration:
    """Valid settings of every part, from one mapping of full keys to values.

    Raises `SettingsError` for an unknown key or a value that is not allowed, naming both and what
    is allowed.
    """

    def __init__(self, values: Mapping[str, Any] | None = None) -> None:
        values = dict(values or {})
        refuse_unknown(values, PARTS)
        if values.get('pipeline.source') in DRIVER_SOURCES:
            # The pipeline takes the driver's place, whatever a driver of the same file would read.
            values['driver.source'] = values['pipeline.source']
        self._settings = {part: part.from_values(values) for part in PARTS}

    def __getitem__(self, part: type[SettingsType]) -> SettingsType:
        return self._settings[part]  # type: ignore[return-value]

    @classmethod
    def load(cls, path: Path) -> Configuration:
        """Read a parameter file; raises `SettingsError` where it is not one."""
        return cls(read_values(path))


def read_values(path: Path) -> dict[str, Any]:
    """Read full keys and values from a parameter file, ROS's own keys left out.

    Raises `SettingsError` if there is no such file or it is no parameter file.
    """
    try:
        document = yaml.load(path.read_text(encoding='utf-8'), _Loader)
    except OSError as error:
        raise SettingsError(f'{path}: {error.strerror}; name a parameter file') from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise SettingsError(f'{path}: {error}') from error
    try:
        section = document['/**']['ros__parameters']
        flat = dict(_flatten(section))
    except (TypeError, KeyError, AttributeError) as error:
        raise SettingsError(f"{path}: no section '/**: ros__parameters:'") from error
    return {key: value for key, value in flat.items() if not is_ros_key(key)}


def is_ros_key(key: str) -> bool:
    """Say whether a key belongs to ROS itself, and so to every node."""
    return key.startswith('qos_overrides.') or key in (
        'use_sim_time',
        'start_type_description_service',
    )


def _flatten(section: Mapping[str, Any], prefix: str = '') -> list[tuple[str, Any]]:
    pairs: list[tuple[str, Any]] = []
    for key, value in section.items():
        if isinstance(value, Mapping):
            pairs.extend(_flatten(value, f'{prefix}{key}.'))
        else:
            pairs.append((f'{prefix}{key}', value))
    return pairs
