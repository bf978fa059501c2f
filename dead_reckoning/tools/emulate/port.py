"""The pseudo-terminal that a board hangs on; the only module here that knows one."""

from __future__ import annotations

import os
import select
import time
import tty
from contextlib import suppress
from pathlib import Path

from dead_reckoning.core.errors import InputError

LOOK = 0.01
"""Longest time [s] between two looks whether a host has opened the port."""


class Port:
    """The far end of a serial port, which can be plugged in and out.

    With a ``link`` the port has a name that stays: a symbolic link, which is there while the board
    is plugged in.  A link that leads nowhere, as a killed process leaves it, is replaced; anything
    else of that name is refused with `InputError`.  ``lost`` counts the bytes that nobody read.
    """

    def __init__(self, link: Path | None = None) -> None:
        self.lost = 0
        self._link = link
        self._poll = select.poll()
        self._far_end: int | None = None
        self._device = ''

    def __enter__(self) -> Port:
        self.plug()
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    @property
    def name(self) -> str:
        """The path that a host opens."""
        return self._device if self._link is None else str(self._link)

    def plug(self) -> None:
        """Appear; bytes pass as they are, both ways."""
        self._far_end, near_end = os.openpty()
        try:
            tty.setraw(near_end)
            self._device = os.ttyname(near_end)
        finally:
            os.close(near_end)  # so that it shows whether a host has opened it
        os.set_blocking(self._far_end, False)
        self._poll.register(self._far_end, select.POLLIN)
        if self._link is not None:
            try:
                self._make(self._link)
            except InputError:
                self.unplug()
                raise

    def unplug(self) -> None:
        """Hang up and vanish."""
        if self._far_end is None:
            return
        if self._link is not None:
            with suppress(OSError):
                if os.readlink(self._link) == self._device:
                    self._link.unlink()
        self._poll.unregister(self._far_end)
        os.close(self._far_end)
        self._far_end = None

    def write(self, data: bytes) -> None:
        """Send bytes; those are lost for which nobody has opened the port, or makes room."""
        self.lost += len(data)
        if self._far_end is None or not data:
            return
        if not any(state & select.POLLHUP for _, state in self._poll.poll(0)):
            with suppress(BlockingIOError):
                self.lost -= os.write(self._far_end, data)

    def read(self, timeout: float) -> bytes:
        """Wait for bytes, but no longer than a time [s]; return them, or none."""
        if self._far_end is None:
            time.sleep(timeout)
            return b''
        for _, state in self._poll.poll(1000.0 * timeout):
            if state & select.POLLIN:
                with suppress(OSError):  # nobody has it open any more
                    return os.read(self._far_end, 4096)
            time.sleep(min(timeout, LOOK))  # nobody has it open, which poll says at once
        return b''

    def _make(self, link: Path) -> None:
        try:
            if link.is_symlink() and not link.exists():
                link.unlink()
            link.symlink_to(self._device)
        except OSError as error:
            raise InputError(
                f'--link {link}: {error.strerror}; name a path where nothing is, in a folder that '
                'can be written'
            ) from error
