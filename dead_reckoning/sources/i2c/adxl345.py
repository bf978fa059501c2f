"""An ADXL345 on an I²C bus, set up as the mbed tutorial does.

Registers and bits are those of the data sheet (Analog Devices, Rev E), *Register Map*, *FIFO*.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from dead_reckoning.core.errors import (
    LostDeviceError,
    OverrunError,
    RefusedSettingError,
    SettingsError,
    WrongDeviceError,
)
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.devices import PATIENCE, Events, FifoClock, Opened, Wait
from dead_reckoning.sources.i2c.device import I2cDevice, OpenBus

DEVID, BW_RATE, POWER_CTL, DATA_FORMAT = 0x00, 0x2C, 0x2D, 0x31
DATAX0, FIFO_CTL, FIFO_STATUS = 0x32, 0x38, 0x39

IDENTITY = 0xE5
"""What `DEVID` always holds."""

STANDBY, MEASURE = 0x00, 0x08
FULL_RESOLUTION = 0x08
"""3.9 mg a count in every range, right justified with the sign extended."""

RANGES = (2.0, 4.0, 8.0, 16.0)
BYPASS, STREAM = 0x00, 0x80
"""Modes of the FIFO: off, which empties it, and the newest 32 samples."""

ENTRIES = 0x3F
"""The bits of `FIFO_STATUS` that count samples."""

FULL = 32
"""Samples that the FIFO holds; one more may wait at the filter before it."""

CODE_OF_RATE = {0.09765625 * 2.0**code: code for code in range(16)}
"""Conversions per second → code in `BW_RATE`."""

LOOK = 0.004
"""Shortest time [s] between two looks at the FIFO, in which it gets 13 samples at 3200 Hz."""


@dataclass(frozen=True, kw_only=True)
class I2cSettings(Settings, prefix='driver.i2c'):
    """An ADXL345 on an I²C bus."""

    bus: int = parameter(1, 'Number of the bus: 1 is /dev/i2c-1', minimum=0, maximum=255)
    address: int = parameter(
        0x53, 'Address of the sensor: 83 (0x53) with SDO/ALT ADDRESS low, 29 (0x1d) with it high',
        choices=(0x53, 0x1D),
    )  # fmt: skip
    rate: float = parameter(
        100.0,
        'Conversions per second: 0.09765625 · 2ⁿ up to 3200; the data sheet allows up to 800 on a '
        'bus of 400 kHz, 200 on one of 100 kHz',
        unit='Hz', minimum=0.09765625, maximum=3200.0,
    )  # fmt: skip

    def validate(self) -> None:
        """Raise `SettingsError` for a rate that the sensor does not have."""
        if self.rate not in CODE_OF_RATE:
            near = min(CODE_OF_RATE, key=lambda rate: abs(rate - self.rate))
            raise SettingsError(
                f'driver.i2c.rate: {self.rate:g} is not allowed; the sensor has 3200, 1600, 800 … '
                f'[Hz], each half of the one before: the nearest is {near:.9g}'
            )


class Adxl345:
    """Read an ADXL345 through its FIFO, so that no sample is read twice and none is left out.

    A sample leaves the FIFO when its six bytes are read in one transfer.  ``FIFO_STATUS`` is not
    looked at before 5 µs after that (data sheet, *FIFO*): the address bytes take longer even at
    400 kHz.
    """

    def __init__(
        self, settings: I2cSettings, range_g: float, open_bus: OpenBus, now_ns: Callable[[], int]
    ) -> None:
        """``now_ns`` gives the stamps [ns]."""
        self._settings = settings
        self._format = FULL_RESOLUTION | RANGES.index(range_g)
        self._open_bus = open_bus
        self._now_ns = now_ns

    def session(self, wait: Wait) -> Events:
        """Set the sensor up and yield its conversions; see `Session`."""
        period = 1.0 / self._settings.rate
        patience = max(1.0, 5.0 * period)
        pause = min(max(period, LOOK), PATIENCE)
        with closing(
            I2cDevice(self._open_bus, self._settings.bus, self._settings.address)
        ) as device:
            self._set_up(device)
            yield Opened()
            clock, idle = FifoClock(period), 0.0
            while True:
                wait(pause)
                before_ns = self._now_ns()
                (status,) = device.transfer(bytes([FIFO_STATUS]), 1)
                after_ns = self._now_ns()
                count = status & ENTRIES
                if not count:
                    idle += pause
                    if idle > patience:
                        raise LostDeviceError(
                            f'{device.name}: no sample for {idle:.1f} s, so it has lost its '
                            'supply; it is set up again'
                        )
                    yield None
                    continue
                idle = 0.0
                if count >= FULL:
                    clock = FifoClock(period)
                    yield OverrunError(
                        f'{device.name}: its FIFO ran over: lower driver.i2c.rate, raise the '
                        'speed of the bus, or relieve the computer'
                    )
                data = b''.join(device.transfer(bytes([DATAX0]), 6) for _ in range(count))
                counts = np.frombuffer(data, '<i2').reshape(-1, 3).astype(np.float64)
                yield Conversions(clock.stamps(count, before_ns, after_ns), counts)

    def _set_up(self, device: I2cDevice) -> None:
        (identity,) = device.transfer(bytes([DEVID]), 1)
        if identity != IDENTITY:
            raise WrongDeviceError(
                f'{device.name}: no ADXL345 answers there, which says {IDENTITY:#04x}, but '
                f'something that says {identity:#04x}; set driver.i2c.bus and driver.i2c.address'
            )
        for register, value in (
            (POWER_CTL, STANDBY),
            (DATA_FORMAT, self._format),
            (BW_RATE, CODE_OF_RATE[self._settings.rate]),
            (FIFO_CTL, BYPASS),
            (FIFO_CTL, STREAM),
            (POWER_CTL, MEASURE),
        ):
            device.transfer(bytes([register, value]))
            (found,) = device.transfer(bytes([register]), 1)
            if found != value:
                raise RefusedSettingError(
                    f'{device.name}: register {register:#04x} holds {found:#04x} after '
                    f'{value:#04x} was written; does another program set the sensor up?'
                )
