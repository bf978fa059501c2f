"""Take one message from bytes to bytes, on a memory that stays.

The equations are those of the kernels for blocks, which take a block of one sample here.  `take`
is a whole chain with an integrator.  With the navigator its own kernels come between `read` and
`write`: detectors of rest are many, and its state is an array of its own.
"""

from __future__ import annotations

from typing import Any

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import (
    Array,
    ImuColumns,
    matrix,
    put,
    quaternion,
    triple,
    vector,
)
from dead_reckoning.core.kernels.gravity import LevelledColumns, level_held, level_message
from dead_reckoning.core.kernels.headings import find_headings
from dead_reckoning.core.kernels.integrator import StateColumns, integrate
from dead_reckoning.core.kernels.memory import (
    AS_LEVELLED,
    ATTITUDE,
    CLOCK,
    COUNTED,
    GRAVITY,
    HEAD,
    HEADED,
    HEADING,
    HEADING_VARIANCE,
    HOLD,
    IMU,
    LAST,
    LIMIT,
    LINE,
    LONGEST,
    NAVIGATED,
    NOISE,
    NOTHING,
    ODOMETRY,
    REQUIRED,
    STAMP,
    TAIL,
    TILT,
    cells_of,
    growth_of,
    headings_of,
    levelled_of,
    motion_of,
    part,
    rules_of,
    state_of,
    table,
    ticks,
)  # fmt: skip
from dead_reckoning.core.kernels.messages import read_imu, write_cross, write_odometry
from dead_reckoning.core.kernels.navigation.filter import regular
from dead_reckoning.core.kernels.navigation.layout import state_columns
from dead_reckoning.core.kernels.resampler import resample
from dead_reckoning.core.rotation import NO_ROTATION

IRREGULAR = -1
RESTS, HEADS, CELL = 1, 2, 4
"""What a sample brought: rest, a heading, a number of cells."""


@compiled
def take(memory: Array) -> int:
    """Take the Imu that lies in the memory; write the Odometry, and say what the sample brought.

    `IRREGULAR` says that nothing has changed: the sample is one for the stream.
    """
    clock = ticks(memory, CLOCK)
    imu = read_imu(part(memory, IMU), clock[STAMP : STAMP + 1])
    stamp_ns, last_ns = clock[STAMP], clock[LAST]
    if not _in_time(clock):
        return IRREGULAR
    levelled = levelled_of(memory)
    usable, turned = _level(memory, imu, last_ns, levelled)
    if not usable:
        return IRREGULAR
    usable, found = _find_heading(memory, clock, turned if clock[COUNTED] == AS_LEVELLED else imu)
    if not usable:
        return IRREGULAR
    state = state_of(memory)
    if not integrate(
        turned,
        levelled.acceleration,
        levelled.covariance,
        0,
        last_ns,
        rules_of(memory),
        motion_of(memory),
        growth_of(memory),
        state,
    ):
        return IRREGULAR
    write_odometry(stamp_ns, state, part(memory, ODOMETRY))
    return _count(memory, clock, imu, found) + (RESTS if state.stationary[0] else 0)


@compiled
def read(memory: Array, rows: Array) -> int:
    """Read the Imu that lies in the memory as the row, shape (1, ROW), that a navigator filters.

    Returns what `take` returns, but for rest, and that after the sample was counted too.
    """
    clock = ticks(memory, CLOCK)
    imu = read_imu(part(memory, IMU), clock[STAMP : STAMP + 1])
    if not _in_time(clock):
        return IRREGULAR
    max_gap, variance = part(memory, NAVIGATED)[0], part(memory, NAVIGATED)[1]
    if not regular(imu, 0, clock[LAST], max_gap, variance, rows):
        return IRREGULAR
    usable, found = _find_heading(memory, clock, imu)
    if not usable:
        return IRREGULAR
    return _count(memory, clock, imu, found)


@compiled
def write(memory: Array, rows: Array, stamp_ns: int) -> None:
    """Write a state of the navigator, shape (1, STATE_ROW), as the Odometry of a stamp."""
    p, v, q, pp, vv, qq, w, ww, of_pose, of_twist = state_columns(rows)
    state = StateColumns(p, v, q, pp, vv, qq, w, ww, w[0])
    message = part(memory, ODOMETRY)
    write_odometry(stamp_ns, state, message)
    write_cross(matrix(of_pose, 0), matrix(of_twist, 0), message)


def _in_time(clock: Any) -> bool:
    """Say whether a sample comes after the last one, and soon."""
    return bool(clock[STAMP] != 0 and 0 < clock[STAMP] - clock[LAST] <= clock[LONGEST])


def _find_heading(memory: Array, clock: Any, imu: ImuColumns) -> tuple[int, int]:
    """Look for the heading that steps need: whether that is regular, and whether it is there."""
    if clock[HEADED] == NOTHING:
        return 1, 0
    return find_headings(
        imu,
        0,
        clock[HEADING],
        part(memory, HEADING_VARIANCE)[0],
        clock[HEADED] == REQUIRED,
        headings_of(memory),
    )


def _count(memory: Array, clock: Any, imu: ImuColumns, found: int) -> int:
    """Take a sample that nothing refused; return what the steps get of it."""
    made = _wait(memory, clock, imu) if clock[COUNTED] != NOTHING else 0
    if found:
        clock[HEADING] = clock[STAMP]
    clock[LAST] = clock[STAMP]
    return CELL * made + HEADS * found


def _level(
    memory: Array, imu: ImuColumns, last_ns: int, out: LevelledColumns
) -> tuple[int, ImuColumns]:
    """Remove gravity; say whether that was regular, and return the Imu as it was used."""
    attitude = quaternion(table(memory, ATTITUDE, 4), 0)
    tilt, noise = matrix(table(memory, TILT, 9), 0), matrix(table(memory, NOISE, 9), 0)
    gravity = part(memory, GRAVITY)[0], part(memory, GRAVITY)[1]
    if attitude == NO_ROTATION:
        return level_message(imu, 0, last_ns, tilt, gravity, noise, out), imu
    regular = level_held(imu, 0, last_ns, attitude, tilt, gravity, noise, out)
    return regular, ImuColumns(
        imu.stamp_ns,
        imu.force,
        out.force_covariance,
        imu.rate,
        imu.rate_covariance,
        out.orientation,
        out.orientation_covariance,
    )


def _wait(memory: Array, clock: Any, imu: ImuColumns) -> int:
    """Let a sample wait in line, as `StampOrder` does; return how many cells are complete."""
    stamps, forces = ticks(memory, LINE), table(memory, LINE + 1, 3)
    head, tail = clock[HEAD], clock[TAIL]
    if tail == len(stamps):
        for i in range(tail - head):
            stamps[i] = stamps[head + i]
            put(forces[i], triple(forces[head + i]))
        head, tail = 0, tail - head
    stamps[tail] = imu.stamp_ns[0]
    put(forces[tail], vector(imu.force, 0))
    tail += 1
    _, released, made = resample(
        stamps[head:tail],
        forces[head:tail],
        imu.force_covariance,
        tail - 1 - head,
        clock[LAST],
        clock[HOLD],
        clock[LIMIT],
        float(clock[LONGEST]),
        cells_of(memory),
    )
    clock[HEAD], clock[TAIL] = head + released, tail
    return int(made)
