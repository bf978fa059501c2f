"""Keep the totals of a pedometer in a file, so that no end of the node loses them."""

from __future__ import annotations

import fcntl
import json
import os
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import suppress
from errno import EWOULDBLOCK
from itertools import count
from math import isfinite
from pathlib import Path
from typing import Any
from zlib import crc32

from dead_reckoning.core.errors import (
    DamagedStateError,
    SettingsError,
    StateFileError,
)
from dead_reckoning.core.pedometer import Totals

VERSION = 1
MOST_STEPS = 2**31
"""A life has fewer; pedometer/steps has twice the room."""

LONGEST_FILE = 4096
LONGEST_WAIT = 0.05
"""How long [s] a sample waits for the disk; a slower one writes while samples go on, and what was
to be said of these totals waits."""

PATIENCE = 5.0
"""How long [s] a disk may take until that is said."""


class TotalsFile:
    """Hold a file of totals, which at any moment is complete: the old one, or the new one.

    One process holds it, by a lock on a file beside it.  Raises `SettingsError` where it can't be
    held or written.
    """

    def __init__(self, path: str) -> None:
        """Take ``path``, ~ for home."""
        self.damage: DamagedStateError | None = None
        """Why the file that was there is not trusted, and where it is now."""
        try:
            self.path = Path(path).expanduser().resolve()  # a link stays, its target is replaced
            self._part = self.path.with_name(f'.{self.path.name}.part')
            self._lock = _locked(self.path)
            try:
                self.totals = self._read()
                """Those that were in the file; zeros without one."""
                self._write(self.totals)
            except BaseException:
                os.close(self._lock)
                raise
        except (OSError, RuntimeError, ValueError) as error:  # no such user, a name with a NUL
            why = getattr(error, 'strerror', None) or error
            raise SettingsError(
                f'pedometer.state_file: {path!r} can not be kept ({why}); name a file of yours, '
                'in a folder that exists'
            ) from error
        self._newest = self.totals
        self._kept: Totals | None = self.totals
        self._writer = ThreadPoolExecutor(1, 'totals')
        self._asked: Future[None] = self._writer.submit(self._write_newest)
        self._begun: float | None = None
        self._refused = ''

    def keep(self, totals: Totals) -> Callable[[], bool]:
        """Write totals, and wait until they are safe, but `LONGEST_WAIT` at most.

        Return what says whether they need not be waited for any more: they are written, or can't
        be.  That is in ``error``, and is tried again with the next totals.
        """
        if totals != self._newest:
            self._newest = totals
            if self._asked.running() or self._asked.done():  # else it is going to write these
                self._asked = self._writer.submit(self._write_newest)
            wait([self._asked], LONGEST_WAIT)
        asked = self._asked
        return lambda: asked.done() or self.error is not None

    @property
    def error(self) -> StateFileError | None:
        """Why the newest totals are not in the file, where they should be by now."""
        why, begun = self._refused, self._begun
        if not why:
            if begun is None or time.monotonic() - begun < PATIENCE:
                return None
            why = f'the disk has not answered for {PATIENCE:g} s'
        return StateFileError(
            f'{self.path} can not be written ({why}): a restart would lose what was walked since; '
            'it is tried again with each step'
        )

    def close(self) -> None:
        """Write what is not written yet, and let others have the file."""
        self._writer.submit(self._write_newest)
        self._writer.shutdown()
        os.close(self._lock)

    def _read(self) -> Totals:
        if self.path.exists() and not self.path.is_file():
            raise ValueError('it is no file')
        try:
            with self.path.open('rb') as file:
                return decode(file.read(LONGEST_FILE))
        except FileNotFoundError:
            return Totals()
        except DamagedStateError as error:
            aside = next(p for k in count(1) if not (p := _numbered(self.path, k)).exists())
            self.path.rename(aside)
            self.damage = DamagedStateError(
                f'{self.path}: {error}; counting from zero, the file is {aside} now'
            )
            return Totals()

    def _write_newest(self) -> None:
        totals = self._newest
        if totals == self._kept:
            return
        self._kept = None  # until it is known what is in the file
        self._begun = time.monotonic()
        try:
            self._write(totals)
        except OSError as error:
            self._refused = error.strerror or str(error)
        else:
            self._kept, self._refused = totals, ''
        finally:
            self._begun = None

    def _write(self, totals: Totals) -> None:
        with self._part.open('wb') as file:
            file.write(encode(totals))
            file.flush()
            os.fsync(file.fileno())  # before it takes the place of the other
        self._part.replace(self.path)
        folder = os.open(self.path.parent, os.O_RDONLY)
        try:
            with suppress(OSError):  # some file systems keep names without being asked
                os.fsync(folder)
        finally:
            os.close(folder)


def encode(totals: Totals) -> bytes:
    """Write totals as a line of JSON with a checksum."""
    values: dict[str, Any] = {
        'pedometer_totals': VERSION,
        'steps': totals.steps,
        'distance': totals.distance,
        'step_length': totals.step_length,
    }
    values['crc32'] = f'{crc32(json.dumps(values).encode()):08x}'
    return f'{json.dumps(values)}\n'.encode()


def decode(data: bytes) -> Totals:
    """Read totals; raises `DamagedStateError` for all bytes that `encode` does not write."""
    try:
        values = json.loads(data)
        totals = Totals(values['steps'], values['distance'], values['step_length'])
        whole = encode(totals) == data
    except (ValueError, LookupError, TypeError, RecursionError) as error:
        raise DamagedStateError('it holds no totals of a pedometer, or not all') from error
    if not whole:
        raise DamagedStateError('its version or checksum is another')
    lengths = (totals.distance, totals.step_length)
    if not (
        type(totals.steps) is int
        and 0 <= totals.steps <= MOST_STEPS
        and all(type(length) is float and isfinite(length) and length >= 0.0 for length in lengths)
    ):
        raise DamagedStateError(f'{totals} are no totals')
    return totals


def _locked(path: Path) -> int:
    """Return the descriptor of a lock on a file, which others replace."""
    lock = os.open(path.with_name(f'.{path.name}.lock'), os.O_RDWR | os.O_CREAT, 0o666)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(lock)
        raise BlockingIOError(EWOULDBLOCK, 'another node keeps its totals there') from None
    except OSError:
        pass  # the file system knows no locks
    return lock


def _numbered(path: Path, number: int) -> Path:
    return path.with_name(f'{path.name}.damaged{number}')
