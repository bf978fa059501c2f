"""Navigate by inertia: strapdown, corrected by what is known while the body rests."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from dead_reckoning.core.blocks import Array, Stamps, StateBlock
from dead_reckoning.core.checks import require_covariances, require_force, require_rate
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import (
    DeadReckoningError,
    GapError,
    GravityError,
    MissingRateError,
    NotAtRestError,
    NotLevelledError,
)
from dead_reckoning.core.kernels import navigator as kernel
from dead_reckoning.core.kernels.strapdown import (
    ATTITUDE,
    ERRORS,
    FLOOR,
    FORCE_BIAS,
    RATE_BIAS,
    VELOCITY,
)
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.rest import check_gravity, level_variances
from dead_reckoning.core.rest_search import RestSearch, Stillness
from dead_reckoning.core.rotation import euler_from_gravity, quaternion_from_euler
from dead_reckoning.core.samples import NANOSECONDS, UNKNOWN, ImuSample, NavigationState
from dead_reckoning.core.stamps import Timeline
from dead_reckoning.core.stationarity import STATIONARY, Watch, detector_class
from dead_reckoning.core.strides import Strides

KNOWN = 1e-10
"""Variance of what is zero by definition at the start: position and yaw [m², rad²]."""

AT_REST = 1e-4
"""Variance of the velocity at the start [m²/s²]."""

NO_TRACE = np.empty((0, kernel.TRACE_ROW))
NO_LOG = np.empty((0, kernel.LOG_ROW))

STRETCH = 1000
"""Samples that are filtered in one go, and so many at most between two states of the smoother."""

Recorder = Callable[[Array, Array, Stamps, Array, Array], None]
"""Takes samples, verdicts, stamps, rules, and the state before them: what the smoother needs."""

RULES = (
    'acceleration_noise', 'sampling_noise', 'rate_noise', 'rate_walk', 'acceleration_walk',
    'stance_velocity', 'pivot', 'height', 'correlation', 'gate', 'patience', 'still_window',
    'still_deviation', 'still_noise', 'sway', 'floor_deviation', 'floor_gate', 'floor_slope',
    'max_gap', 'gap_speed', 'force_range', 'rate_range',
)  # fmt: skip
"""Settings that the kernel takes as they are, under the same names."""

COUNTED = {
    'zero_velocity': kernel.ZUPT,
    'zero_velocity_refused': kernel.ZUPT_REFUSED,
    'zero_rate': kernel.ZARU,
    'floor': kernel.ON_FLOOR,
    'new_floor': kernel.NEW_FLOOR,
    'gap': kernel.GAP,
    'saturated': kernel.SATURATED,
}
"""What the filter counts, by name."""


class InertialNavigator:
    """Estimate position, velocity, attitude and the biases of gyro and accelerometer.

    An error-state Kalman filter around a strapdown of third order.  A detector of
    `core.stationarity` says when the body rests; then its velocity is known, the rate of turn too
    where it is still, and the height where the floor is level.  docs/navigation.md derives it and
    says what it reaches.

    It starts with a rest of `rest_duration`, which gives roll, pitch and the magnitude of gravity;
    yaw and position start at 0, and while the body moves it does not align.  What comes out is
    late by as many samples as the detector looks ahead, with the stamp of its own sample.

    A stale stamp is refused.  One that goes back by more than 1 s starts all over.  Over a gap
    position and attitude are held, the velocity is forgotten, and the covariance grows.  So it
    does with a sample that reaches the full scale of its sensor, where that is set.
    """

    def __init__(
        self,
        settings: NavigatorSettings,
        common: CommonSettings,
        of_detector: Settings | None = None,
    ) -> None:
        """Take the settings of the detector from its defaults where they are not given."""
        self.settings = settings
        self.findings: list[DeadReckoningError] = []
        """What turned out to be wrong, for whoever reports it and clears it."""
        self.record: Recorder | None = None
        """Gets all that the filter takes, before it does."""
        self._detector_class = detector_class(settings.detector)
        self._of_detector = of_detector or self._detector_class.Settings()
        self._gap_turn = common.turn_deviation
        self._rate_variance = common.rate_deviation**2
        self._timeline = Timeline()
        self._row = np.zeros((1, kernel.ROW))
        self._stamp = np.zeros(1, np.int64)
        self._verdict = np.zeros((1, 3))
        self._out = np.zeros((1, kernel.STATE_ROW))
        self._start_over()

    def reset(self) -> None:
        """Forget all and look for rest anew, as at the first sample."""
        self._timeline.reset()
        self._start_over()

    def _start_over(self) -> None:
        self.aligned = ''
        """What the alignment found, in words; empty before."""
        self.statistic = self.threshold = 0.0
        """Of the detector, at the last state."""
        self.stationary = False
        """Whether the body rests, at the last state."""
        self.strides = Strides()
        """From stance to stance, up to the last state."""
        self._look_for_rest()
        self._waiting: deque[int] = deque()
        self._state: Array = np.zeros(0)

    def _look_for_rest(self) -> None:
        self._search = RestSearch(self.settings, with_rate=True)
        self._collected: list[ImuSample] = []

    @property
    def restarts(self) -> int:
        """How often the stamps went back by more than 1 s."""
        return self._timeline.restarts

    @property
    def counts(self) -> dict[str, int]:
        """How often the filter did what; all zero before it is aligned."""
        first = kernel.COUNTS
        return {
            name: int(self._state[first + index]) if self.aligned else 0
            for name, index in COUNTED.items()
        }

    def update(self, imu: ImuSample) -> list[NavigationState]:
        """Take a sample; return the states that are known now, none or one, or more after a gap.

        Raises `SampleError` (not finite, no acceleration, no angular velocity, stale stamp, not
        aligned yet), and then what is estimated is as it was.
        """
        require_force(imu)
        require_covariances(imu)
        require_rate(imu)
        if imu.angular_velocity is None:
            raise MissingRateError(
                'the Imu measures no angular velocity, which the inertial navigator needs: take '
                'the topic of a device with a gyro'
            )
        restarts = self._timeline.restarts
        step_ns = self._timeline.advance(imu.stamp_ns)
        if self._timeline.restarts != restarts:
            self._start_over()
        dt = (step_ns or 0) / NANOSECONDS
        gap = dt > self.settings.max_gap
        if not self.aligned:
            if gap:
                self._look_for_rest()
            self._align(imu)
            return []
        states = []
        if gap:
            states = self.flush()
            self._detector.reset()
            self.findings.append(
                GapError(
                    f'no samples for {dt:.3g} s: the position is held and its uncertainty grows; '
                    'if the sensor is that slow, raise navigator.max_gap'
                )
            )
        row = self._row
        row[0] = (dt, *imu.specific_force, *imu.angular_velocity, self._variance(imu))
        self._waiting.append(imu.stamp_ns)
        self._stamp[0] = imu.stamp_ns
        if self._filter(row, self._stamp, self._verdict, self._out):
            states.append(self._state_of(self._out[0].tolist()))
        return states

    def flush(self) -> list[NavigationState]:
        """Return the states that wait for what the detector has not seen yet, as at the end."""
        count = len(self._waiting)
        if not count:
            return []
        delay = self._detector.delay
        rows = np.repeat(
            self._row, delay, axis=0
        )  # all that is known of what comes: like the last
        rows[:, 0] = -1.0
        out = np.empty((delay, kernel.STATE_ROW))
        done = self._filter(rows, np.zeros(delay, np.int64), np.empty((delay, 3)), out)
        return [self._state_of(values) for values in out[:done].tolist()]

    def take(self, samples: Array, stamps: Stamps) -> StateBlock | None:
        """Take samples in columns, as kernels have them; return the states known now, if any.

        ``samples``, shape (n, ROW), and ``stamps``, shape (n,), must be what `update` would take
        without an error, and without a gap.
        """
        out = np.empty((len(samples), kernel.STATE_ROW))
        done = 0
        for begin in range(0, len(samples), STRETCH):
            part = slice(begin, begin + STRETCH)
            rows = samples[part]
            done += self._filter(rows, stamps[part], np.empty((len(rows), 3)), out[done:])
        self._row[0] = samples[-1]
        waiting = np.concatenate((np.array(self._waiting, np.int64), stamps))
        self._waiting = deque(waiting[done:].tolist())
        if not done:
            return None
        block = state_block(waiting[:done], out[:done])
        self._note(out[done - 1].tolist())
        count_strides(self.strides, block)
        return block

    def _filter(self, samples: Array, stamps: Stamps, verdicts: Array, out: Array) -> int:
        self._detector.take(samples, verdicts)
        if self.record is not None:
            self.record(samples, verdicts, stamps, self._rules, self._state)
        return kernel.navigate(samples, verdicts, self._rules, self._state, out, NO_TRACE, NO_LOG)

    def _note(self, values: list[float]) -> None:
        self.statistic, self.threshold = values[49], values[50]
        self.stationary = values[51] > 0.0

    def _state_of(self, values: list[float]) -> NavigationState:
        self._note(values)
        px, py, pz, vx, vy, vz, qx, qy, qz, qw, *rest = values
        position = (px, py, pz)
        self.strides.update(self.stationary, position)
        fields: Any = rest
        return NavigationState(
            self._waiting.popleft(),
            position,
            (vx, vy, vz),
            (qx, qy, qz, qw),
            tuple(fields[0:9]),
            tuple(fields[9:18]),
            tuple(fields[18:27]),
            tuple(fields[27:30]),
            tuple(fields[30:39]),
            self.stationary,
        )

    def _variance(self, imu: ImuSample) -> float:
        covariance = imu.angular_velocity_covariance
        if covariance == UNKNOWN:
            return self._rate_variance
        return (covariance[0] + covariance[4] + covariance[8]) / 3.0

    def _align(self, imu: ImuSample) -> None:
        """Look for rest; once it is found filter what was collected of it."""
        collected = self._collected
        collected.append(imu)
        try:
            still = self._search.add(imu)
            if still is None:
                raise NotLevelledError(
                    'waiting for rest: the tilt is taken from gravity, so keep the device still '
                    f'for {self.settings.rest_duration:g} s'
                )
            gravity = check_gravity(still.force.mean)
        except (NotAtRestError, GravityError) as error:
            collected.clear()  # the window is empty again, and the search goes on
            if isinstance(error, GravityError):
                self.findings.append(error)
            raise NotLevelledError(f'waiting for rest: {error}') from error
        stamps = np.array([sample.stamp_ns for sample in collected])
        rows = np.array(
            [
                (0.0, *s.specific_force, *(s.angular_velocity or ()), self._variance(s))
                for s in collected
            ]
        )
        rows[1:, 0] = np.diff(stamps) / NANOSECONDS
        self._start(
            still, gravity, (len(stamps) - 1) * NANOSECONDS / float(stamps[-1] - stamps[0])
        )
        self._collected = []
        self.take(rows, stamps)

    def _start(self, still: Stillness, gravity: float, rate: float) -> None:
        """Build detector and filter for a rest, and for so many samples a second [Hz]."""
        settings = self.settings
        half = max(1, round(0.5 * settings.window * rate - 0.01))
        total = int(settings.look_ahead * rate + 1e-6)
        ahead = min(half, total)
        watch = Watch(
            2 * half - ahead,
            ahead,
            max(1, min(round(settings.minimum * rate), total - ahead + 1)),
            settings.hysteresis,
            round(settings.memory * rate),
            settings.exponent,
            gravity,
        )
        self._detector = self._detector_class(self._of_detector, watch)
        samples = max(4, round(settings.still_window * rate))
        self._rules = self._rules_of(gravity, samples)
        rings = 3 * samples + kernel.ROW * (self._detector.delay + 1)
        state = self._state = np.zeros(kernel.RINGS + rings)
        roll, pitch = euler_from_gravity(still.force.mean)
        begin = kernel.X_ATTITUDE
        state[begin : begin + 4] = quaternion_from_euler(roll, pitch, 0.0)
        state[kernel.NOISE] = -1.0  # no rest yet
        variances = np.full(ERRORS, KNOWN)
        variances[VELOCITY : VELOCITY + 3] = AT_REST
        # At rest a bias of the accelerometer shows as a tilt, so the prior of both is the same.
        tilt = (settings.acceleration_bias / gravity) ** 2 + level_variances(still.force)[1]
        variances[ATTITUDE : ATTITUDE + 2] = tilt
        variances[RATE_BIAS : RATE_BIAS + 3] = settings.rate_bias**2
        variances[FORCE_BIAS : FORCE_BIAS + 3] = settings.acceleration_bias**2
        variances[FLOOR] = KNOWN
        covariance = np.diag(variances).ravel()
        state[kernel.COVARIANCE : kernel.COVARIANCE + len(covariance)] = covariance
        self.aligned = (
            f'gravity is {gravity:.4f} m/s², roll {np.degrees(roll):.3f}°, '
            f'pitch {np.degrees(pitch):.3f}°, {rate:.1f} samples a second'
        )

    def _rules_of(self, gravity: float, still_samples: int) -> Array:
        """Return what the kernel goes by: settings of the same names, and what follows."""
        settings = self.settings
        rules = np.zeros(kernel.RULES)
        for name in RULES:
            rules[getattr(kernel, name.upper())] = getattr(settings, name)
        if not settings.floor:
            rules[kernel.FLOOR_DEVIATION] = 0.0
        if settings.acceleration_bias == 0.0:
            rules[kernel.ACCELERATION_WALK] = 0.0
        rules[kernel.GAP_TURN] = self._gap_turn
        rules[kernel.GRAVITY] = gravity
        rules[kernel.STILL_SAMPLES] = still_samples
        rules[kernel.DELAY] = self._detector.delay
        return rules


def state_block(stamps: Stamps, rows: Array) -> StateBlock:
    """Return rows of the kernel, shape (n, STATE_ROW), as a block."""
    ends = (0, 3, 6, 10, 19, 28, 37, 40, 49)
    columns: list[Any] = [rows[:, a:b] for a, b in pairwise(ends)]
    columns.append(rows[:, 49 + STATIONARY] > 0.0)
    return StateBlock(stamps, *columns)


def count_strides(strides: Strides, block: StateBlock) -> None:
    """Count the strides of a block; what is between two changes does not matter."""
    changes = np.flatnonzero(np.diff(block.stationary))
    matter = {0, len(block) - 1, *changes.tolist(), *(changes + 1).tolist()}
    for i in sorted(matter):
        x, y, z = block.position[i].tolist()
        strides.update(bool(block.stationary[i]), (x, y, z))
