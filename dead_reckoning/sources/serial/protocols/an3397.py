"""The board of Freescale AN3397: it integrates itself and sends positions, seven bytes each.

``core.reference.an3397_frame`` has the frame, ``core.reference.an3397`` the program that sends it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from dead_reckoning.core.errors import FrameError, SettingsError
from dead_reckoning.core.parameters import Derived, Settings, parameter
from dead_reckoning.core.reference.an3397 import AVERAGED, CALIBRATED, Positioning
from dead_reckoning.core.reference.an3397_frame import (
    END_OF_FRAME,
    HEAD,
    LENGTH,
    SENT_BITS,
    decode,
)
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.sources.serial.frames import Frames
from dead_reckoning.sources.serial.protocols import Event, Measurement, Position

COUNT = 3.3 / 256 / 0.8 * GRAVITY * 0.01**2
"""A count of position [m]: one of acceleration, 16.1 mg of eight bits, for an update of 10 ms."""


@dataclass(frozen=True, kw_only=True)
class An3397Settings(Settings, prefix='driver.serial.an3397'):
    """Positions of the board of AN3397; the document gives neither scale nor last byte."""

    counts_per_unit: int = parameter(
        64, 'Counts of position in a unit of what is sent, a power of two: 2^24 by 2^18, by which '
        'the program shifts up',
        minimum=1, maximum=1 << SENT_BITS,
    )  # fmt: skip
    metres_per_unit: float = parameter(
        Derived(
            lambda settings: settings.counts_per_unit * COUNT,
            'that of 8 bits at ±1.5 g and 100 updates a second',
        ),
        'Way of a unit; measure it, by a known way',
        unit='m', minimum=1e-9, maximum=1000.0,
    )  # fmt: skip
    end_of_frame: int = parameter(
        END_OF_FRAME, 'Last byte of a frame; the document does not say it', minimum=0, maximum=255
    )

    def validate(self) -> None:
        """Raise `SettingsError` for counts that no shift gives."""
        if self.counts_per_unit.bit_count() != 1:
            raise SettingsError(
                f'driver.serial.an3397.counts_per_unit: {self.counts_per_unit} is not allowed; a '
                'power of two, as 64'
            )

    @property
    def shift(self) -> int:
        """By how many bits the program shifts its positions up."""
        return SENT_BITS + 1 - self.counts_per_unit.bit_length()


class An3397Decoder(Frames):
    """Read positions; there is no acceleration in them."""

    Settings: ClassVar[type[Settings]] = An3397Settings
    BITS = 8  # of the conversions that the program takes
    OUTPUT = 'an3397/odom'
    FIRST = bytes((HEAD,))
    SHAPE = 'frame of AN3397, 03 … 01 01 and driver.serial.an3397.end_of_frame'
    unit = 'counts'

    def __init__(self, settings: An3397Settings) -> None:
        super().__init__()
        self._settings = settings
        self._metres_per_count = settings.metres_per_unit / settings.counts_per_unit

    def _read(self, data: bytes, at: int, events: list[Event]) -> int | None:
        frame = data[at : at + LENGTH]
        if len(frame) < LENGTH:
            return None
        try:
            x, y = decode(frame, self._settings.shift, self._settings.end_of_frame)
        except FrameError:
            return 0
        scale = self._metres_per_count
        events.append(Position(x * scale, y * scale, self._before + at))
        return LENGTH


class An3397Board:
    """Run the program of the document on the counts, of which it takes the low byte.

    The first 1024 at rest are its zero; then each 64 make a position.
    """

    RATE: ClassVar[float] = 6400.0
    """Conversions a second: 64 within the 10 ms that the default metres are for."""

    def __init__(self, settings: An3397Settings) -> None:
        self._program = Positioning(shift=settings.shift, end_of_frame=settings.end_of_frame)
        self._needed = CALIBRATED
        self._taken = self._x = self._y = 0
        self._calibrated = False

    def hear(self, data: bytes) -> bytes:
        """Take no notice."""
        return b''

    def measure(self, measurement: Measurement) -> bytes:
        """Return a frame after each 64 measurements, nothing after the others."""
        x, y, _ = measurement.values['counts']
        self._x += round(x) & 0xFF
        self._y += round(y) & 0xFF
        self._taken += 1
        if self._taken < self._needed:
            return b''
        total_x, total_y = self._x, self._y
        self._needed = AVERAGED
        self._taken = self._x = self._y = 0
        if not self._calibrated:
            self._program.calibrate(total_x, total_y)
            self._calibrated = True
            return b''
        return self._program.update(total_x, total_y).frame


PROTOCOL, BOARD = An3397Decoder, An3397Board
