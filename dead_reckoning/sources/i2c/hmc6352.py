"""An HMC6352 compass, on an I²C bus or as the driver of the kernel shows it.

Commands, memory and delays are those of the data sheet (Honeywell): *Command Protocol*,
*Operational Controls*, *User Calibration*.
"""

from __future__ import annotations

import errno
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from math import radians
from pathlib import Path

from dead_reckoning.core.compass import CompassSettings
from dead_reckoning.core.errors import (
    DeviceError,
    DevicePermissionError,
    LostDeviceError,
    MissingDeviceError,
    NumberError,
    OutOfRangeError,
    ReadingError,
    RefusedSettingError,
    SettingsError,
)
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.sources.devices import (
    PATIENCE,
    Calibration,
    Events,
    Heading,
    Opened,
    Wait,
)
from dead_reckoning.sources.i2c.device import I2cDevice, OpenBus

MODE, OUTPUT = 0x74, 0x4E
"""Addresses in its RAM: the operational mode, and what is put out, 0 for the heading."""

CODE_OF_RATE = {1.0: 0, 5.0: 1, 10.0: 2, 20.0: 3}
"""Headings per second → bits 6:5 of the mode."""

SET_RESET, CONTINUOUS = 0x10, 0x02
"""Of the mode: set and reset the bridges now and then; measure all the time."""

MEMORY_DELAY, DATA_DELAY, ENTER_DELAY, LEAVE_DELAY = 0.0001, 0.01, 0.00001, 0.014
"""Times [s] after G and g, A, C, E before the next transfer; A takes 6 to 10 ms."""

TURN = 3600
"""Tenths of a degree in a turn; a heading is less."""


@dataclass(frozen=True, kw_only=True)
class Hmc6352Settings(Settings, prefix='compass.hmc6352'):
    """An HMC6352 compass, on a bus or in sysfs."""

    bus: int = parameter(1, 'Number of the I²C bus: 1 is /dev/i2c-1', minimum=0, maximum=255)
    address: int = parameter(
        0x21, 'Address on the bus, 33 (0x21) as it leaves the factory', minimum=0x08, maximum=0x77
    )
    folder: str = parameter(
        '', 'Folder of heading0_input where the driver of the kernel has the compass, as '
        '/sys/bus/i2c/devices/1-0021/hmc6352; empty: the bus itself is used'
    )  # fmt: skip


class Link(ABC):
    """A way to the compass; failures are `DeviceError`."""

    name: str
    delay: float
    """How old a heading is on average when it is read [s]."""

    def close(self) -> None:  # noqa: B027 — not every way has something to close
        """Let go of it."""

    @abstractmethod
    def set_up(self) -> None:
        """Make it measure as set."""

    @abstractmethod
    def tenths(self) -> int:
        """Return the heading [0.1°]; raises `ReadingError` for what is no number."""

    @abstractmethod
    def calibrating(self, on: bool) -> None:
        """Enter the calibration, or leave it."""


class Bus(Link):
    """The compass on an I²C bus, measuring continuously at its own rate."""

    def __init__(
        self, settings: Hmc6352Settings, rate: float, open_bus: OpenBus, wait: Wait
    ) -> None:
        self._device = I2cDevice(open_bus, settings.bus, settings.address)
        self._mode = CODE_OF_RATE[rate] << 5 | SET_RESET | CONTINUOUS
        self._wait = wait
        self.name = self._device.name
        self.delay = 0.5 / rate

    def close(self) -> None:
        """Close the bus."""
        self._device.close()

    def set_up(self) -> None:
        """Write mode and output, and read both back."""
        for address, value in ((MODE, self._mode), (OUTPUT, 0)):
            self._tell(b'G' + bytes([address, value]), MEMORY_DELAY)
            self._tell(b'g' + bytes([address]), MEMORY_DELAY)
            (found,) = self._device.transfer(b'', 1)
            if found != value:
                raise RefusedSettingError(
                    f'{self.name}: its memory {address:#04x} holds {found:#04x} after '
                    f'{value:#04x} was written; is it an HMC6352, and '
                    'does no other program set it up?'
                )

    def tenths(self) -> int:
        """Ask for the heading: what is read follows from the last command."""
        self._tell(b'A', DATA_DELAY)
        return int.from_bytes(self._device.transfer(b'', 2), 'big')

    def calibrating(self, on: bool) -> None:
        """Send C or E."""
        if on:
            self._tell(b'C', ENTER_DELAY)
        else:
            self._tell(b'E', LEAVE_DELAY)

    def _tell(self, command: bytes, delay: float) -> None:
        self._device.transfer(command)
        self._wait(delay)


