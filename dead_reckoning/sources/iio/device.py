"""An accelerometer of the Linux kernel, through its buffer or through its files in sysfs.

Names and meanings of the files: Linux, Documentation/ABI/testing/sysfs-bus-iio.
"""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.accelerometer import Accelerometer
from dead_reckoning.core.errors import (
    LostDeviceError,
    MissingDeviceError,
    RefusedSettingError,
    WrongDeviceError,
)
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.sources.devices import PATIENCE, Events, FifoClock, Opened, Wait
from dead_reckoning.sources.iio.files import Files, explained
from dead_reckoning.sources.iio.scan import Element, Layout
from dead_reckoning.sources.iio.settings import IioSettings

AXES = ('in_accel_x', 'in_accel_y', 'in_accel_z')
TIMESTAMP = 'in_timestamp'
CLOCKS = {
    'realtime': time.CLOCK_REALTIME,
    'realtime_coarse': time.CLOCK_REALTIME,
    'monotonic': time.CLOCK_MONOTONIC,
    'monotonic_coarse': time.CLOCK_MONOTONIC,
    'monotonic_raw': time.CLOCK_MONOTONIC_RAW,
    'boottime': time.CLOCK_BOOTTIME,
    'tai': time.CLOCK_TAI,
}
"""What current_timestamp_clock names; a coarse one runs with its fine one."""

OTHER_CLOCK = NANOSECONDS
"""A node whose clock is off by more than this [ns] from that of the wall goes by another one."""

RATE_TOLERANCE, RANGE_TOLERANCE = 0.01, 0.1
"""How far, as a part, rate and range may be from what was asked for."""


