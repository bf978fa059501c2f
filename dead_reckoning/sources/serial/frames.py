"""Find frames of bytes in a stream, whatever else is in it: what binary protocols share."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from dead_reckoning.core.errors import CutError, FrameError, ReadingError
from dead_reckoning.sources.serial.protocols import Decoder, Event

_CUT = CutError('a frame without its beginning or its end, where the port was opened or lost')


class Frames(Decoder):
    """Find frames; a subclass says in `_read` where one stands and what is in it.

    What is no frame is skipped a byte at a time, so that no good frame in it is missed.  A run of
    skipped bytes is one error: `CutError` after a start, where the rest of a frame is to be
    expected, else `FrameError`.
    """

    FIRST: ClassVar[bytes]
    """The byte that a frame begins with."""
    SHAPE: ClassVar[str]
    """What a frame is, in words."""

    def __init__(self) -> None:
        self._rest = b''
        self._before = 0
        """Bytes fed before the rest."""
        self._skipped: ReadingError | None = _CUT
        """What the next skipped byte is called; None within a run of them."""
        self._in_step = False
        """Whether a frame ended where the next bytes begin."""

    def feed(self, data: bytes) -> list[Event]:
        """Take the next bytes and return what the frames in them say."""
        data = self._rest + data
        events: list[Event] = []
        at = 0
        while at < len(data):
            begin = data.find(self.FIRST, at)
            if begin != at:
                self._skip(events)
                at = len(data) if begin < 0 else begin
                continue
            taken = self._read(data, at, events)
            if taken is None:
                break
            if taken:
                at += taken
                self._in_step = True
                self._skipped = FrameError(
                    f'bytes that are no {self.SHAPE}: driver.serial.baud or '
                    'driver.serial.protocol does not fit, or the line is disturbed'
                )
            else:
                self._skip(events)
                at += 1
        self._before += at
        self._rest = data[at:]
        return events

    def restart(self) -> list[Event]:
        """Forget the frame that has begun."""
        cut = bool(self._rest)
        self._before += len(self._rest)
        self._rest = b''
        self._skipped = _CUT
        self._in_step = False
        return [_CUT] if cut else []

    def _skip(self, events: list[Event]) -> None:
        self._in_step = False
        if self._skipped is not None:
            events.append(self._skipped)
            self._skipped = None

    @abstractmethod
    def _read(self, data: bytes, at: int, events: list[Event]) -> int | None:
        """Read a frame that begins at a place of ``data``; add what it says to ``events``.

        Returns its length, 0 if there is none, None if that takes more bytes to tell.  What it
        decides must not depend on the bytes beyond those it needs.
        """
