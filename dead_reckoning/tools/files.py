"""Files that are complete or absent, whatever goes wrong while they are written."""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from dead_reckoning.core.errors import InputError

PREFIX = '.dead-reckoning-'


@contextmanager
def complete_or_absent(folder: Path, names: Collection[str]) -> Iterator[Path]:
    """Give a folder to write in, whose files take their places in ``folder`` in the end.

    There they replace those of ``names``, also where they were not written.  If anything goes
    wrong before, ``folder`` is as it was; what a killed process left there is taken away by the
    next one.  Raises `InputError` where it can't be written.
    """
    with made(folder), _shared(folder):
        try:
            # Beside their places, since only within a file system a rename is one step.
            part = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))
        except OSError as error:
            raise _refused(folder, error) from error
        try:
            yield part
            for name in names:
                _install(part, folder, name)
        finally:
            shutil.rmtree(part, ignore_errors=True)


@contextmanager
def made(folder: Path) -> Iterator[None]:
    """Make a folder, and those it is in; in the end take away those in which nothing is.

    Raises `InputError` where that can't be done.
    """
    try:
        new = [path for path in (folder, *folder.parents) if not path.exists()]
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _refused(folder, error) from error
    try:
        yield
    finally:
        with suppress(OSError):  # what is not empty stays, and so does what it is in
            for path in new:
                path.rmdir()


@contextmanager
def _shared(folder: Path) -> Iterator[None]:
    """Share a lock on a folder with all who write there.

    The system takes it from who dies, so that who gets it alone knows that nobody writes there,
    and takes away what is half done.
    """
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise _refused(folder, error) from error
    try:
        with suppress(OSError):  # others write there, or the file system knows no locks
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            for left in folder.glob(f'{PREFIX}*'):
                shutil.rmtree(left, ignore_errors=True)
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_SH)
        yield
    finally:
        os.close(descriptor)


def _refused(folder: Path, error: OSError) -> InputError:
    return InputError(f'--output {folder}: {error.strerror}; name a folder of yours')


def _install(part: Path, folder: Path, name: str) -> None:
    new, place, old = part / name, folder / name, part / f'{name}.old'
    if new.exists() and not place.is_dir():
        new.replace(place)
        return
    if place.exists():
        place.rename(old)
    if new.exists():
        new.rename(place)
