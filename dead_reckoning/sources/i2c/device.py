"""A device on an I²C bus: bytes to and fro, and errors that say what to do."""

from __future__ import annotations

import errno
from collections.abc import Callable
from typing import Protocol

from dead_reckoning.core.errors import DeviceError, DevicePermissionError, MissingDeviceError


class Bus(Protocol):
    """What a device needs of a bus; failures are `OSError`."""

    def transfer(self, address: int, written: bytes, count: int) -> bytes:
        """Write bytes, then read ``count``, in one transfer; either may be none."""

    def close(self) -> None:
        """End the use of the bus."""


OpenBus = Callable[[int], Bus]


class I2cDevice:
    """One address of a bus, which is open until `close`.  Failures are `DeviceError`."""

    def __init__(self, open_bus: OpenBus, number: int, address: int) -> None:
        self.name = f'/dev/i2c-{number}, address {address:#04x}'
        self._number = number
        self._address = address
        try:
            self._bus = open_bus(number)
        except OSError as failure:
            raise self._not_opened(failure) from failure

    def close(self) -> None:
        """End the use of the bus."""
        self._bus.close()

    def transfer(self, written: bytes, count: int = 0) -> bytes:
        """Write bytes, then read ``count``."""
        try:
            return self._bus.transfer(self._address, written, count)
        except OSError as failure:
            if failure.errno in (errno.EREMOTEIO, errno.ENXIO):
                raise MissingDeviceError(
                    f'{self.name}: nothing answers; check supply, SDA, SCL and the address '
                    f'(`i2cdetect -y {self._number}` shows who is there)'
                ) from failure
            raise DeviceError(
                f'{self.name}: the transfer failed ({failure}); check the wiring, its length and '
                'its pull-ups'
            ) from failure

    def _not_opened(self, failure: OSError) -> DeviceError:
        path = f'/dev/i2c-{self._number}'
        if failure.errno in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
            return MissingDeviceError(
                f'{path}: there is no such bus; enable I²C and load the module i2c-dev, or name '
                'another one (`ls /dev/i2c-*` shows those there are)'
            )
        if failure.errno in (errno.EACCES, errno.EPERM):
            return DevicePermissionError(
                f'{path}: this user may not open it; `sudo usermod -aG i2c $USER`, or the group '
                f'that `ls -l {path}` shows, then log in again'
            )
        return DeviceError(f'{path}: it can not be opened ({failure})')
