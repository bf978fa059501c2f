"""Load compiled code beside the traffic, and have it compiled first where nothing is kept."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from collections.abc import Callable
from threading import Event, Thread

from dead_reckoning.core.kernels import SLOW, accelerated, kept
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.live import take
from dead_reckoning.core.kernels.memory import nothing
from dead_reckoning.live import LiveChain
from dead_reckoning.nodes.chain_node import ChainNode

COMPILE = (
    'import os; os.nice(19); '
    'from dead_reckoning.core.kernels.live import take; '
    'from dead_reckoning.core.kernels.memory import nothing; take(nothing())'
)

QUICK = 0.0005
"""How long [s] the traffic waits at most for Python, where that is loading; else it is 5 ms."""

PATIENCE = 0.2
"""How often [s] to look whether the compiler is done, and so the longest that an end waits."""


def load(node: ChainNode, chain: LiveChain) -> None:
    """Give a chain its kernel once it is there.

    Loading takes half a second, so it is left to a thread.  Compiling takes many, so it is left to
    a process that has the lowest priority; without a place to keep its work, or without numba, the
    chain goes on without a kernel.
    """
    if os.environ.get('NUMBA_DISABLE_JIT', '0') != '0':
        return  # numba would say so too, once its 20 MB are loaded
    ends = Event()

    def work() -> None:
        chain.kernel = _loaded()
        if chain.kernel is None and not accelerated():
            node.get_logger().warning(SLOW)
        elif chain.kernel is None and _compiled(ends):
            chain.kernel = _loaded()

    thread = Thread(target=work, name='loading')

    def close() -> None:
        ends.set()
        thread.join()

    node.at_end(close)
    thread.start()


def _loaded() -> Callable[[Array], int] | None:
    """Return the kernel if it is kept, and keep the traffic waiting as little as possible."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(QUICK)
    gc.disable()  # hundreds of thousands of objects come, all of which stay
    try:
        return kept(take, nothing())
    finally:
        gc.freeze()
        gc.enable()
        sys.setswitchinterval(interval)


def _compiled(ends: Event) -> bool:
    """Compile in another process; say whether that went well, and was waited for."""
    with subprocess.Popen(
        [sys.executable, '-c', COMPILE],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,  # Ctrl-C is for the node
    ) as compiler:
        while compiler.poll() is None:
            if ends.wait(PATIENCE):
                compiler.terminate()
    return compiler.returncode == 0
