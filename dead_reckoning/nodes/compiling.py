"""Have code compiled in a process of its own, so that no signal waits for it."""

from __future__ import annotations

import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from dead_reckoning.core.kernels import SLOW, accelerated
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.run import StoppedError, stop_asked

COMPILE = 'import pickle, sys; load, *arguments = pickle.load(sys.stdin.buffer); load(*arguments)'

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


def prepare(
    node: ChainNode, kept: Callable[..., bool], load: Callable[..., None], *arguments: Any
) -> None:
    """Load kernels before samples come that would have to wait: ``load``, called with arguments.

    Where nothing is ``kept`` yet, which takes the first of these, another process compiles it, as
    a signal is not heard meanwhile.  Raises `StoppedError` for one.
    """
    if not accelerated():
        say_slow(node)
    elif not kept(arguments[0]):
        node.get_logger().info('compiling the kernels, once for all: up to a minute')
        compiled_apart([COMPILE], _given_up, pickle.dumps((load, *arguments)))
        if stop_asked():
            raise StoppedError
    load(*arguments)


def say_slow(node: ChainNode) -> None:
    """Say that numba is missing, once."""
    node.get_logger().warning(SLOW, once=True)


def _given_up() -> bool:
    time.sleep(PATIENCE)
    return stop_asked()
