"""The files of a device of the kernel: text and numbers in, and what a failure means."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dead_reckoning.core.errors import (
    BusyDeviceError,
    DeviceError,
    DevicePermissionError,
    LostDeviceError,
    RefusedSettingError,
    WrongDeviceError,
)


class Files:
    """The files in the folder of a device, by their names."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.name = f'{folder.name} ({self.text("name")})'

    def has(self, name: str) -> bool:
        """Say whether there is such a file."""
        return (self.folder / name).exists()

    def text(self, name: str) -> str:
        """Return what a file holds."""
        return (self.folder / name).read_text(errors='replace').strip()

    def number(self, name: str) -> float:
        """Return the number in a file; raises `WrongDeviceError` where it holds none."""
        text = self.text(name)
        try:
            return float(text)
        except ValueError as error:
            raise WrongDeviceError(f'{self.folder}/{name} holds no number: {text!r}') from error

    def offers(self, name: str) -> list[str]:
        """Return the values that a file can have, in order, as far as they are listed.

        The list may be that of the whole device: older drivers have one of rates only so.
        """
        for listed in (f'{name}_available', f'{name.removeprefix("in_accel_")}_available'):
            if self.has(listed) and '[' not in (text := self.text(listed)):
                return text.split()
        return []

    def write(self, name: str, value: str, key: str) -> None:
        """Write a value that the parameter ``key`` asks for; raises `RefusedSettingError`."""
        try:
            (self.folder / name).write_text(value)
        except OSError as failure:
            if failure.errno not in (errno.EINVAL, errno.ERANGE):
                raise
            offers = ', '.join(self.offers(name))
            raise RefusedSettingError(
                f'{self.name}: its {name} does not take {value}; set {key} to '
                + (f'one of {offers}' if offers else 'what the device has')
            ) from failure


@contextmanager
def explained(device: str) -> Iterator[None]:
    """Turn failures of the system into `DeviceError`, with what to do."""
    try:
        yield
    except OSError as failure:
        what = f'{device}: {failure.filename or "it"}'
        if failure.errno in (errno.EACCES, errno.EPERM):
            raise DevicePermissionError(
                f'{what}: this user may not use it; install the udev rules '
                '99-dead-reckoning.rules, then `sudo usermod -aG dialout $USER` and log in again '
                '(docs/devices/adxl345.md)'
            ) from failure
        if failure.errno == errno.EBUSY:
            raise BusyDeviceError(
                f'{what}: another program reads it; end that one (`fuser -v /dev/iio:device*` '
                'names it)'
            ) from failure
        if failure.errno in (errno.ENODEV, errno.ENOENT, errno.ENXIO, errno.EIO):
            raise LostDeviceError(
                f'{what}: the device does not answer or is gone; it is read on as soon as it is '
                'back'
            ) from failure
        raise DeviceError(f'{what}: it can not be read ({failure})') from failure
