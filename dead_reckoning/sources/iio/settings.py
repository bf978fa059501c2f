"""Settings of an industrial-I/O accelerometer."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.core.parameters import Settings, parameter


@dataclass(frozen=True, kw_only=True)
class IioSettings(Settings, prefix='driver.iio'):
    """An accelerometer that a driver of the Linux kernel reads."""

    device: str = parameter(
        'adxl345', 'Name of the device, or its number N of iio:deviceN where several have the name'
    )
    rate: float = parameter(
        100.0,
        'Samples per second, to which the device is set, or its trigger where that has the rate',
        unit='Hz', minimum=0.01, maximum=100_000.0,
    )  # fmt: skip
    scale: float = parameter(
        0.0, 'Size of a count where in_accel_scale is wrong (docs/devices/adxl345.md); 0 for what '
        'that says',
        unit='m/s²', minimum=0.0, maximum=100.0,
    )  # fmt: skip
    buffered: bool = parameter(
        True, 'Read whole samples from the buffer, where the device has one; false reads a file '
        'for each axis, one after the other',
    )  # fmt: skip
    buffer_length: int = parameter(
        128, 'Samples that the buffer of the kernel holds', minimum=2, maximum=1_000_000
    )
    trigger: str = parameter(
        '', 'Name of the trigger that starts the conversions; empty for the one that is set'
    )
    root: str = parameter(
        '/', 'Folder in which sys and dev are: another one where a container sees those of its '
        'host elsewhere'
    )  # fmt: skip
