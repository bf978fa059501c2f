"""Where things are in the arrays of the navigator's kernels.

The whole state is one array and so are the rules, as each array that a compiled function takes
costs a tenth of a microsecond.
"""

from __future__ import annotations

from typing import NamedTuple

from dead_reckoning.core.kernels.columns import Array

POSITION, VELOCITY, ATTITUDE, RATE_BIAS, FORCE_BIAS, FLOOR, ERRORS = 0, 3, 6, 9, 12, 15, 16
"""Where each error begins, and how many there are."""

ROW = 8
"""Columns of a sample: step [s] since the one before, force (3), rate (3), variance of the rate.
A step below 0 stands for no sample: one that waits for its verdict is taken."""

AID_ROW = 25
"""Columns of what else is known of a sample: row with which that sample is filtered, time after
the sample [s], 0 or less, kind, values.  So they are taken in lexicographic order."""

YAW, NORTH, LEVEL, PLACE, VECTOR = range(5)
"""Kinds of these, and their values.  Yaw [rad], its variance, times [s] since the one before, for
which its error lasts, and for which it may be refused, who measures it; the first yaw there is,
and its variance; mean force and rate of a rest (6), their variances; a vector that is measured:
what it is, who measures it, time [s] since the one before, values (3), covariance (its upper half,
6), arm (3); a pose that is set: position (3) and covariance (6), attitude (4) and covariance (6),
arm (3).
"""

BODY_VELOCITY, WORLD_VELOCITY, WORLD_POSITION = range(3)
"""What a vector can be, of a point of the body at an arm [m] from the sensor: its velocity along
the axes of the body [m/s], or of the world; its position [m]."""

BY_COMPASS, BY_TWIST, BY_ODOM, BY_POSE, BY_POSE_YAW, WITNESSES = range(6)
"""Who measures yaws and vectors, and how many there are."""

(
    ACCELERATION_NOISE, SAMPLING_NOISE, RATE_NOISE, RATE_WALK, ACCELERATION_WALK, ZERO_VELOCITY,
    STANCE_VELOCITY, PIVOT, HEIGHT, CORRELATION, GATE, PATIENCE, ZERO_RATE, STILL_WINDOW,
    STILL_DEVIATION, STILL_NOISE, SWAY, FLOOR_DEVIATION, FLOOR_GATE, FLOOR_SLOPE, MAX_GAP,
    GAP_SPEED, GAP_TURN, FORCE_RANGE, RATE_RANGE, AXIS_GATE, GRAVITY_DIRECTION, HELD_VELOCITY,
    HELD_TIME, NONHOLONOMIC, SLIP, SLIP_ANGLE, SLIP_TIME, AVERAGING, RATE_SCALE, AIDING_GATE,
    AIDING_PATIENCE, AIDING_CORRELATION, AXLE, MOUNTED, GRAVITY, STILL_SAMPLES, DELAY, RULES,
) = (*range(39), 41, 50, 51, 52, 53)  # fmt: skip
"""Elements of the rules: settings of these names (the axle has three), rotation of the sensor on
the body (9), gravity [m/s²], samples of
the still window, delay of the verdicts; and how many."""

X_POSITION, X_VELOCITY, X_RATE_BIAS, X_FORCE_BIAS, X_FLOOR, X_ATTITUDE, X = 0, 3, 6, 9, 12, 13, 17
"""Elements of what is estimated."""

COVARIANCE = X
"""Begin of the covariance of the errors, shape (16, 16)."""

FORCE = COVARIANCE + ERRORS * ERRORS
RATE = FORCE + 3
FORCE_BEFORE = RATE + 3
RATE_BEFORE = FORCE_BEFORE + 3
"""The last two samples, and"""
STEP = RATE_BEFORE + 3
SEEN = STEP + 1
"""the step between them, and whether there was one."""
STOOD = SEEN + 1
FLOOR_KNOWN = STOOD + 1
STANCE = FLOOR_KNOWN + 1
"""Whether the body stood, and on a known floor; where its last stance was (2)."""
REFUSED = STANCE + 2
RATE_REFUSED = REFUSED + 1
BOUND_REFUSED = RATE_REFUSED + 1
ROLL_REFUSED = BOUND_REFUSED + 1
AID_REFUSED = ROLL_REFUSED + 1
"""Time [s] for which velocity and rate of rests were refused; bound, wheels; each witness."""
MOVES = AID_REFUSED + WITNESSES
"""Time [s] for which it still moves, as a velocity said that was measured."""
HELD = MOVES + 1
HOLDS = HELD + 1
HOLD = HOLDS + 1
"""Time, count and sum (3) of the rates of a rest."""
NOISE = HOLD + 3
STILL_COUNT = NOISE + 1
SUMS = STILL_COUNT + 1
SQUARES = SUMS + 3
"""The least variance of the rate, and what it is found from."""
HEAD = SQUARES + 1
WAITING = HEAD + 1
"""First and number of the samples that wait for their verdict."""
LOGGED = WAITING + 1
"""End of the log."""
COUNTS = LOGGED + 1

(
    ZUPT, ZUPT_REFUSED, ZARU, ZARU_REFUSED, ON_FLOOR, NEW_FLOOR, BOUNDED, BOUNDED_REFUSED, ROLLING,
    ROLLING_REFUSED, GAP, SATURATED, PLACED, AIDED, COUNTED,
) = (*range(14), 14 + 2 * WITNESSES)  # fmt: skip
"""What is counted, and how many counts there are; of what is measured elsewhere, how much is taken
and how much refused, by who measures it."""

RINGS = COUNTS + COUNTED
"""Begin of the rings: rates of the still window, samples that wait."""

STATE_ROW = 70
"""Columns of a state: position, velocity, attitude (10); their covariances (27); rate and its
covariance (12); covariances of position and attitude, and of velocity and rate (18); statistic,
threshold, stationary."""


def state_columns(rows: Array) -> tuple[Array, ...]:
    """Return position, velocity, attitude, their covariances, rate and its covariance of states.

    Columns, shapes (n, 3), (n, 3), (n, 4), (n, 9) three times, (n, 3) and (n, 9); and (n, 9) twice
    of position with attitude, of velocity with rate.
    """
    return (
        rows[:, 0:3], rows[:, 3:6], rows[:, 6:10], rows[:, 10:19], rows[:, 19:28],
        rows[:, 28:37], rows[:, 37:40], rows[:, 40:49], rows[:, 49:58], rows[:, 58:67],
    )  # fmt: skip


TRACE_ROW = 294
"""Columns of what the smoother needs of a sample: step, matrix before it, way, velocity (16); what
is estimated (17) and its covariance (256); rate and its variance (4); end of its log."""

LOG_ROW = 3 + 2 * ERRORS
"""Columns of the log: what was done; variance and innovation, gain (16), and of which errors (16).
"""

MEASURE, CLONE, FORGET, TURN, FOLLOW = range(5)
"""What the log says was done: a measurement; a new floor; errors forgotten; the world turned, by a
rotation vector in place of the variance and what follows; the error of the velocity alone."""


class Filter(NamedTuple):
    """All that an update works on.

    ``p``, shape (16, 16), ``rates`` and ``line`` are views of the state.  ``h``, shape (16,), says
    of which errors the next measurement is; ``dx`` are the corrections so far, ``gain`` is room.
    """

    rules: Array
    state: Array
    p: Array
    rates: Array
    line: Array
    h: Array
    dx: Array
    gain: Array
    log: Array
