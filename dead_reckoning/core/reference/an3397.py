"""Give what AN3397's program gives on its controller, integer for integer, frame for frame.

Freescale AN3397, *Implementing Positioning Algorithms Using Accelerometers*, section "Source
Code".  On the MC9S08QG8 an ``int`` has 16 bits, a ``long`` 32; both wrap, and ``>>`` of a negative
number floors.  Counts and updates are its units.  What the program does otherwise than one
expects, it does here too: ``docs/reference-algorithms.md`` lists it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from dead_reckoning.core.reference.an3397_frame import END_OF_FRAME, SHIFT, encode
from dead_reckoning.core.reference.wrap import signed

CALIBRATED = 1024
"""Conversions that make the zero."""

CALIBRATED_BITS = 10

AVERAGED = 64
"""Conversions of an update."""

AVERAGED_BITS = 6

WINDOW = 3
"""Accelerations up to this, on either side, count as none."""

QUIET = 25
"""Updates without acceleration after which there is no velocity."""

COUNTER = 0xFF
"""What the counter of these can hold: one byte."""


class Update(NamedTuple):
    """What the program holds at the end of an update, and what it has sent.

    Velocities are those after the check for the end of a movement, positions those after the shift
    and back; the frame went out between the two.
    """

    ax: int
    ay: int
    vx: int
    vy: int
    px: int
    py: int
    frame: bytes


@dataclass(slots=True, kw_only=True)
class Axis:
    """Integrate the sums of one axis twice; begin with zeros, as the controller's memory does.

    ``corrected``
        clear the accumulator before each update; the program leaves the last acceleration in it.
    ``shift``
        by how many bits the position goes up to be sent, and down again: 0 to 31.
    """

    corrected: bool = False
    shift: int = SHIFT
    zero: int = 0
    acceleration: int = 0
    velocity: int = 0
    position: int = 0
    quiet: int = 0

    def calibrate(self, total: int) -> None:
        """Take the sum of 1024 conversions at rest as zero; the zero before it is in the sum."""
        self.zero = (self.zero + total & 0xFFFFFFFF) >> CALIBRATED_BITS

    def update(self, total: int) -> None:
        """Go on by the sum of 64 conversions.

        The trapezoid is ``v += a' + ((a - a') >> 1)`` with the last acceleration a', and the same
        again for the position.
        """
        left = 0 if self.corrected else self.acceleration
        mean = signed(left + total, 16) >> AVERAGED_BITS
        acceleration = signed(mean - self.zero, 16)
        if -WINDOW <= acceleration <= WINDOW:
            acceleration = 0
        rise = signed(acceleration - self.acceleration, 16) >> 1
        velocity = signed(self.velocity + self.acceleration + rise, 32)
        way = signed(velocity - self.velocity, 32) >> 1
        position = signed(self.position + self.velocity + way, 32)
        self.acceleration = acceleration
        # Up and down again: the bits that leave at the top are lost.
        self.position = signed(position << self.shift, 32) >> self.shift
        self.quiet = 0 if acceleration else self.quiet + 1 & COUNTER
        self.velocity = 0 if self.quiet >= QUIET else velocity


class Positioning:
    """Run AN3397's program on two axes, sum by sum."""

    def __init__(
        self, *, corrected: bool = False, shift: int = SHIFT, end_of_frame: int = END_OF_FRAME
    ) -> None:
        self.x = Axis(corrected=corrected, shift=shift)
        self.y = Axis(corrected=corrected, shift=shift)
        self._shift = shift
        self._end_of_frame = end_of_frame

    def calibrate(self, total_x: int, total_y: int) -> None:
        """Take the sums of 1024 conversions at rest as zero."""
        self.x.calibrate(total_x)
        self.y.calibrate(total_y)

    def update(self, total_x: int, total_y: int) -> Update:
        """Go on by the sums of 64 conversions; return what the program then holds."""
        x, y = self.x, self.y
        x.update(total_x)
        y.update(total_y)
        frame = encode(x.position, y.position, self._shift, self._end_of_frame)
        return Update(
            x.acceleration, y.acceleration, x.velocity, y.velocity, x.position, y.position, frame
        )


def run(
    counts: npt.NDArray[np.int64],
    *,
    corrected: bool = False,
    shift: int = SHIFT,
    end_of_frame: int = END_OF_FRAME,
) -> list[Update]:
    """Return all updates of a recording, shape (n, 2): the first 1024 conversions calibrate.

    Then each 64 make an update; what is left at the end makes none, as the controller would still
    wait.  A count is one byte there: of a greater one, the low byte counts.
    """
    samples = counts.astype(np.uint8)
    program = Positioning(corrected=corrected, shift=shift, end_of_frame=end_of_frame)
    program.calibrate(*samples[:CALIBRATED].sum(axis=0, dtype=np.int64).tolist())
    moving = samples[CALIBRATED:]
    whole = len(moving) // AVERAGED * AVERAGED
    totals = moving[:whole].reshape(-1, AVERAGED, 2).sum(axis=1, dtype=np.int64)
    return [program.update(x, y) for x, y in totals.tolist()]