class Iio:
    """Read one accelerometer of the kernel, as counts of a model."""

    def __init__(
        self, settings: IioSettings, model: Accelerometer, now_ns: Callable[[], int]
    ) -> None:
        """``now_ns`` gives the stamps [ns]."""
        self._settings = settings
        self._model = model
        self._now_ns = now_ns

    def session(self, wait: Wait) -> Events:
        """Find the device, set it up and yield its conversions; see `Session`."""
        root = Path(self._settings.root)
        with explained(f'driver.iio.device {self._settings.device!r}'):
            files = Files(self._find(root / 'sys/bus/iio/devices'))
            if self._settings.buffered and files.has('buffer'):
                yield from self._buffered(files, root / 'dev' / files.folder.name)
            else:
                yield from self._one_by_one(files, wait)

    def _find(self, devices: Path) -> Path:
        wanted = self._settings.device
        named = {p.parent: p.read_text().strip() for p in devices.glob('iio:device*/name')}
        found = [f for f, name in named.items() if wanted in (name, f.name[len('iio:device') :])]
        if len(found) == 1:
            return found[0]
        there = ', '.join(sorted(f'{f.name} ({name})' for f, name in named.items())) or 'none'
        if found:
            raise MissingDeviceError(
                f'driver.iio.device: {wanted!r} is the name of several; set its number: {there}'
            )
        raise MissingDeviceError(
            f'driver.iio.device: there is no device {wanted!r}, but {there}; plug it in, load its '
            'module, or name another'
        )

    # The buffer ---------------------------------------------------------------------------------

    def _buffered(self, files: Files, path: Path) -> Events:
        """Read whole samples; the kernel stamps them."""
        device = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # only one reader may
        try:
            files.write('buffer/enable', '0', 'driver.iio.device')  # left over from another time
            notice = self._set(files)
            layout = self._set_channels(files)
            to_clock = self._clock_offset(files) if TIMESTAMP in layout else None
            files.write(
                'buffer/length', str(self._settings.buffer_length), 'driver.iio.buffer_length'
            )
            files.write('buffer/enable', '1', 'driver.iio.trigger')
            yield Opened(notice)
            yield from self._scans(files, device, layout, to_clock)
        finally:
            os.close(device)
            with suppress(OSError):
                (files.folder / 'buffer/enable').write_text('0')

    def _scans(self, files: Files, device: int, layout: Layout, to_clock: int | None) -> Events:
        force, clock = self._force(files), FifoClock(1.0 / self._settings.rate)
        poll = select.poll()
        poll.register(device, select.POLLIN)
        data, last_ns = b'', 0
        while True:
            if not poll.poll(1000.0 * PATIENCE):
                yield None
                continue
            try:
                more = os.read(device, self._settings.buffer_length * layout.size)
            except BlockingIOError:  # less than the watermark of the buffer
                yield None
                continue
            if not more:
                raise LostDeviceError(
                    f'{files.name}: it is gone; it is read on as soon as it is back'
                )
            arrival_ns = self._now_ns()
            data += more
            whole = len(data) // layout.size * layout.size
            scans, data = data[:whole], data[whole:]
            if not scans:
                continue
            raw = np.column_stack([layout.values(scans, axis) for axis in AXES])
            newest_ns = arrival_ns
            if to_clock is not None:
                stamps_ns = layout.values(scans, TIMESTAMP) + to_clock
                newest_ns = int(stamps_ns[-1])
                if stamps_ns[0] > last_ns and np.all(np.diff(stamps_ns) > 0):
                    last_ns = newest_ns
                    yield Conversions(stamps_ns, force(raw))
                    continue
            # No stamps, or one for all that waited in the memory of the sensor.
            stamps_ns = clock.stamps(len(raw), newest_ns, newest_ns)
            last_ns = int(stamps_ns[-1])
            yield Conversions(stamps_ns, force(raw))

    def _set_channels(self, files: Files) -> Layout:
        """Enable the axes and the stamps, nothing else; return how they lie in a scan."""
        for path in sorted((files.folder / 'scan_elements').glob('*_en')):
            channel = path.name[: -len('_en')]
            wanted = channel in (*AXES, TIMESTAMP)
            if (path.read_text().strip() == '1') != wanted:
                files.write(f'scan_elements/{path.name}', str(int(wanted)), 'driver.iio.device')
        elements = {}
        for path in (files.folder / 'scan_elements').glob('*_en'):
            if path.read_text().strip() == '1':
                channel = path.name[: -len('_en')]
                index = int(files.number(f'scan_elements/{channel}_index'))
                elements[channel] = (
                    index,
                    Element.parse(files.text(f'scan_elements/{channel}_type')),
                )
        missing = [axis for axis in AXES if axis not in elements]
        if missing:
            raise WrongDeviceError(
                f'{files.name}: its buffer has no {", ".join(missing)}; is it an accelerometer of '
                'three axes? Else set driver.iio.device, or driver.iio.buffered to false'
            )
        return Layout(elements)

    def _clock_offset(self, files: Files) -> int | None:
        """Return what takes stamps of the kernel to those of the node [ns], None for nothing."""
        if abs(self._now_ns() - time.time_ns()) > OTHER_CLOCK:
            return None  # simulated time
        name = 'current_timestamp_clock'
        if files.has(name) and files.text(name) != 'realtime':
            with suppress(OSError, RefusedSettingError):
                files.write(name, 'realtime', name)
        clock = CLOCKS.get(files.text(name) if files.has(name) else 'realtime')
        if clock is None:
            return None
        return 0 if clock == time.CLOCK_REALTIME else time.time_ns() - time.clock_gettime_ns(clock)

    # One file an axis ---------------------------------------------------------------------------

    def _one_by_one(self, files: Files, wait: Wait) -> Events:
        """Read an axis after the other, at the middle of which the sample is stamped."""
        notice = self._set(files)
        force, last_ns = self._force(files), 0
        for axis in AXES:
            files.number(f'{axis}_raw')
        yield Opened(
            f'{files.name}: its axes are read one after the other, so they are not one sample, '
            'and a conversion may be read twice or not at all: use its buffer where it has one'
            + (f'; {notice}' if notice else '')
        )
        due = time.monotonic()
        while True:
            before_ns = self._now_ns()
            raw = np.array([[files.number(f'{axis}_raw') for axis in AXES]])
            stamp_ns = (before_ns + self._now_ns()) // 2
            if stamp_ns != last_ns:  # of a clock that stands
                yield Conversions(np.array([stamp_ns]), force(raw))
            last_ns = stamp_ns
            due = max(due + 1.0 / self._settings.rate, time.monotonic())
            while (left := due - time.monotonic()) > 0.0:
                wait(min(left, PATIENCE))
                yield None

    # What both need -----------------------------------------------------------------------------

    def _set(self, files: Files) -> str:
        """Set trigger, rate and range and read them back; return what a user should know."""
        trigger = self._settings.trigger
        if trigger and files.has('trigger'):
            files.write('trigger/current_trigger', trigger, 'driver.iio.trigger')
            if (found := files.text('trigger/current_trigger')) != trigger:
                raise RefusedSettingError(
                    f'{files.name}: its trigger is {found!r} after {trigger!r} was written; set '
                    'driver.iio.trigger to one that /sys/bus/iio/devices/trigger*/name show'
                )
        self._set_rate(files)
        return self._set_range(files)

    def _set_rate(self, files: Files) -> None:
        name = _first(files, 'in_accel_sampling_frequency', 'sampling_frequency')
        if name is None:
            trigger = self._trigger(files)
            if trigger is None:  # whatever starts the conversions has a rate of its own
                return
            files, name = trigger, 'sampling_frequency'
        rate = self._settings.rate
        offered = {float(offer): offer for offer in files.offers(name)}
        near = _near(offered, rate, RATE_TOLERANCE)  # drivers compare, so 0.098 is not 0.0977
        files.write(name, offered.get(near, f'{rate:.9g}'), 'driver.iio.rate')
        found = files.number(name)
        if abs(found - rate) > RATE_TOLERANCE * rate:
            raise RefusedSettingError(
                f'{files.name}: its {name} is {found:g} after {rate:g} was written; set '
                f'driver.iio.rate to one of {", ".join(files.offers(name)) or f"{found:g}"}'
            )

    def _trigger(self, files: Files) -> Files | None:
        """Return the trigger that is set, if it has a rate, as timers have."""
        name = 'trigger/current_trigger'
        current = files.text(name) if files.has(name) else ''
        for path in files.folder.parent.glob('trigger*/name'):
            trigger = Files(path.parent)
            if current and trigger.text('name') == current and trigger.has('sampling_frequency'):
                return trigger
        return None

    def _set_range(self, files: Files) -> str:
        """Choose the scale that spans the range: a count is the range over the counts it has."""
        name = _first(files, 'in_accel_scale', 'in_accel_x_scale')
        if name is None:
            raise WrongDeviceError(
                f'{files.name}: it has no in_accel_scale; is it an accelerometer? Set '
                'driver.iio.device'
            )
        if not files.has('scan_elements/in_accel_x_type'):
            return (
                f'it does not tell its range, which is taken for ±{self._model.range_g:g} g: see '
                'that driver.range_g is what its driver sets (docs/devices/adxl345.md)'
            )
        counts = 2.0 ** (Element.parse(files.text('scan_elements/in_accel_x_type')).bits - 1)
        wanted = self._model.range_g
        spans = {float(scale) * counts / GRAVITY: scale for scale in files.offers(name)}
        near = _near(spans, wanted, RANGE_TOLERANCE)
        if near in spans:
            files.write(name, spans[near], 'driver.range_g')
        span = files.number(name) * counts / GRAVITY
        if abs(span - wanted) > RANGE_TOLERANCE * wanted:
            ranges = ', '.join(f'{round(s, 1):g}' for s in spans or (span,))
            raise RefusedSettingError(
                f'{files.name}: by its {name} it spans ±{round(span, 1):g} g, not {wanted:g}; set '
                f'driver.range_g to one of its ranges, {ranges} g, and driver.sensor to fit'
            )
        return ''

    def _force(
        self, files: Files
    ) -> Callable[[NDArray[np.int64] | NDArray[np.float64]], NDArray[np.float64]]:
        """Return what makes counts of the model of raw values, both of shape (n, 3)."""

        def of_axis(axis: str, what: str, default: float) -> float:
            name = _first(files, f'{axis}_{what}', f'in_accel_{what}')
            return default if name is None else files.number(name)

        offset = np.array([of_axis(axis, 'offset', 0.0) for axis in AXES])
        scale = np.array([self._settings.scale or of_axis(axis, 'scale', 1.0) for axis in AXES])
        return lambda raw: self._model.counts_of((raw + offset) * scale, 'm/s2')


def _near(values: Iterable[float], wanted: float, tolerance: float) -> float:
    """Return the value that is as wanted within a part, or else what was wanted."""
    return next((v for v in values if abs(v - wanted) <= tolerance * wanted), wanted)


def _first(files: Files, *names: str) -> str | None:
    return next((name for name in names if files.has(name)), None)
