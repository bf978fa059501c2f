"""Files that are complete or absent, whatever goes wrong while they are written."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from dead_reckoning.core.errors import InputError

PREFIX = '.replay-'


@contextmanager
def complete_or_absent(folder: Path, names: Collection[str]) -> Iterator[Path]:
    """Give a folder to write in, whose files take their places in ``folder`` in the end.

    There they replace those of ``names``, also where they were not written.  If anything goes
    wrong before, ``folder`` is as it was.  Raises `InputError` where it can't be written.
    """
    existed = folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Beside their places, since only within a file system a rename is one step.
        part = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder))
    except OSError as error:
        raise InputError(f'--output {folder}: {error.strerror}; name a folder of yours') from error
    try:
        yield part
        for name in names:
            _install(part, folder, name)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        if not existed:
            with suppress(OSError):  # if others have put something there
                folder.rmdir()
        raise
    shutil.rmtree(part, ignore_errors=True)


def _install(part: Path, folder: Path, name: str) -> None:
    new, place, old = part / name, folder / name, part / f'{name}.old'
    if new.exists() and not place.is_dir():
        new.replace(place)
        return
    if place.exists():
        place.rename(old)
    if new.exists():
        new.rename(place)
