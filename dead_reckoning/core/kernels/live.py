"""Take one message from bytes to bytes: the whole chain in one call, on a memory that stays.

The equations are those of the kernels for blocks, which take a block of one sample here.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import (
    Array,
    ImuColumns,
    matrix,
    measured,
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
    IMU_DOUBLES,
    LAST,
    LIMIT,
    LINE,
    LONGEST,
    NOISE,
    NOTHING,
    ODOMETRY,
    ODOMETRY_DOUBLES,
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
from dead_reckoning.core.kernels.resampler import resample
from dead_reckoning.core.rotation import (
    NO_ROTATION,
    matrix_from_quaternion,
    rotate_back,
    rotate_covariance,
)
from dead_reckoning.core.samples import NANOSECONDS, UNMEASURED_VARIANCE, Matrix

IRREGULAR = -1
RESTS, HEADS, CELL = 1, 2, 4
"""What a sample brought: rest, a heading, a number of cells."""


@compiled
def take(memory: Array) -> int:
    """Take the Imu that lies in the memory; write the Odometry, and say what the sample brought.

    `IRREGULAR` says that nothing has changed: the sample is one for the stream.
    """
    clock = ticks(memory, CLOCK)
    imu = _read(part(memory, IMU), clock[STAMP : STAMP + 1])
    stamp_ns, last_ns = clock[STAMP], clock[LAST]
    if stamp_ns == 0 or not 0 < stamp_ns - last_ns <= clock[LONGEST]:
        return IRREGULAR
    levelled = levelled_of(memory)
    regular, turned = _level(memory, imu, last_ns, levelled)
    if not regular:
        return IRREGULAR
    found = 0
    if clock[HEADED] != NOTHING:
        regular, found = find_headings(
            turned if clock[COUNTED] == AS_LEVELLED else imu,
            0,
            clock[HEADING],
            part(memory, HEADING_VARIANCE)[0],
            clock[HEADED] == REQUIRED,
            headings_of(memory),
        )
        if not regular:
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
    made = _wait(memory, clock, imu) if clock[COUNTED] != NOTHING else 0
    if found:
        clock[HEADING] = stamp_ns
    clock[LAST] = stamp_ns
    _write(part(memory, IMU), state, part(memory, ODOMETRY))
    rests = RESTS if state.stationary[0] else 0
    return CELL * made + HEADS * found + rests


def _read(message: Array, stamp_ns: Any) -> ImuColumns:
    """Read an Imu as `wire.decode_imu` does, in place; no stamp is 0."""
    seconds, nanoseconds = message.view(np.int32)[2], message.view(np.uint32)[3]
    whole = np.int64(nanoseconds) < NANOSECONDS
    stamp_ns[0] = np.int64(seconds) * NANOSECONDS + np.int64(nanoseconds) if whole else 0
    doubles = message[len(message) - IMU_DOUBLES :]
    if not doubles[4] >= 0.0 or not doubles[:4].any():
        doubles[:4] = 0.0
        doubles[4] = -1.0
    if not doubles[16] >= 0.0:
        doubles[13:16] = 0.0
        doubles[16] = -1.0
    return ImuColumns(
        stamp_ns,
        doubles[25:28].reshape((1, 3)),
        doubles[28:37].reshape((1, 9)),
        doubles[13:16].reshape((1, 3)),
        doubles[16:25].reshape((1, 9)),
        doubles[:4].reshape((1, 4)),
        doubles[4:13].reshape((1, 9)),
    )


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


def _write(imu: Array, state: StateColumns, odometry: Array) -> None:
    """Write an Odometry as `wire.odometry_encoder` does; head and frames are there already."""
    odometry[1] = imu[1]  # the stamp
    d = odometry[len(odometry) - ODOMETRY_DOUBLES :]
    attitude = quaternion(state.attitude, 0)
    a, b, c, d_, e, f, g, h, i = rot_wb = matrix_from_quaternion(attitude)
    put(d[:3], vector(state.position, 0))
    d[3], d[4], d[5], d[6] = attitude
    _put_blocks(
        d[7:43], matrix(state.position_covariance, 0), matrix(state.attitude_covariance, 0)
    )
    put(d[43:46], rotate_back(rot_wb, vector(state.velocity, 0)))
    velocity = rotate_covariance(
        (a, d_, g, b, e, h, c, f, i), matrix(state.velocity_covariance, 0)
    )
    put(d[46:49], vector(state.angular_velocity, 0))
    huge = UNMEASURED_VARIANCE
    rate = (huge, 0.0, 0.0, 0.0, huge, 0.0, 0.0, 0.0, huge)
    if measured(state.angular_velocity_covariance, 0):
        rate = matrix(state.angular_velocity_covariance, 0)
    _put_blocks(d[49:], velocity, rate)


def _put_blocks(out: Array, first: Matrix, second: Matrix) -> None:
    """Write two covariances, shape (3, 3), on the diagonal of one, shape (6, 6)."""
    for row in range(3):
        for column in range(3):
            out[6 * row + column] = first[3 * row + column]
            out[21 + 6 * row + column] = second[3 * row + column]
