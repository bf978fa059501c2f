"""A bar on the terminal that says how far a replay is."""

from __future__ import annotations

import sys
import time
from types import TracebackType

WIDTH = 30
PERIOD = 0.1
"""How often it is drawn at most [s]."""


class Progress:
    """Draw a bar on stderr where that is a terminal, and nothing elsewhere."""

    def __init__(self, words: str, total: int, watched: bool = True) -> None:
        self._words = words
        self._total = max(1, total)
        self._done = 0
        self._drawn = -PERIOD
        self._shown = watched and sys.stderr.isatty()

    def __enter__(self) -> Progress:
        self.add(0)  # the first block may take long, where nothing is compiled yet
        return self

    def add(self, count: int) -> None:
        """Say that so much more is done."""
        self._done += count
        now = time.monotonic()
        if self._shown and now - self._drawn >= PERIOD:
            self._drawn = now
            part = min(1.0, self._done / self._total)
            bar = '█' * round(part * WIDTH)
            sys.stderr.write(f'\r{self._words} {bar:░<{WIDTH}} {part:4.0%} ')
            sys.stderr.flush()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        where: TracebackType | None,
    ) -> None:
        """Wipe the bar away."""
        if self._shown:
            sys.stderr.write('\r\x1b[K')
            sys.stderr.flush()
