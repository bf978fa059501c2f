"""Lay out all that a chain keeps, knows, takes and gives as parts of one array.

Each array that a compiled function takes costs a tenth of a microsecond, so `live.take` takes but
one.  The functions that find parts are used by Python and by kernels alike.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.kernels.bias_growth import Growth
from dead_reckoning.core.kernels.columns import Array, matrix
from dead_reckoning.core.kernels.gravity import LevelledColumns
from dead_reckoning.core.kernels.headings import HeadingColumns
from dead_reckoning.core.kernels.integrator import Motion, Rules, StateColumns
from dead_reckoning.core.kernels.resampler import Cells

IMU_DOUBLES, ODOMETRY_DOUBLES = 37, 85
"""Doubles at the ends of the messages."""

IMU, ODOMETRY, CLOCK, ATTITUDE, TILT, GRAVITY, NOISE = range(7)
LEVELLED = 7
STATE = LEVELLED + len(LevelledColumns._fields)
RULES = STATE + len(StateColumns._fields)
MOTION = RULES + 5
GROWTH = MOTION + len(Motion._fields)
CELLS = GROWTH + len(Growth._fields)
LINE = CELLS + len(Cells._fields)
HEADINGS = LINE + 2
HEADING_VARIANCE = HEADINGS + len(HeadingColumns._fields)
NAVIGATED = HEADING_VARIANCE + 1
PARTS = NAVIGATED + 1
"""Parts of the memory, the first of several: the messages, each from four bytes before it on, so
that its doubles are aligned; whole numbers, by the names below; attitude, or zeros where it comes
with the message, its covariance, gravity and its variance, covariance of the force; what the
kernels make, know and keep; stamps and forces of the samples that wait in order; headings, and the
variance of those without one; for the navigator, whose state is its own, the longest step and the
variance of a rate without one."""

STAMP, LAST, LONGEST, COUNTED, HEADED, HEADING, HOLD, LIMIT, HEAD, TAIL = range(10)
"""Elements of the clock: stamps of this sample and the last, longest step; what steps are counted
in, and what headings are for; stamp of the newest; time and number of samples that wait, and where
their line begins and ends."""

NOTHING = 0
AS_IT_CAME, AS_LEVELLED = 1, 2
"""In what steps are counted."""

WELCOME, REQUIRED = 1, 2
"""What an orientation is for those headings."""


def packed(parts: Mapping[int, NDArray[Any]]) -> Array:
    """Return arrays as parts of a memory, whose first words say where each begins."""
    empty = np.zeros(0)
    words = [
        np.ravel(part).view(np.float64) if part.dtype == np.int64 else np.ravel(part).astype(float)
        for part in (parts.get(number, empty) for number in range(PARTS))
    ]
    begins = np.cumsum([PARTS + 1, *map(len, words)])
    return np.concatenate([begins.view(np.float64), *words])


def numbered(first: int, parts: Iterable[NDArray[Any]]) -> dict[int, NDArray[Any]]:
    """Return parts that follow each other, by their numbers."""
    return dict(enumerate(parts, first))


def nothing() -> Array:
    """Return a memory in which no sample is, for whoever wants kernels to be compiled."""
    imu, odometry = (np.zeros(2 + doubles) for doubles in (IMU_DOUBLES, ODOMETRY_DOUBLES))
    return packed({IMU: imu, ODOMETRY: odometry, CLOCK: np.zeros(TAIL + 1, np.int64)})


def part(memory: Array, number: int) -> Array:
    """Return a part of a memory."""
    begins = memory.view(np.int64)
    return memory[begins[number] : begins[number + 1]]


def ticks(memory: Array, number: int) -> Any:
    """Return a part of whole numbers."""
    return part(memory, number).view(np.int64)


def table(memory: Array, number: int, width: int) -> Array:
    """Return a part as rows."""
    values = part(memory, number)
    return values.reshape((len(values) // width, width))


def motion_of(memory: Array) -> Motion:
    """Return the state of an integrator."""
    return Motion(
        part(memory, MOTION),
        part(memory, MOTION + 1),
        part(memory, MOTION + 2),
        part(memory, MOTION + 3),
        part(memory, MOTION + 4),  # type: ignore[arg-type]
        ticks(memory, MOTION + 5),
        table(memory, MOTION + 6, 3),
        ticks(memory, MOTION + 7),
        part(memory, MOTION + 8),
        part(memory, MOTION + 9),
    )


def growth_of(memory: Array) -> Growth:
    """Return the state of its covariance."""
    return Growth(
        table(memory, GROWTH, 7),
        table(memory, GROWTH + 1, 7),
        part(memory, GROWTH + 2),
        part(memory, GROWTH + 3),
        part(memory, GROWTH + 4),
        part(memory, GROWTH + 5),
        part(memory, GROWTH + 6),
        table(memory, GROWTH + 7, 7),
    )


def cells_of(memory: Array) -> Cells:
    """Return the state of a resampler, and what came out of it."""
    return Cells(
        ticks(memory, CELLS),
        part(memory, CELLS + 1),
        ticks(memory, CELLS + 2),
        part(memory, CELLS + 3),
        ticks(memory, CELLS + 4),
    )


def headings_of(memory: Array) -> HeadingColumns:
    """Return room for a heading."""
    return HeadingColumns(
        ticks(memory, HEADINGS),
        part(memory, HEADINGS + 1),
        part(memory, HEADINGS + 2),
        part(memory, HEADINGS + 3),
    )


def state_of(memory: Array) -> StateColumns:
    """Return the state after the last sample."""
    return StateColumns(
        table(memory, STATE, 3),
        table(memory, STATE + 1, 3),
        table(memory, STATE + 2, 4),
        table(memory, STATE + 3, 9),
        table(memory, STATE + 4, 9),
        table(memory, STATE + 5, 9),
        table(memory, STATE + 6, 3),
        table(memory, STATE + 7, 9),
        part(memory, STATE + 8),  # type: ignore[arg-type]
    )


def levelled_of(memory: Array) -> LevelledColumns:
    """Return room for what gravity removal makes."""
    return LevelledColumns(
        table(memory, LEVELLED, 3),
        table(memory, LEVELLED + 1, 9),
        table(memory, LEVELLED + 2, 9),
        table(memory, LEVELLED + 3, 4),
        table(memory, LEVELLED + 4, 9),
    )


def rules_in(rules: Rules) -> list[NDArray[Any]]:
    """Return rules as parts of a memory."""
    numbers = [float(value) for value in (*rules[:3], *rules[4:10])]
    return [np.array(numbers), rules.moves, *map(np.array, rules[10:])]


def rules_of(memory: Array) -> Rules:
    """Return the settings of an integrator."""
    numbers = part(memory, RULES)
    return Rules(
        numbers[0] != 0.0,
        numbers[1] != 0.0,
        numbers[2] != 0.0,
        part(memory, RULES + 1),  # type: ignore[arg-type]
        numbers[3],
        numbers[4],
        numbers[5],
        numbers[6],
        numbers[7],
        numbers[8],
        matrix(table(memory, RULES + 2, 9), 0),
        matrix(table(memory, RULES + 3, 9), 0),
        matrix(table(memory, RULES + 4, 9), 0),
    )