class Sysfs(Link):
    """The compass as Linux shows it (Documentation/ABI/testing/sysfs-bus-i2c-devices-hm6352)."""

    delay = 0.0

    def __init__(self, folder: str) -> None:
        self.name = folder
        self._folder = Path(folder)

    def set_up(self) -> None:
        """See that a heading can be read."""
        self._read()

    def tenths(self) -> int:
        """Read the heading, which the file holds in degrees."""
        text = self._read()
        try:
            return round(10.0 * float(text))
        except (ValueError, OverflowError) as error:
            raise NumberError(f'{self.name}: heading0_input holds no number: {text!r}') from error

    def calibrating(self, on: bool) -> None:
        """Write 1 or 0 to the file of the calibration."""
        try:
            (self._folder / 'calibration').write_text('1' if on else '0')
        except OSError as failure:
            raise self._explained(failure) from failure

    def _read(self) -> str:
        try:
            return (self._folder / 'heading0_input').read_text(errors='replace').strip()
        except OSError as failure:
            raise self._explained(failure) from failure

    def _explained(self, failure: OSError) -> DeviceError:
        if failure.errno in (errno.ENOENT, errno.ENODEV, errno.ENOTDIR):
            return MissingDeviceError(
                f'{self.name}: there is no compass; load the module hmc6352, tell the bus of it '
                '(`echo hmc6352 0x21 | sudo tee /sys/bus/i2c/devices/i2c-1/new_device`), or set '
                'compass.hmc6352.folder'
            )
        if failure.errno in (errno.EACCES, errno.EPERM):
            return DevicePermissionError(
                f'{failure.filename}: this user may not use it; install the udev rules '
                '99-dead-reckoning.rules, then `sudo usermod -aG dialout $USER` and log in again '
                '(docs/devices/hmc6352.md)'
            )
        return LostDeviceError(f'{self.name}: the compass does not answer ({failure})')


class Hmc6352:
    """Read an HMC6352, and calibrate it when asked to."""

    def __init__(
        self,
        settings: Hmc6352Settings,
        compass: CompassSettings,
        open_bus: OpenBus | None,
        now_ns: Callable[[], int],
    ) -> None:
        """``now_ns`` gives the stamps [ns]; ``open_bus`` is not needed for sysfs.

        Raises `SettingsError` for a rate that it does not have.
        """
        if not settings.folder and compass.rate not in CODE_OF_RATE:
            raise SettingsError(
                f'compass.rate: {compass.rate:g} is not allowed; an HMC6352 has 1, 5, 10 '
                'or 20 [Hz]'
            )
        self._settings = settings
        self._rate = compass.rate
        self._calibration_time = compass.calibration_time
        self._open_bus = open_bus
        self._now_ns = now_ns
        self._asked = threading.Event()
        self._entered = False

    def calibrate(self) -> None:
        """Ask the session for a calibration; `Calibration` or a `DeviceError` is the answer.

        Asked again meanwhile, its time begins anew.
        """
        self._asked.set()

    def abandon(self) -> None:
        """Ask no longer."""
        self._asked.clear()

    def session(self, wait: Wait) -> Events:
        """Set the compass up and yield its headings; see `Session`."""
        period = 1.0 / self._rate
        with closing(self._link(wait)) as link:
            if self._entered:  # it was lost meanwhile
                link.calibrating(False)
                self._entered = False
            link.set_up()
            yield Opened()
            due = time.monotonic()
            while True:
                if self._asked.is_set():
                    yield from self._calibrate(link, wait)
                yield self._read(link)
                due = max(due + period, time.monotonic())
                while (left := due - time.monotonic()) > 0.0:
                    wait(min(left, PATIENCE))
                    yield None

    def _link(self, wait: Wait) -> Link:
        if self._settings.folder:
            return Sysfs(self._settings.folder)
        assert self._open_bus is not None
        return Bus(self._settings, self._rate, self._open_bus, wait)

    def _read(self, link: Link) -> Heading | ReadingError:
        stamp_ns = self._now_ns()
        try:
            tenths = link.tenths()
        except ReadingError as error:
            return error
        if not 0 <= tenths < TURN:
            return OutOfRangeError(
                f'{link.name}: {tenths} is no heading in tenths of a degree, which is less than '
                f'{TURN}; check the wiring'
            )
        return Heading(stamp_ns - round(link.delay * NANOSECONDS), radians(0.1 * tenths))

    def _calibrate(self, link: Link, wait: Wait) -> Events:
        """Let the compass learn while someone turns it; however that ends, it leaves the mode."""
        link.calibrating(True)
        self._entered = True
        try:
            end = 0.0
            while self._asked.is_set() or end > time.monotonic():
                if self._asked.is_set():
                    self._asked.clear()
                    end = time.monotonic() + self._calibration_time
                wait(min(max(end - time.monotonic(), 0.0), PATIENCE))
                yield Calibration()
        finally:
            link.calibrating(False)
            self._entered = False
        link.set_up()  # nothing was read meanwhile: it may have lost its supply, and its mode
        yield Calibration(
            f'calibrated for {self._calibration_time:g} s: it keeps what it has learnt of '
            'the iron nearby; check the headings'
        )
