"""Freescale's ZSTAR (RD3152MMA7260Q): a sensor on a radio, behind a USB stick that is polled.

The commands are those of its reference manual, section 5.4: a letter each, values of 8 bits, no
checksum, no counter.  The stick answers with the last values that came over the radio, so polls
that are faster than it bring values twice.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import ClassVar

from dead_reckoning.core.errors import BoardError, CutError, FrameError
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.sensors.mma7260qt import PART
from dead_reckoning.sources.serial.protocols import Decoder, Event, Measurement, Reading

RANGES = tuple(PART.ranges)
"""Range ± [g] of each g-select, 0 to 3."""

TIMEOUT = 0.2
"""Time [s] after which an answer is given up."""

STALLED = 0.05
"""The same where something has come that is no answer yet."""

EARLY = 0.001
"""So much [s] too early is not too early to poll."""

UNANSWERED = 4
"""As many requests without an answer, and the board is greeted anew."""

SETTLING = 0.5
"""Time [s] that a g-select has to reach the sensor over the radio."""

CHECKED = 1.0
"""Time [s] from one check of the g-select to the next: the sensor may be switched off and on."""

LONGEST = 17
"""Bytes of the longest answer."""


@dataclass(frozen=True, kw_only=True)
class ZstarSettings(Settings, prefix='driver.serial.zstar'):
    """A ZSTAR (RD3152MMA7260Q), polled through its USB stick."""

    range_g: float = parameter(
        1.5, 'Range that the board is told to take by its g-select, ±; driver.range_g is the same',
        unit='g', choices=RANGES,
    )  # fmt: skip
    poll_rate: float = parameter(
        50.0,
        'How often the board is asked; more often than it measures brings values twice',
        unit='Hz', minimum=1.0, maximum=100.0,
    )  # fmt: skip
    request: str = parameter(
        'v',
        'What it is asked: v, or V, whose answer lacks the buttons. They are not used, but a byte '
        'that is lost or doubled always shows in the longer answer',
        choices=('v', 'V'),
    )


class ZstarDecoder(Decoder):
    """Greet the board, see to its range, and poll it.

    The greeting comes first, since a digit or a letter from A to F selects a radio channel while
    the link is down: only a board that has answered, and has another range, is told a g-select.
    Readings come when it says that it has the right one, which is asked again once a second.  An
    answer to greeting or check counts only if nothing else came with it.  Without answers it is
    greeted anew.
    """

    Settings: ClassVar[type[Settings]] = ZstarSettings
    BITS: ClassVar[int | None] = 8
    POLLED: ClassVar[bool] = True
    HELLO: ClassVar[bytes] = b'R'
    READY: ClassVar[bytes] = b'N'
    ANSWERS: ClassVar[dict[str, bytes]] = {'V': rb'x(.)y(.)z(.)', 'v': rb'x(.)y(.)z(.)b.'}

    def __init__(self, settings: ZstarSettings) -> None:
        self.unit = 'counts'
        self.range_g = settings.range_g
        self._range = RANGES.index(settings.range_g)
        self._poll = settings.request.encode()
        self._period = 1.0 / settings.poll_rate
        answers = {
            self.HELLO: self.READY,
            b'G': rb'[0-3\x00-\x03]',
            self._poll: self.ANSWERS[settings.request],
        }
        self._answers = {asked: re.compile(answers[asked], re.DOTALL) for asked in answers}
        self._fed = 0
        self._begin()

    def _begin(self) -> None:
        self._next = self.HELLO
        self._asked = b''
        self._answered = True
        self._answer = b''
        self._stray = False
        self._unanswered = 0
        self._unchecked = 0.0
        self._behind = 0.0
        self._had_range = False
        self._late: list[Event] = []

    def feed(self, data: bytes) -> list[Event]:
        """Take the next bytes and return the reading that they complete, if one was asked for."""
        if not data:
            return []
        self._fed += len(data)
        events, self._late = self._late, []
        alone = self._asked != self._poll
        if self._answered or (alone and self._stray):
            self._stray = True
            return events
        answer, pattern = self._answer + data, self._answers[self._asked]
        found = pattern.match(answer) if alone else pattern.search(answer)
        if found is None:
            self._stray |= alone or len(answer) > LONGEST
            self._answer = answer[-LONGEST:]
            return events
        self._stray |= found.start() > 0 or found.end() < len(answer)
        self._answered, self._answer, self._unanswered = True, b'', 0
        return events + self._take(found, self._fed - len(answer) + found.start())

    def _take(self, found: re.Match[bytes], start: int) -> list[Event]:
        """Take the answer to what was asked, and see what is to be said next."""
        if self._asked == self.HELLO:
            self._next = b'G'
            return []
        if self._asked == self._poll:
            x, y, z = found.groups()
            return [Reading((self._value(x), self._value(y), self._value(z)), start)]
        range_ = found[0][0] & 0x0F
        if range_ != self._range:
            self._next = b'g%d' % self._range
            return [self._wrong(range_)] if self._had_range else []
        self._next, self._unchecked, self._had_range = self._poll, 0.0, True
        return []

    def _value(self, raw: bytes) -> float:
        return float(raw[0])

    def _wrong(self, range_: int) -> BoardError:
        return BoardError(
            f'the board has g-select {range_}, ±{RANGES[range_]:g} g, and '
            f'{self.Settings.prefix}.range_g asks for ±{self.range_g:g} g: was it reset, or is it '
            'out of reach? It is told again; nothing is read until it has the right one'
        )

    def due(self, waited: float) -> bytes:
        """Return the next request: after an answer at the rate of the polls, else in a while."""
        if not self._answered:
            pause = STALLED if self._answer or self._stray else TIMEOUT
        elif self._asked[:1] == b'g':
            pause = SETTLING
        else:  # a check of the g-select takes the place of no poll
            pause = (0.0 if self._asked == b'G' else self._period) - self._behind
        if waited < pause - EARLY:
            return b''
        # What is late makes the next one sooner, so that the rate is kept.
        self._behind = min(waited - pause, 0.5 * self._period) if self._asked else 0.0
        self._close()
        if self._next == self._poll:
            self._unchecked += min(waited, CHECKED)
            if self._unchecked > CHECKED:
                self._next = b'G'
        self._asked, self._answered = self._next, False
        if self._asked[:1] == b'g':
            self._answered, self._next, self._had_range = True, b'G', True
        return self._asked

    def _close(self) -> None:
        """See what is left of the last request."""
        damaged = self._stray or self._answer != b''
        if damaged and self._asked in self._answers:
            self._late = [_DAMAGED]
            if self._asked != self._poll:
                self._next = self.HELLO
        if not self._answered:
            self._unanswered += 1
            if self._unanswered >= UNANSWERED:
                self._next, self._unanswered = self.HELLO, 0
        self._answer, self._stray = b'', False

    def restart(self) -> list[Event]:
        """Forget the answer that has begun; the board is greeted anew."""
        events = [*self._late, *([_CUT] if self._answer else [])]
        self._begin()
        return events


_DAMAGED = FrameError(
    'bytes that are no answer of the board: driver.serial.protocol does not fit, or the line is '
    'disturbed'
)
_CUT = CutError('an answer without its end, where the port was lost')


class ZstarBoard:
    """Answer as the stick does, with the last values; the radio link is down until there are some.

    While it is down all that is heard is the choice of a radio ``channel``, None as long as the
    stick chooses.  A g-select reaches the sensor with the next measurement.
    """

    BITS: ClassVar[int] = 8
    GREETINGS: ClassVar[dict[bytes, bytes]] = {b'R': b'N', b'r': b'Z'}
    GRAVITY: ClassVar[float] = PART.ranges[1.5] / PART.supply[0]
    """What 1 g adds to a value at ±1.5 g, as a part of the whole scale."""

    def __init__(self, settings: ZstarSettings) -> None:
        self.channel: int | None = None
        self._sensitivity = PART.ranges[settings.range_g]
        self._values = (0, 0, 0)
        self._linked = False
        self._range = self._asked_range = 0
        self._selecting = False
        self._debug = False

    def hear(self, data: bytes) -> bytes:
        """Return the answers to commands."""
        return b''.join(self._hear(data[i : i + 1]) for i in range(len(data)))

    def _hear(self, letter: bytes) -> bytes:
        selecting, self._selecting = self._selecting, letter == b'g'
        if not self._linked:
            if letter in b'0123456789ABCDEF':
                self.channel = int(letter, 16)
        elif selecting and letter in b'0123':
            return self._select(int(letter))
        elif letter in self.GREETINGS:
            self._debug = False
            return self._greet(letter)
        elif letter in b'Uu':
            self._debug = letter == b'U'
        elif letter == b'G':
            return b'%d' % self._range
        elif letter == b'I':
            return b'ZSTAR, emulated\r\n'
        elif letter in b'VvK':
            return self._tell(letter)
        return b''

    def _select(self, range_: int) -> bytes:
        self._asked_range = range_
        return b''

    def _greet(self, letter: bytes) -> bytes:
        return self.GREETINGS[letter]

    def _tell(self, letter: bytes) -> bytes:
        if letter == b'K':
            middle, one_g = self._middle, round(2 * self._middle * self.GRAVITY)
            pair = self._number(middle) + self._number(middle + one_g)
            return b''.join(axis + pair for axis in (b'X', b'Y', b'Z'))
        x, y, z = (self._number(value) for value in self._values)
        return b'x' + x + b'y' + y + b'z' + z + (self._more() if letter == b'v' else b'')

    def _more(self) -> bytes:
        """Return what an answer to v has besides: the buttons."""
        return b'b\x00'

    @property
    def _middle(self) -> int:
        return 1 << self.BITS - 1

    def _number(self, value: int) -> bytes:
        return bytes([value])

    def measure(self, measurement: Measurement) -> bytes:
        """Keep the values, as of the range that the sensor has; say something in debug mode."""
        self._linked, self._range = True, self._asked_range
        scale = PART.ranges[RANGES[self._range]] / self._sensitivity
        x, y, z = (self._count(value, scale) for value in measurement.values['counts'])
        self._values = (x, y, z)
        return b'RX 200\r\n' if self._debug else b''

    def _count(self, value: float, scale: float) -> int:
        count = math.floor(self._middle + (value - self._middle) * scale + 0.5)
        return min(max(count, 0), 2 * self._middle - 1)


PROTOCOL, BOARD = ZstarDecoder, ZstarBoard
