"""Files that are complete or absent."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dead_reckoning.core.errors import InputError


@contextmanager
def written_whole(path: Path) -> Iterator[Path]:
    """Give a path beside ``path`` to write to; it takes that name once all is written.

    Raises `InputError` where the folder can't be written.
    """
    partial = path.with_name(f'.{path.name}.{os.getpid()}.part')
    try:
        yield partial
        partial.replace(path)
    except OSError as error:
        raise InputError(f'{path}: can not be written ({error.strerror or error})') from error
    finally:
        partial.unlink(missing_ok=True)
