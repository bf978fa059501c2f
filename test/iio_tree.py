"""A tree of sys and dev with an industrial-I/O accelerometer in it, as the kernel shows one.

Files of sysfs keep what is written, but for those that `Kernel` minds; the device file is a pipe.
"""

import os
import shutil
import struct
import threading
import time
from contextlib import suppress
from pathlib import Path

GRAVITY = 9.80665
SCALE = 16.0 * GRAVITY / 4096
"""Of an ADXL345 at ±16 g with 13 bits [m/s²]."""


class IioTree:
    """An ADXL345 as `adxl345`, of the kernel that has a buffer for it."""

    def __init__(self, root: Path, *, buffer: bool = True, number: int = 0) -> None:
        self.root = root
        self.folder = root / f'sys/bus/iio/devices/iio:device{number}'
        self.device = root / f'dev/iio:device{number}'
        self._buffer = buffer
        self._end = None

    def plug(self, **files: str) -> 'IioTree':
        """Appear; names of files as keys, their slashes as two underscores."""
        values = {
            'name': 'adxl345',
            'in_accel_scale': f'{SCALE:.6f}',
            'in_accel_sampling_frequency': '100.000000',
            'in_accel_sampling_frequency_available': '25 50 100 200 400 800',
            'in_accel_x_raw': '0',
            'in_accel_y_raw': '-128',
            'in_accel_z_raw': '256',
        }
        if self._buffer:
            values |= {
                'current_timestamp_clock': 'realtime',
                'buffer/enable': '0',
                'buffer/length': '2',
                'scan_elements/in_timestamp_en': '0',
                'scan_elements/in_timestamp_index': '4',
                'scan_elements/in_timestamp_type': 'le:s64/64>>0',
                'scan_elements/in_temp_en': '1',
                'scan_elements/in_temp_index': '3',
                'scan_elements/in_temp_type': 'le:s16/16>>0',
            }
            for index, axis in enumerate('xyz'):
                channel = f'scan_elements/in_accel_{axis}'
                values |= {
                    f'{channel}_en': '0',
                    f'{channel}_index': str(index),
                    f'{channel}_type': 'le:s13/16>>0',
                }
        values |= {key.replace('__', '/'): value for key, value in files.items()}
        for name, value in values.items():
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(f'{value}\n')
        if self._buffer:
            self.device.parent.mkdir(parents=True, exist_ok=True)
            os.mkfifo(self.device)
            self._end = os.open(self.device, os.O_RDWR | os.O_NONBLOCK)
        return self

    def unplug(self) -> None:
        """Vanish, with whatever waits in the buffer."""
        self.device.unlink(missing_ok=True)
        shutil.rmtree(self.folder, ignore_errors=True)
        if self._end is not None:
            os.close(self._end)
            self._end = None

    def text(self, name: str) -> str:
        return (self.folder / name).read_text().strip()

    @property
    def enabled(self) -> bool:
        with suppress(OSError):
            return self.text('buffer/enable') == '1'
        return False

    def scan(self, x: int, y: int, z: int, stamp_ns: int | None = None) -> bytes:
        """Return a scan of the axes and the stamp, which stands at a multiple of its 8 bytes."""
        if stamp_ns is None:
            return struct.pack('<3h', x, y, z)
        return struct.pack('<3hxxq', x, y, z, stamp_ns)

    def send(self, data: bytes) -> None:
        """Put scans into the buffer."""
        os.write(self._end, data)


class Board:
    """Send a level sensor's scans while the buffer is enabled, in a thread of its own."""

    def __init__(self, tree: IioTree, rate: float = 100.0) -> None:
        self._tree, self._period = tree, 1.0 / rate
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> 'Board':
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._closing.wait(self._period):
            if self._tree.enabled:
                with suppress(OSError, TypeError):  # unplugged just now
                    self._tree.send(self._tree.scan(0, -128, 256, time.time_ns()))
