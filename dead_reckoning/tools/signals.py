"""Signals that end a process, made to unwind it."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Timer
from types import FrameType

SOON = 0.01
"""After so long [s] a signal that came while a module is imported is heard again."""


@contextmanager
def unwinding(*signals: signal.Signals) -> Iterator[None]:
    """Let signals that would end this at once end it as Ctrl-C does: nothing is left half done.

    Those that are ignored, or handled already, stay so.
    """

    def end(number: int, frame: FrameType | None) -> None:
        if frame is not None and frame.f_code.co_filename.startswith('<frozen importlib'):
            # In some of its callbacks Python prints what is raised, and goes on.
            Timer(SOON, signal.raise_signal, (number,)).start()
            return
        signal.signal(number, lambda *_: None)  # to tidy up takes a while, and more may come
        sys.exit(128 + number)

    chosen = [number for number in signals if signal.getsignal(number) == signal.SIG_DFL]
    for number in chosen:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in chosen:
            signal.signal(number, signal.SIG_DFL)
