"""Filter samples: the loop of the inertial navigator."""

from __future__ import annotations

import numpy as np

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import (
    Array,
    ImuColumns,
    is_unknown,
    matrix,
    measured,
    put,
    usable,
    vector,
)
from dead_reckoning.core.kernels.navigation.aiding import bound_velocity, roll_along, take_aid
from dead_reckoning.core.kernels.navigation.layout import (
    ATTITUDE,
    AVERAGING,
    COVARIANCE,
    DELAY,
    ERRORS,
    FLOOR_DEVIATION,
    FORCE,
    FORCE_BEFORE,
    GRAVITY_DIRECTION,
    HEAD,
    HELD,
    LOGGED,
    MAX_GAP,
    MOVES,
    NONHOLONOMIC,
    RATE_BIAS,
    RINGS,
    ROW,
    SEEN,
    STANCE,
    STATE_ROW,
    STEP,
    STILL_SAMPLES,
    STOOD,
    TRACE_ROW,
    VELOCITY,
    WAITING,
    X_ATTITUDE,
    X_POSITION,
    X_RATE_BIAS,
    X_VELOCITY,
    ZERO_RATE,
    ZERO_VELOCITY,
    Filter,
    X,
)
from dead_reckoning.core.kernels.navigation.measurement import inject
from dead_reckoning.core.kernels.navigation.predict import predict, skip
from dead_reckoning.core.kernels.navigation.rest import (
    is_still,
    level_floor,
    zero_rate,
    zero_velocity,
)
from dead_reckoning.core.rotation import composed, quaternion_from_turn
from dead_reckoning.core.samples import NANOSECONDS, Vector

BEYOND = 1e12
"""Magnitude [SI] at which nothing is; its powers stay finite."""

ROUNDING = 1e-12
"""By how much a variance may be below 0."""


@compiled
def regular(
    imu: ImuColumns, begin: int, last_ns: int, max_gap: float, variance: float, rows: Array
) -> int:
    """Write what the filter takes from a row on; return how many are regular.

    ``variance`` [rad²/s²] is that of a rate without a covariance.
    """
    for i in range(begin, len(imu.stamp_ns)):
        dt = (imu.stamp_ns[i] - last_ns) / NANOSECONDS
        if not (
            imu.stamp_ns[i] > last_ns
            and dt <= max_gap
            and measured(imu.force_covariance, i)
            and measured(imu.rate_covariance, i)
            and usable(imu, i)
        ):
            return i - begin
        last_ns = imu.stamp_ns[i]
        row = rows[i - begin]
        row[0] = dt
        put(row[1:4], vector(imu.force, i))
        put(row[4:7], vector(imu.rate, i))
        known = matrix(imu.rate_covariance, i)
        row[7] = variance if is_unknown(known) else (known[0] + known[4] + known[8]) / 3.0
    return len(imu.stamp_ns) - begin


@compiled
def navigate(
    samples: Array,
    verdicts: Array,
    aids: Array,
    rules: Array,
    state: Array,
    out: Array,
    trace: Array,
    log: Array,
) -> int:
    """Filter samples, shape (n, ROW), each once its verdict, shape (n, 3), is known.

    ``aids``, shape (m, AID_ROW), are what else is known, in the order of their rows.  Returns how
    many rows of ``out``, shape (n, STATE_ROW), are filled, or, as −1 − rows, that it stopped
    after these, as what came then is no state.  ``trace``, shape (n, TRACE_ROW), and
    ``log``, shape (18 n + 6 m, LOG_ROW), are for the smoother, or empty.
    """
    delay, still = int(rules[DELAY]), int(rules[STILL_SAMPLES])
    begin = RINGS + 3 * still
    f = Filter(
        rules,
        state,
        state[COVARIANCE : COVARIANCE + ERRORS * ERRORS].reshape((ERRORS, ERRORS)),
        state[RINGS:begin].reshape((still, 3)),
        state[begin : begin + ROW * (delay + 1)].reshape((delay + 1, ROW)),
        np.zeros(ERRORS),
        np.zeros(ERRORS),
        np.zeros(ERRORS),
        log,
    )
    line = f.line
    state[LOGGED] = 0.0
    done = aided = 0
    for k in range(len(samples)):
        head, waiting = int(state[HEAD]), int(state[WAITING])
        if samples[k, 0] >= 0.0:
            for i in range(ROW):
                line[(head + waiting) % (delay + 1), i] = samples[k, i]
            waiting += 1
            ready = waiting > delay
        else:
            ready = waiting > 0 and verdicts[k, 0] == verdicts[k, 0]  # not NaN
        last = aided
        while last < len(aids) and aids[last, 0] <= k:
            last += 1
        if ready:
            row, traced = line[head], trace[done : done + 1]
            _take(row, verdicts[k], aids[aided:last], f, traced)
            if _diverged(state, f.p):
                state[X_POSITION] = np.nan  # for good
                return -1 - done
            w, noise = (row[4], row[5], row[6]), row[7]
            put_state(out[done], state, f.p, w, noise, 0.5 * rules[AVERAGING] * state[STEP])
            for i in range(3):
                out[done, STATE_ROW - 3 + i] = verdicts[k, i]
            if state[STOOD] == 0.0:
                out[done, STATE_ROW - 1] = 0.0  # something else saw that it moves
            if len(trace):
                _put_trace(traced[0], f, w, noise)
            head, waiting, done = (head + 1) % (delay + 1), waiting - 1, done + 1
        aided = last
        state[HEAD], state[WAITING] = head, waiting
    return done


