"""Filter samples: strapdown, and what is known while the body rests; the loop of the navigator.

Derived in docs/navigation.md.  The whole state is one array and so are the rules, as each array
that a compiled function takes costs a tenth of a microsecond.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from dead_reckoning.core.kernels import compiled
from dead_reckoning.core.kernels.columns import (
    Array,
    ImuColumns,
    is_unknown,
    matrix,
    measured,
    put,
    triple,
    usable,
    vector,
)
from dead_reckoning.core.kernels.strapdown import (
    ATTITUDE,
    ERRORS,
    FLOOR,
    FORCE_BIAS,
    RATE_BIAS,
    VELOCITY,
    added,
    carry,
    cross,
    increments,
    integral,
    mirror,
    moved,
    spread,
    transpose,
)
from dead_reckoning.core.rotation import (
    composed,
    matrix_from_quaternion,
    quaternion_from_turn,
    rotate,
    unit,
)
from dead_reckoning.core.samples import NANOSECONDS, Quaternion, Vector

ROW = 8
"""Columns of a sample: step [s] since the one before, force (3), rate (3), variance of the rate.
A step below 0 stands for no sample: one that waits for its verdict is taken."""

(
    ACCELERATION_NOISE, SAMPLING_NOISE, RATE_NOISE, RATE_WALK, ACCELERATION_WALK, STANCE_VELOCITY,
    PIVOT, HEIGHT, CORRELATION, GATE, PATIENCE, STILL_WINDOW, STILL_DEVIATION, STILL_NOISE, SWAY,
    FLOOR_DEVIATION, FLOOR_GATE, FLOOR_SLOPE, MAX_GAP, GAP_SPEED, GAP_TURN, FORCE_RANGE,
    RATE_RANGE, GRAVITY, STILL_SAMPLES, DELAY,
) = range(26)  # fmt: skip
"""Elements of the rules; the settings of these names, and gravity [m/s²], the samples of the still
window, and the delay of the verdicts."""

RULES = 26

X_POSITION, X_VELOCITY, X_RATE_BIAS, X_FORCE_BIAS, X_FLOOR, X_ATTITUDE, X = 0, 3, 6, 9, 12, 13, 17
"""Elements of what is estimated."""

COVARIANCE = X
"""Begin of the covariance of the errors, shape (16, 16)."""

(
    FORCE, RATE, FORCE_BEFORE, RATE_BEFORE, STEP, SEEN, STOOD, FLOOR_KNOWN, REFUSED, HELD, HOLDS,
    HOLD, STANCE, NOISE, STILL_COUNT, SUMS, SQUARES, HEAD, WAITING, COUNTS, RINGS,
) = (
    273, 276, 279, 282, 285, 286, 287, 288, 289, 290, 291,
    292, 295, 297, 298, 299, 302, 303, 304, 305, 313,
)  # fmt: skip
"""More elements of the state: the last two samples and the step between them, and whether there
was one; whether the body stood, and on a known floor; time of velocities that were refused; time,
count and sum of the rates of a rest; where the last stance was; the least variance of the rate,
and what it is found from; the samples that wait for their verdict; counts; rings of rates and
samples."""

ZUPT, ZUPT_REFUSED, ZARU, ON_FLOOR, NEW_FLOOR, GAP, SATURATED = range(7)
"""What is counted."""

STATE_ROW = 52
"""Columns of a state: position, velocity, attitude (10); their covariances (27); rate and its
covariance (12); statistic, threshold, stationary."""

TRACE_ROW = 294
"""Columns of what the smoother needs of a sample: step, matrix before it, way, velocity (16); what
is estimated (17) and its covariance (256); rate and its variance (4); end of its log."""

LOG_ROW = 20
"""Columns of the log of updates: the error that was measured, and less which (−1: none), variance
and innovation, gain (16)."""

CLONE, FORGET = -1, -2
"""What the first column of the log may say instead: a new floor, a velocity forgotten in a gap."""


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
    rules: Array,
    state: Array,
    out: Array,
    trace: Array,
    log: Array,
) -> int:
    """Filter samples, shape (n, ROW), each once its verdict, shape (n, 3), is known.

    Returns how many rows of ``out``, shape (n, STATE_ROW), are filled.  ``trace``, shape
    (n, TRACE_ROW), and ``log``, shape (10 n, LOG_ROW), are for the smoother, or empty.
    """
    delay, still = int(rules[DELAY]), int(rules[STILL_SAMPLES])
    p = state[COVARIANCE : COVARIANCE + ERRORS * ERRORS].reshape((ERRORS, ERRORS))
    rates = state[RINGS : RINGS + 3 * still].reshape((still, 3))
    begin = RINGS + 3 * still
    line = state[begin : begin + ROW * (delay + 1)].reshape((delay + 1, ROW))
    dx, gain = np.zeros(ERRORS), np.zeros(ERRORS)
    done = logged = 0
    for k in range(len(samples)):
        head, waiting = int(state[HEAD]), int(state[WAITING])
        if samples[k, 0] >= 0.0:
            for i in range(ROW):
                line[(head + waiting) % (delay + 1), i] = samples[k, i]
            waiting += 1
            ready = waiting > delay
        else:
            ready = waiting > 0 and verdicts[k, 0] == verdicts[k, 0]  # not NaN
        if ready:
            row, traced = line[head], trace[done : done + 1]
            logged = _take(row, verdicts[k], rules, state, p, rates, dx, gain, traced, log, logged)
            w, noise = (row[4], row[5], row[6]), row[7]
            _put_state(out[done], state, p, w, noise)
            for i in range(3):
                out[done, STATE_ROW - 3 + i] = verdicts[k, i]
            if len(trace):
                _put_trace(traced[0], state, p, w, noise, logged)
            head, waiting, done = (head + 1) % (delay + 1), waiting - 1, done + 1
        state[HEAD], state[WAITING] = head, waiting
    return done


def _take(
    row: Array,
    verdict: Array,
    rules: Array,
    state: Array,
    p: Array,
    rates: Array,
    dx: Array,
    gain: Array,
    trace: Array,
    log: Array,
    logged: int,
) -> int:
    """Take one sample; return the end of the log."""
    dt, rests = row[0], verdict[2] > 0.0
    force, rate = (row[1], row[2], row[3]), (row[4], row[5], row[6])
    if state[SEEN] == 0.0:
        dt = 0.0
    elif dt > rules[MAX_GAP]:
        logged = _forget(dt, rules, state, p, log, logged)
        dt = 0.0
    elif dt > 0.0:
        _predict(dt, force, rate, rules, state, p, trace)
    if dt == 0.0 and len(trace):
        trace[0, :16] = 0.0
    for i in range(6):
        state[FORCE_BEFORE + i] = state[FORCE + i]
        state[FORCE + i] = row[1 + i]
    state[STEP], state[SEEN] = dt, 1.0
    still = _look(rate, rules, state, rates)
    if not (rests and dt > 0.0):
        state[HELD] = 0.0
        state[STOOD] = 1.0 if rests else 0.0
        return logged
    logged = _stand(dt, rate, verdict[0], rules, state, p, dx, gain, log, logged)
    if still:
        middle = (int(state[STILL_COUNT]) - len(rates) + len(rates) // 2) % len(rates)
        logged = _hold(dt, triple(rates[middle]), rules, state, p, dx, gain, log, logged)
    else:
        state[HELD] = 0.0
    _inject(state, dx)
    if rules[FLOOR_DEVIATION] > 0.0:
        logged = _floor(rules, state, p, dx, gain, log, logged)
    state[STANCE], state[STANCE + 1] = state[X_POSITION], state[X_POSITION + 1]
    state[STOOD] = 1.0
    return logged


def _attitude(state: Array) -> Quaternion:
    a = X_ATTITUDE
    return state[a], state[a + 1], state[a + 2], state[a + 3]


def _unbiased(state: Array, begin: int, bias: int) -> Vector:
    """Return three elements of the state less a bias."""
    return (
        state[begin] - state[bias],
        state[begin + 1] - state[bias + 1],
        state[begin + 2] - state[bias + 2],
    )


def _put(array: Array, begin: int, values: Vector) -> None:
    array[begin], array[begin + 1], array[begin + 2] = values


def _predict(
    dt: float, force: Vector, rate: Vector, rules: Array, state: Array, p: Array, trace: Array
) -> None:
    """Carry state and covariance to the next sample."""
    gravity = rules[GRAVITY]
    f1, f0 = _unbiased(state, FORCE, X_FORCE_BIAS), _unbiased(state, FORCE_BEFORE, X_FORCE_BIAS)
    w1, w0 = _unbiased(state, RATE, X_RATE_BIAS), _unbiased(state, RATE_BEFORE, X_RATE_BIAS)
    f2 = added(force, triple(state[X_FORCE_BIAS : X_FORCE_BIAS + 3]), -1.0)
    w2 = added(rate, triple(state[X_RATE_BIAS : X_RATE_BIAS + 3]), -1.0)
    turn = integral(dt, state[STEP], w2, w1, w0)
    push = integral(dt, state[STEP], f2, f1, f0)
    turn, push = increments(dt, turn, push, w1, w2, f1, f2)
    velocity = triple(state[X_VELOCITY : X_VELOCITY + 3])
    way, velocity, attitude, rot_ws = moved(dt, gravity, velocity, _attitude(state), turn, push)
    for i in range(3):
        state[X_POSITION + i] += way[i]
        state[X_VELOCITY + i] = velocity[i]
    for i in range(4):
        state[X_ATTITUDE + i] = attitude[i]
    carry(p, dt, gravity, rot_ws, way, velocity)
    transpose(p)
    carry(p, dt, gravity, rot_ws, way, velocity)
    x, y, z = added(f2, f1, -1.0)
    hidden = rules[SAMPLING_NOISE] * dt
    of_velocity = rules[ACCELERATION_NOISE] ** 2 * dt + hidden * hidden * (x * x + y * y + z * z)
    of_rate = rules[RATE_NOISE] ** 2 * dt
    if _reaches(force, rules[FORCE_RANGE]) or _reaches(rate, rules[RATE_RANGE]):
        state[COUNTS + SATURATED] += 1.0
    if _reaches(force, rules[FORCE_RANGE]):
        of_velocity += (rules[FORCE_RANGE] * dt) ** 2
    if _reaches(rate, rules[RATE_RANGE]):
        of_rate += (rules[RATE_RANGE] * dt) ** 2
    spread(p, velocity, of_velocity, of_rate)
    for i in range(3):
        p[RATE_BIAS + i, RATE_BIAS + i] += rules[RATE_WALK] ** 2 * dt
        p[FORCE_BIAS + i, FORCE_BIAS + i] += rules[ACCELERATION_WALK] ** 2 * dt
    mirror(p)
    if len(trace):
        trace[0, 0] = dt
        for i in range(9):
            trace[0, 1 + i] = rot_ws[i]
        _put(trace[0], 10, way)
        _put(trace[0], 13, velocity)


def _reaches(vector: Vector, full_scale: float) -> bool:
    """Say whether an axis reaches its full scale, where that is known."""
    x, y, z = vector
    return full_scale > 0.0 and max(abs(x), abs(y), abs(z)) >= 0.999 * full_scale


def _forget(dt: float, rules: Array, state: Array, p: Array, log: Array, logged: int) -> int:
    """Hold position and attitude over a gap, and forget the velocity."""
    state[COUNTS + GAP] += 1.0
    state[STILL_COUNT] = state[REFUSED] = 0.0
    for i in range(3):
        state[X_VELOCITY + i] = 0.0
        for j in range(ERRORS):
            p[VELOCITY + i, j] = p[j, VELOCITY + i] = 0.0
        p[VELOCITY + i, VELOCITY + i] = rules[GAP_SPEED] ** 2
        p[i, i] += (rules[GAP_SPEED] * dt) ** 2
        p[ATTITUDE + i, ATTITUDE + i] += (rules[GAP_TURN] * dt) ** 2
    if logged < len(log):
        log[logged, 0] = FORGET
    return logged + 1


def _look(rate: Vector, rules: Array, state: Array, rates: Array) -> bool:
    """Say whether the rate has been still, as still as the sensor was at its stillest."""
    n = len(rates)
    count = int(state[STILL_COUNT])
    slot = count % n
    for i in range(3):
        if count >= n:
            state[SUMS + i] -= rates[slot, i]
            state[SQUARES] -= rates[slot, i] ** 2
        rates[slot, i] = rate[i]
    if slot == 0:  # anew, so that no rounding gathers
        state[SQUARES] = 0.0
        for i in range(3):
            state[SUMS + i] = 0.0
            for j in range(1, min(count, n)):
                state[SUMS + i] += rates[j, i]
                state[SQUARES] += rates[j, i] ** 2
    for i in range(3):
        state[SUMS + i] += rate[i]
        state[SQUARES] += rate[i] ** 2
    state[STILL_COUNT] = count + 1
    if count + 1 < n:
        return False
    x, y, z = state[SUMS], state[SUMS + 1], state[SUMS + 2]
    variance = max(0.0, state[SQUARES] / n - (x * x + y * y + z * z) / (n * n)) / 3.0
    if state[NOISE] < 0.0:
        state[NOISE] = rules[STILL_NOISE] ** 2
    state[NOISE] = min(state[NOISE], variance)
    return bool(variance - state[NOISE] < rules[STILL_DEVIATION] ** 2)


def _stand(
    dt: float,
    rate: Vector,
    statistic: float,
    rules: Array,
    state: Array,
    p: Array,
    dx: Array,
    gain: Array,
    log: Array,
    logged: int,
) -> int:
    """Zero-velocity update: a standing foot turns about a point below it."""
    w = added(rate, triple(state[X_RATE_BIAS : X_RATE_BIAS + 3]), -1.0)
    x, y, _ = rotate(matrix_from_quaternion(_attitude(state)), w)
    v = X_VELOCITY  # ω × (0, 0, height) − v
    innovation = (
        rules[HEIGHT] * y - state[v],
        -rules[HEIGHT] * x - state[v + 1],
        -state[v + 2],
    )
    rolls = rules[PIVOT] * statistic
    variance = (rules[STANCE_VELOCITY] ** 2 + rolls * rolls) * rules[CORRELATION] / dt
    if _nis(p, variance, innovation) > rules[GATE] and state[REFUSED] <= rules[PATIENCE]:
        state[REFUSED] += dt
        state[COUNTS + ZUPT_REFUSED] += 1.0
        return logged
    for i in range(3):
        logged = _update(p, VELOCITY + i, -1, innovation[i], variance, dx, gain, log, logged)
    state[REFUSED] = 0.0
    state[COUNTS + ZUPT] += 1.0
    return logged


def _hold(
    dt: float,
    rate: Vector,
    rules: Array,
    state: Array,
    p: Array,
    dx: Array,
    gain: Array,
    log: Array,
    logged: int,
) -> int:
    """Zero-rate update, as the angle of a resting foot stays within the sway.

    ``rate`` is that of the middle of the still window.
    """
    if state[HELD] == 0.0:
        state[HOLDS] = 0.0
        _put(state, HOLD, (0.0, 0.0, 0.0))
    state[HELD] += dt
    state[HOLDS] += 1.0
    age = state[HELD] + rules[STILL_WINDOW]
    variance = (rules[SWAY] ** 2 / age + rules[RATE_NOISE] ** 2) / dt
    for i in range(3):
        state[HOLD + i] += rate[i]
        value = 0.5 * (rate[i] + state[HOLD + i] / state[HOLDS]) - state[X_RATE_BIAS + i]
        logged = _update(p, RATE_BIAS + i, -1, value, variance, dx, gain, log, logged)
    state[COUNTS + ZARU] += 1.0
    return logged


def _floor(
    rules: Array, state: Array, p: Array, dx: Array, gain: Array, log: Array, logged: int
) -> int:
    """Level the first sample of a stance with the floor, or begin a new one with it."""
    if state[STOOD] == 0.0 and state[FLOOR_KNOWN] > 0.0:
        rise = state[X_POSITION + 2] - state[X_FLOOR]
        x, y = state[X_POSITION] - state[STANCE], state[X_POSITION + 1] - state[STANCE + 1]
        if abs(rise) < rules[FLOOR_GATE] + rules[FLOOR_SLOPE] * sqrt(x * x + y * y):
            variance = rules[FLOOR_DEVIATION] ** 2
            logged = _update(p, 2, FLOOR, -rise, variance, dx, gain, log, logged)
            _inject(state, dx)
            state[COUNTS + ON_FLOOR] += 1.0
        else:
            state[FLOOR_KNOWN] = 0.0
            state[COUNTS + NEW_FLOOR] += 1.0
    if state[FLOOR_KNOWN] > 0.0:
        return logged
    state[FLOOR_KNOWN] = 1.0
    state[X_FLOOR] = state[X_POSITION + 2]
    for i in range(ERRORS):  # a clone: its error is that of the height
        p[FLOOR, i] = p[2, i]
    for i in range(ERRORS):
        p[i, FLOOR] = p[i, 2]
    if logged < len(log):
        log[logged, 0] = CLONE
    return logged + 1


def _nis(p: Array, variance: float, y: Vector) -> float:
    """Return yᵀ S⁻¹ y of the velocity, S = P_ξξ + variance · I."""
    x0, x1, x2 = y
    a, b, c = p[3, 3] + variance, p[3, 4], p[3, 5]
    d, e, f = p[4, 4] + variance, p[4, 5], p[5, 5] + variance
    u, v, w = d * f - e * e, c * e - b * f, b * e - c * d
    value = u * x0 * x0 + (a * f - c * c) * x1 * x1 + (a * d - b * b) * x2 * x2
    value += 2.0 * (v * x0 * x1 + w * x0 * x2 + (b * c - a * e) * x1 * x2)
    return float(value / (a * u + b * v + c * w))


def _update(
    p: Array,
    i: int,
    j: int,
    innovation: float,
    variance: float,
    dx: Array,
    gain: Array,
    log: Array,
    logged: int,
) -> int:
    """Measure error i, less error j unless that is −1; the corrections so far are in ``dx``."""
    for a in range(ERRORS):
        gain[a] = p[a, i] - (p[a, j] if j >= 0 else 0.0)
    total = gain[i] - (gain[j] if j >= 0 else 0.0) + variance
    innovation -= dx[i] - (dx[j] if j >= 0 else 0.0)
    inverse = 1.0 / total
    for a in range(ERRORS):
        share = gain[a] * inverse
        dx[a] += share * innovation
        for b in range(a, ERRORS):
            p[a, b] -= share * gain[b]
    mirror(p)
    if logged < len(log):
        log[logged, 0], log[logged, 1] = i, j
        log[logged, 2], log[logged, 3] = total, innovation
        for a in range(ERRORS):
            log[logged, 4 + a] = gain[a] * inverse
    return logged + 1


def _inject(state: Array, dx: Array) -> None:
    """Correct the state, and let the velocity turn with the attitude."""
    correct(state, dx)
    for i in range(ERRORS):
        dx[i] = 0.0


def correct(x: Array, dx: Array) -> None:
    """Add errors, shape (16,), to what is estimated, shape (≥ 17,)."""
    turn = triple(dx[ATTITUDE : ATTITUDE + 3])
    turned = cross(turn, triple(x[X_VELOCITY : X_VELOCITY + 3]))
    for i in range(3):
        x[X_POSITION + i] += dx[i]
        x[X_VELOCITY + i] += dx[VELOCITY + i] + turned[i]
        x[X_RATE_BIAS + i] += dx[RATE_BIAS + i]
        x[X_FORCE_BIAS + i] += dx[FORCE_BIAS + i]
    x[X_FLOOR] += dx[FLOOR]
    attitude = unit(composed(quaternion_from_turn(turn), _attitude(x)))
    for i in range(4):
        x[X_ATTITUDE + i] = attitude[i]


def _put_trace(
    trace: Array, state: Array, p: Array, rate: Vector, noise: float, logged: int
) -> None:
    for i in range(X):
        trace[16 + i] = state[i]
    for i in range(ERRORS):
        for j in range(ERRORS):
            trace[16 + X + ERRORS * i + j] = p[i, j]
    _put(trace, TRACE_ROW - 5, rate)
    trace[TRACE_ROW - 2], trace[TRACE_ROW - 1] = noise, logged


def _put_state(out: Array, x: Array, p: Array, rate: Vector, noise: float) -> None:
    """Write what is published; of the covariance the first twelve rows and columns count.

    δv = ξ − v × θ.
    """
    v = triple(x[X_VELOCITY : X_VELOCITY + 3])
    for i in range(3):
        out[i], out[3 + i] = x[X_POSITION + i], v[i]
        out[37 + i] = rate[i] - x[X_RATE_BIAS + i]
    for i in range(4):
        out[6 + i] = x[X_ATTITUDE + i]
    for i in range(3):
        a, b = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            out[10 + 3 * i + j] = p[i, j]
            out[28 + 3 * i + j] = p[ATTITUDE + i, ATTITUDE + j]
            out[40 + 3 * i + j] = p[RATE_BIAS + i, RATE_BIAS + j] + (noise if i == j else 0.0)
            c, d = (j + 1) % 3, (j + 2) % 3
            # Of δv_i with ξ_j and with the two parts of θ that turn v_j.
            with_v = p[3 + i, 3 + j] + p[6 + a, 3 + j] * v[b] - p[6 + b, 3 + j] * v[a]
            with_c = p[3 + i, 6 + c] + p[6 + a, 6 + c] * v[b] - p[6 + b, 6 + c] * v[a]
            with_d = p[3 + i, 6 + d] + p[6 + a, 6 + d] * v[b] - p[6 + b, 6 + d] * v[a]
            out[19 + 3 * i + j] = with_v + with_c * v[d] - with_d * v[c]
