"""A board on a serial port that can be plugged in and out: a pty behind a symbolic link."""

import os
import tty
from pathlib import Path


class Board:
    """The far end of a port whose path is `port`; it is unplugged at first."""

    def __init__(self, folder: Path) -> None:
        self.port = folder / 'board'
        self._far_end: int | None = None

    def __enter__(self) -> 'Board':
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def plug(self) -> None:
        """Appear, as a device file that has not been there before."""
        self._far_end, near_end = os.openpty()
        os.set_blocking(self._far_end, False)
        tty.setraw(near_end)
        self.port.unlink(missing_ok=True)
        self.port.symlink_to(os.ttyname(near_end))
        os.close(near_end)

    def unplug(self) -> None:
        """Hang up and vanish."""
        self.port.unlink(missing_ok=True)
        if self._far_end is not None:
            os.close(self._far_end)
            self._far_end = None

    @property
    def plugged(self) -> bool:
        """Whether it is there."""
        return self._far_end is not None

    def hear(self) -> bytes:
        """Return what it has been told since the last time."""
        try:
            return os.read(self._far_end, 65_536)
        except OSError:  # nothing, or nobody has the port open
            return b''

    def send(self, data: bytes) -> None:
        """Send bytes; raises `BlockingIOError` where nobody has read those before."""
        while data:
            data = data[os.write(self._far_end, data) :]
