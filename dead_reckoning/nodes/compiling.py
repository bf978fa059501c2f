"""Have code compiled in a process of its own, so that nothing else waits for it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress

PATIENCE = 0.2
"""How often [s] to look whether the compiler is done, and so the longest that an end waits."""


def compiled_apart(code: list[str], given_up: Callable[[], bool], given: bytes = b'') -> bool:
    """Run code, with its arguments, in a process of its own; say whether that went well.

    ``given`` is its input.  ``given_up`` waits for `PATIENCE`, and ends the process where it is
    true.
    """
    with subprocess.Popen(
        [sys.executable, '-c', *code],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C is for the node
    ) as compiler:
        assert compiler.stdin is not None
        with suppress(BrokenPipeError), compiler.stdin as pipe:
            pipe.write(given)
        while compiler.poll() is None:
            if given_up():
                compiler.terminate()
    return compiler.returncode == 0