def _take(row: Array, verdict: Array, aids: Array, f: Filter, trace: Array) -> None:
    """Take one sample and what is known of it."""
    rules, state = f.rules, f.state
    dt, rests = row[0], verdict[2] > 0.0 and state[MOVES] == 0.0
    state[MOVES] = max(0.0, state[MOVES] - dt)
    force, rate = (row[1], row[2], row[3]), (row[4], row[5], row[6])
    if state[SEEN] == 0.0:
        dt = 0.0
    elif dt > rules[MAX_GAP]:
        skip(dt, f)
        dt = 0.0
    elif dt > 0.0:
        predict(dt, force, rate, f, trace)
    if dt == 0.0 and len(trace):
        trace[0, :16] = 0.0
    for i in range(6):
        state[FORCE_BEFORE + i] = state[FORCE + i]
        state[FORCE + i] = row[1 + i]
    state[STEP], state[SEEN] = dt, 1.0
    still = is_still(rate, f)
    if dt > 0.0:
        _update(dt, rate, verdict[0], rests, still, f)
    else:
        state[HELD] = 0.0
        state[STOOD] = 1.0 if rests else 0.0
    for aid in aids:
        take_aid(aid, rate, f)


def _update(
    dt: float, rate: Vector, statistic: float, rests: bool, still: bool, f: Filter
) -> None:
    """Take what is known of the motion."""
    rules, state = f.rules, f.state
    if rests:
        believed = True
        if rules[ZERO_VELOCITY] > 0.0:
            believed = zero_velocity(dt, rate, statistic, f)
        if still and believed and rules[ZERO_RATE] > 0.0:
            zero_rate(dt, f)
        else:
            state[HELD] = 0.0
        inject(f)
        if rules[FLOOR_DEVIATION] > 0.0:
            level_floor(f)
        state[STANCE], state[STANCE + 1] = state[X_POSITION], state[X_POSITION + 1]
    else:
        state[HELD] = 0.0
    state[STOOD] = 1.0 if rests else 0.0
    if rules[GRAVITY_DIRECTION] > 0.0:
        bound_velocity(dt, f)
    if rules[NONHOLONOMIC] > 0.0:
        roll_along(dt, rate, f)


def _diverged(state: Array, p: Array) -> bool:
    """Say whether this is no state, or no covariance.

    What is not finite anywhere in P is so on its diagonal after the next step, before that of a
    sample is looked at.
    """
    wrong = 0
    for i in range(X):
        if not abs(state[i]) < BEYOND:  # nor is NaN
            wrong += 1
    for a in range(ERRORS):
        if not -ROUNDING < p[a, a] < BEYOND * BEYOND:
            wrong += 1
    a = X_ATTITUDE
    turn = state[a] ** 2 + state[a + 1] ** 2 + state[a + 2] ** 2 + state[a + 3] ** 2
    return wrong > 0 or turn < 0.5


def _put_trace(trace: Array, f: Filter, rate: Vector, noise: float) -> None:
    for i in range(X):
        trace[16 + i] = f.state[i]
    for i in range(ERRORS):
        for j in range(ERRORS):
            trace[16 + X + ERRORS * i + j] = f.p[i, j]
    put(trace[TRACE_ROW - 5 : TRACE_ROW - 2], rate)
    trace[TRACE_ROW - 2], trace[TRACE_ROW - 1] = noise, f.state[LOGGED]


def put_state(out: Array, x: Array, p: Array, rate: Vector, noise: float, age: float) -> None:
    """Write what is published; of the covariance the first twelve rows and columns count.

    That of ξ is that of a twist, whose error is R̂ᵀ ξ.  ``age`` [s] is by how much a sample, as a
    mean, is older than its stamp, to which the attitude turns on; velocity and position stay.
    """
    for i in range(3):
        out[i], out[3 + i] = x[X_POSITION + i], x[X_VELOCITY + i]
        out[37 + i] = rate[i] - x[X_RATE_BIAS + i]
    turn = (age * out[37], age * out[38], age * out[39])
    a = X_ATTITUDE
    attitude = composed((x[a], x[a + 1], x[a + 2], x[a + 3]), quaternion_from_turn(turn))
    for i in range(4):
        out[6 + i] = attitude[i]
    for i in range(3):
        for j in range(3):
            out[10 + 3 * i + j] = p[i, j]
            out[19 + 3 * i + j] = p[VELOCITY + i, VELOCITY + j]
            out[28 + 3 * i + j] = p[ATTITUDE + i, ATTITUDE + j]
            out[40 + 3 * i + j] = p[RATE_BIAS + i, RATE_BIAS + j] + (noise if i == j else 0.0)
            out[49 + 3 * i + j] = p[i, ATTITUDE + j]
            out[58 + 3 * i + j] = -p[VELOCITY + i, RATE_BIAS + j]  # the rate is without its bias
