"""Load compiled code beside the traffic, and have it compiled first where nothing is kept."""

from __future__ import annotations

import gc
import os
import sys
from threading import Event, Thread

from dead_reckoning.core import kernels
from dead_reckoning.live import LiveChain
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.compiling import PATIENCE, compiled_apart, say_slow

COMPILE = (
    'import os, sys; os.nice(19); '
    'from dead_reckoning import live; getattr(live, sys.argv[1]).compile()'
)

QUICK = 0.0005
"""How long [s] the traffic waits at most for Python, where that is loading; else it is 5 ms."""


def load(node: ChainNode, chain: LiveChain) -> None:
    """Let a chain use its kernels once they are there.

    Loading takes half a second, so it is left to a thread.  Compiling takes many, so it is left to
    a process that has the lowest priority; without a place to keep its work, or without numba, the
    chain goes on without kernels.
    """
    if os.environ.get('NUMBA_DISABLE_JIT', '0') != '0':
        return  # numba would say so too, once its 20 MB are loaded
    ends = Event()

    def work() -> None:
        chain.ready = _loaded(chain)
        if chain.ready:
            return
        if kernels.accelerated():
            chain.ready = _compiled(chain, ends) and _loaded(chain)
        else:
            say_slow(node)

    thread = Thread(target=work, name='loading')

    def close() -> None:
        ends.set()
        thread.join()

    node.at_end(close)
    thread.start()


def _loaded(chain: LiveChain) -> bool:
    """Load the kernels if they are kept, and keep the traffic waiting as little as possible."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(QUICK)
    gc.disable()  # hundreds of thousands of objects come, all of which stay
    try:
        return all(kernels.load(kernel, *arguments) for kernel, arguments in chain.KERNELS)
    finally:
        gc.freeze()
        gc.enable()
        sys.setswitchinterval(interval)


def _compiled(chain: LiveChain, ends: Event) -> bool:
    """Compile in another process; say whether that went well, and was waited for."""
    return compiled_apart([COMPILE, type(chain).__name__], lambda: ends.wait(PATIENCE))
