"""Signals that end a process, made to unwind it."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def unwinding(*signals: signal.Signals) -> Iterator[None]:
    """Let signals that would end this at once end it as Ctrl-C does: nothing is left half done.

    Those that are ignored, or handled already, stay so.
    """

    def end(number: int, frame: FrameType | None) -> None:
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
