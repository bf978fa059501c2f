"""Navigate by inertia: strapdown, corrected by what is known of the motion."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence
from concurrent.futures import Future

import numpy as np

from dead_reckoning.core.blocks import Array, Stamps, StateBlock
from dead_reckoning.core.checks import require_covariances, require_force, require_rate
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.compass_yaw import CompassYaw
from dead_reckoning.core.errors import (
    AidingError,
    DeadReckoningError,
    DivergedError,
    GapError,
    GravityError,
    MissingRateError,
    NotAtRestError,
    NotLevelledError,
    StaleCompassError,
    SupersededError,
)
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.kernels.navigation.filter import navigate
from dead_reckoning.core.navigation.aids import NO_AIDS, Aids
from dead_reckoning.core.navigation.alignment import (
    KNOWN,
    Alignment,
    Rest,
    first_state,
    level_at,
    rules_of,
)
from dead_reckoning.core.navigation.detection import detector_of
from dead_reckoning.core.navigation.history import NO_LOG, NO_TRACE, STRETCH, History
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigation.states import counts_of, state_block, state_of
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.rest_search import Stillness
from dead_reckoning.core.rotation import matrix_from_quaternion
from dead_reckoning.core.samples import (
    IDENTITY,
    NANOSECONDS,
    UNKNOWN,
    ImuSample,
    NavigationState,
    Quaternion,
    Vector,
)
from dead_reckoning.core.stamps import Timeline
from dead_reckoning.core.strides import Strides, count_strides
from dead_reckoning.core.work import Work

NO_STAMPS = np.empty(0, np.int64)

AHEAD = 1.0
"""A measurement that is ahead of the samples by more time [s], and `aiding_delay`, has another
clock."""


class InertialNavigator:
    """Estimate position, velocity, attitude and the biases of gyro and accelerometer.

    An error-state Kalman filter around a strapdown of third order.  Detectors of
    `core.stationarity` say when the body rests; then its velocity is known, the rate of turn too
    where it is still, and the height where the floor is level.  A compass may tell the yaw; a held
    body has a bounded velocity, and wheels roll along.  docs/navigation.md derives it and says
    what it reaches.

    It starts with a rest of `rest_duration`, which gives roll, pitch and the magnitude of gravity;
    the yaw is that of the compass, or 0, the position 0, and while the body moves it does not
    align.  What comes out is late by as many samples as the detector looks ahead, with the stamp
    of its own sample.

    A stale stamp is refused.  One that goes back by more than 1 s starts all over, and so does a
    state that is not finite, which never comes out.  Over a gap
    position and attitude are held, the velocity is forgotten, and the covariance grows.  So it
    does with a sample that reaches the full scale of its sensor, where that is set.
    """

    def __init__(
        self, settings: NavigatorSettings, common: CommonSettings, *of_detectors: Settings
    ) -> None:
        """Take the settings of each detector, in order, from its defaults if none are given."""
        self.settings = settings
        self.findings: list[DeadReckoningError] = []
        """What turned out to be wrong, for whoever reports it and clears it."""
        self.dropped: Counter[str] = Counter()
        """How much of what aids could not be used, by its topic."""
        self.history: History | None = None
        """Keeps what the filter takes, where somebody needs it."""
        self._of_detectors = of_detectors
        self._gap_turn = common.turn_deviation
        self._rate_variance = common.rate_deviation**2
        self._timeline = Timeline()
        self._compass = CompassYaw(
            settings.compass_timeout, common.turn_deviation, common.attitude_deviation
        )
        self._levelling = Work()
        self._mounted = IDENTITY
        self.row = np.zeros((1, layout.ROW))
        """The last sample, as the filter takes it."""
        self.out = np.zeros((1, layout.STATE_ROW))
        """A state, as the filter gives it."""
        self._values: list[float] = []
        self._stamp = np.zeros(1, np.int64)
        self._verdict = np.zeros((1, 3))
        self._start_over()

    def reset(self) -> None:
        """Forget all and look for rest anew, as at the first sample."""
        self._timeline.reset()
        self._compass.reset()
        self._start_over()
        self._levelling.fail(SupersededError('a reset came meanwhile: ask again'))

    def _start_over(self) -> None:
        self.aligned = ''
        """What the last alignment found, in words; empty before the first."""
        self.statistic = self.threshold = 0.0
        """Of the detector, at the last state."""
        self.stationary = False
        """Whether the body rests, at the last state."""
        self.strides = Strides()
        """From stance to stance, up to the last state."""
        self._alignment = Alignment(self.settings)
        self._search: Alignment | None = None
        self._aids = Aids()
        self._to_north = False  # whether the yaw is one of a compass
        self._heard = self._silent = False  # a compass, ever, and lately
        self._waiting: deque[int] = deque()
        self._begin_ns = 0  # of the first sample that gets a state: those before were refused
        if self.history is not None:
            self.history.newer()  # of the way before
        self._own_state: Array = np.zeros(0)
        self._rules: Array = np.zeros(0)

    def mount(self, rotation: Quaternion) -> None:
        """Learn what takes the axes of the sensor into those in which its samples come."""
        self._mounted = matrix_from_quaternion(rotation)
        if self.aligned:
            self._rules = self._rules_with(self._rules[layout.GRAVITY])

    @property
    def _state(self) -> Array:
        """The state of the filter, with all that came late."""
        newer = self.history.newer() if self.history is not None else None
        if newer is not None:
            self._own_state[:] = newer
        return self._own_state

    @property
    def newest_ns(self) -> int:
        """Stamp of the last sample [ns]; 0 before the first."""
        return self._timeline.last_ns or 0

    @property
    def restarts(self) -> int:
        """How often the stamps went back by more than 1 s."""
        return self._timeline.restarts

    @property
    def levelling(self) -> bool:
        """Whether it looks for a rest to level at, sample by sample."""
        return self._search is not None

    @property
    def counts(self) -> dict[str, int]:
        """How often the filter did what; all zero before it is aligned."""
        return counts_of(self._state)

    @property
    def biases(self) -> tuple[list[float], list[float]]:
        """Biases of gyro [rad/s] and accelerometer [m/s²], in their axes; empty if not aligned."""
        of_rate, of_force = layout.X_RATE_BIAS, layout.X_FORCE_BIAS
        state = self._state.tolist() if self.aligned else []
        return state[of_rate : of_rate + 3], state[of_force : of_force + 3]

    def configure(self, settings: NavigatorSettings) -> None:
        """Take over what may change, all at once, between two samples."""
        mutable = {p.key: getattr(settings, p.name) for p in settings.parameters() if p.mutable}
        self.settings = self.settings.changed(mutable)
        if not self.settings.compass and self._aids.drop_compass():
            self._to_north = False
        if self.aligned:
            self._rules = self._rules_with(self._rules[layout.GRAVITY])

    def level(self) -> Future[str]:
        """Align again, at the rest that the coming samples show; position and yaw stay.

        The future ends with a sentence for the user, or with `NotAtRestError` or `GravityError`,
        and then nothing changed.
        """
        if self.aligned:
            self._search = Alignment(self.settings)
        else:
            self._alignment.clear()
        return self._levelling.begin()

    def follow_compass(self, compass: ImuSample) -> None:
        """Take a message of a compass, an Imu with an orientation, of which the yaw counts.

        Raises `SampleError` (no orientation, not finite, stale stamp), and then nothing changed.
        """
        self._compass.take(compass)
        self._heard = True
        found = self._compass.at(compass.stamp_ns)
        if found is None or not self.aligned or not self.settings.compass:
            return
        yaw, variance = found
        interval = self._compass.interval
        if self._to_north and interval is not None:
            lasts = self.settings.compass_correlation
            told = (yaw, variance, interval, lasts, lasts, layout.BY_COMPASS)
            self._aids.add(compass.stamp_ns, layout.YAW, told)
        else:
            self._to_north = True
            self._aids.add(compass.stamp_ns, layout.NORTH, (yaw, variance))

    def keep(self) -> History:
        """Keep what the filter takes from now on; return where."""
        if self.history is None:
            self.history = History(self.settings.aiding_delay)
        return self.history

    def follow(self, stamp_ns: int, kind: int, values: Sequence[float]) -> None:
        """Take what else is known at a stamp, of a kind of `layout`, with its values.

        The filter goes through the samples since then once more; it keeps them from the first of
        these on.  Raises `SampleError`, and then nothing changed.
        """
        newest_ns = self.newest_ns
        if not self.aligned:
            raise NotLevelledError(
                'a velocity or pose came before the alignment: keep the device still for '
                f'{self.settings.rest_duration:g} s'
            )
        late = (newest_ns - stamp_ns) / NANOSECONDS
        if -late > max(AHEAD, self.settings.aiding_delay):
            raise AidingError(
                f'its stamp is {-late:.3f} s ahead of the Imu: check the clocks, or raise '
                'navigator.aiding_delay where a recording is played fast'
            )
        if late > self.settings.aiding_delay:
            raise AidingError(
                f'its stamp is {late:.3f} s behind the Imu, and states are kept for '
                f'{self.settings.aiding_delay:g} s: raise navigator.aiding_delay, or send sooner'
            )
        if not self.keep().insert(stamp_ns, kind, values):
            # Its sample is not filtered yet, or was when nothing was kept.
            self._aids.add(stamp_ns, kind, values)
        if kind == layout.PLACE:
            self.strides.placings.append(stamp_ns)

    def begins_anew(self, imu: ImuSample) -> bool:
        """Say whether a sample makes it start all over, so that what waits comes out before.

        Raises `SampleError`, as `update` would.
        """
        if not self._timeline.goes_back(imu.stamp_ns):
            return False
        _require(imu)
        return True

    def update(self, imu: ImuSample) -> list[NavigationState]:
        """Take a sample; return the states that are known now, none or one, or more after a gap.

        Raises `SampleError` (not finite, no acceleration, no angular velocity, stale stamp, not
        aligned yet), and then what is estimated is as it was.
        """
        turn = _require(imu)
        restarts = self._timeline.restarts
        step_ns = self._timeline.advance(imu.stamp_ns)
        if self._timeline.restarts != restarts:
            self._start_over()
            self._levelling.fail(NotAtRestError('the stamps went back meanwhile: ask again'))
        dt = (step_ns or 0) / NANOSECONDS
        gap = dt > self.settings.max_gap
        if not self.aligned:
            if gap:
                self._alignment.clear()
            self._align(imu)
            return []
        states = []
        if gap:
            states = self.flush()
            if not self.aligned:  # it diverged
                return states
            self._detector.reset()
            if self.levelling:
                self._search = Alignment(self.settings)
            self.findings.append(
                GapError(
                    f'no samples for {dt:.3g} s: the position is held and its uncertainty grows; '
                    'if the sensor is that slow, raise navigator.max_gap'
                )
            )
        if self._search is not None:
            self._look_for_rest(self._search, imu)
        self.row[0] = (dt, *imu.specific_force, *turn, self._variance(imu))
        stamp_ns = self.advance(imu.stamp_ns)
        if stamp_ns is not None:
            states.append(state_of(stamp_ns, self._values))
        return states

    def advance(self, stamp_ns: int) -> int | None:
        """Filter the sample in `row`; return the stamp of the state in `out`, if one is known."""
        if self._heard:
            self._watch_compass(stamp_ns)
        self._stamp[0] = stamp_ns
        done = self._filter(self.row, self._stamp, self._verdict, self.out)
        self._waiting.append(stamp_ns)
        if done <= 0:
            if done < 0:
                self._give_up()
            return None
        self._values = self.out[0].tolist()
        state_ns = self._take_note(self._values)
        return state_ns if state_ns >= self._begin_ns else None

    def flush(self) -> list[NavigationState]:
        """Return the states that wait for what the detector has not seen yet, as at the end."""
        count = len(self._waiting)
        if not count:
            return []
        delay = self._detector.delay
        rows = np.repeat(self.row, delay, axis=0)  # what comes is like the last, for all we know
        rows[:, 0] = -1.0
        out = np.empty((delay, layout.STATE_ROW))
        done = self._filter(rows, NO_STAMPS, np.empty((delay, 3)), out)
        rows = out[: max(done, -1 - done)].tolist()
        states = [state_of(self._take_note(values), values) for values in rows]
        states = [state for state in states if state.stamp_ns >= self._begin_ns]
        if done < 0:
            self._give_up()
        return states

    def take(self, samples: Array, stamps: Stamps) -> StateBlock | None:
        """Take samples in columns, as kernels have them; return the states known now, if any.

        ``samples``, shape (n, ROW), and ``stamps``, shape (n,), must be what `update` would take
        without an error, and without a gap.  Where it diverges those after `newest_ns` are not
        taken.
        """
        out = np.empty((len(samples), layout.STATE_ROW))
        done, filtered, diverged = 0, [], False
        for begin in range(0, len(samples), STRETCH):
            part = slice(begin, begin + STRETCH)
            rows = samples[part]
            count = self._filter(rows, stamps[part], np.empty((len(rows), 3)), out[done:])
            diverged = count < 0
            if diverged:
                count = -1 - count
                last = begin + count + self._detector.delay - len(self._waiting)
                self._timeline._last_ns = int(stamps[last])
            waiting = np.concatenate((np.array(self._waiting, np.int64), stamps[part]))
            self._waiting = deque(waiting[count:].tolist())
            filtered.append(waiting[:count])
            done += count
            if diverged:
                break
        self.row[0] = samples[-1]
        found = None
        if done:
            block = state_block(np.concatenate(filtered), out[:done])
            self._note(out[done - 1].tolist())
            count_strides(self.strides, block)
            begin = int(np.searchsorted(block.stamp_ns, self._begin_ns))
            found = block.part(begin, done) if begin < done else None
        if diverged:
            self._give_up()
        return found

    def _give_up(self) -> None:
        """Start over, as the filter has no state any more."""
        self._start_over()
        self._levelling.fail(NotAtRestError('the navigator diverged meanwhile: ask again'))
        self.findings.append(
            DivergedError(
                'position, velocity or covariance are no longer finite: starting over at the '
                'origin, with the next rest; check the settings of navigator that are not those '
                'of its preset'
            )
        )

    def _filter(self, samples: Array, stamps: Stamps, verdicts: Array, out: Array) -> int:
        """Filter samples, after those that wait; rows that stand for no sample have no stamp.

        Below 0 says that the filter diverged, after −1 − that many.
        """
        self._detector.take(samples, verdicts)
        aids = NO_AIDS
        if self._aids.waiting:
            aids = self._due(stamps, len(samples))
        if self.history is not None:
            self.history.add(samples, verdicts, aids, stamps, self._rules, self._state)
        return navigate(samples, verdicts, aids, self._rules, self._state, out, NO_TRACE, NO_LOG)

    def _due(self, stamps: Stamps, rows: int) -> Array:
        """Return what else is known of the samples that so many rows filter."""
        waiting = len(self._waiting)
        first = self._detector.delay - waiting  # row that filters the first which waits
        last = rows - 1 - first
        if last < waiting and (last < 0 or self._waiting[last] < self._aids.first_ns):
            return NO_AIDS
        unfiltered = np.concatenate((np.array(self._waiting, np.int64), stamps))
        return self._aids.due(unfiltered, first, rows)

    def _note(self, values: list[float]) -> None:
        self.statistic, self.threshold, stationary = values[-3:]
        self.stationary = stationary > 0.0

    def _take_note(self, values: list[float]) -> int:
        """Take note of the next state; return its stamp [ns]."""
        self._note(values)
        stamp_ns = self._waiting.popleft()
        strides = self.strides
        if strides.placings:
            strides.reach(stamp_ns)
        x, y, z = values[:3]
        strides.update(self.stationary, (x, y, z))
        return stamp_ns

    def _variance(self, imu: ImuSample) -> float:
        covariance = imu.angular_velocity_covariance
        if covariance == UNKNOWN:
            return self._rate_variance
        return (covariance[0] + covariance[4] + covariance[8]) / 3.0

    def _watch_compass(self, stamp_ns: int) -> None:
        silent = self._compass.stale(stamp_ns)
        if silent and not self._silent and self.settings.compass:
            self.findings.append(
                StaleCompassError(
                    f'no compass/data for {self.settings.compass_timeout:g} s: '
                    'the yaw grows uncertain; is the compass still there?'
                )
            )
        self._silent = silent

    def _align(self, imu: ImuSample) -> None:
        """Look for rest; once it is found filter what was collected of it."""
        try:
            rest = self._alignment.add(imu, self._variance(imu))
        except (NotAtRestError, GravityError) as error:
            self._alignment.clear()
            if isinstance(error, GravityError) and not self._levelling.running:
                self.findings.append(error)
            self._levelling.fail(error)
            raise NotLevelledError(f'waiting for rest: {error}') from error
        self._start(rest)
        self._begin_ns = imu.stamp_ns
        self._alignment.clear()
        self.take(rest.rows, rest.stamps)
        self._levelling.succeed(self.aligned)

    def _start(self, rest: Rest) -> None:
        """Build detector and filter for a rest."""
        self._detector = detector_of(self.settings, self._of_detectors, rest.gravity, rest.rate)
        self._detector.learn(rest.rows)
        self._rate = rest.rate
        self._rules = self._rules_with(rest.gravity)
        stamp_ns = int(rest.stamps[-1])
        yaw, variance = 0.0, KNOWN
        if self.settings.compass and not self._compass.stale(stamp_ns):
            found = self._compass.at(stamp_ns)
            self._to_north = found is not None
            yaw, variance = found or (yaw, variance)
        still = int(self._rules[layout.STILL_SAMPLES])
        rings = 3 * still + layout.ROW * (self._detector.delay + 1)
        self._own_state, self.aligned = first_state(rest, yaw, variance, self.settings, rings)
        self.aligned += f', {rest.rate:.1f} samples a second'

    def _rules_with(self, gravity: float) -> Array:
        rules = rules_of(self.settings, self._gap_turn, self._rate, self._detector.delay)
        rules[layout.GRAVITY] = gravity
        rules[layout.MOUNTED : layout.MOUNTED + 9] = self._mounted
        return rules

    def _look_for_rest(self, search: Alignment, imu: ImuSample) -> None:
        try:
            rest = search.add(imu, self._variance(imu))
        except NotLevelledError:
            return
        except (NotAtRestError, GravityError) as error:
            self._search = None
            self._levelling.fail(error)
        else:
            self._search = None
            self._detector.learn(rest.rows)
            self._level_at(rest.still, imu.stamp_ns)
            self._levelling.succeed(self.aligned)

    def _level_at(self, still: Stillness, stamp_ns: int) -> None:
        """Let the filter level at a rest, in which the samples that wait are."""
        begin = layout.X_FORCE_BIAS
        x, y, z = self._state[begin : begin + 3].tolist()
        gravity, values, self.aligned = level_at(still, (x, y, z), self.settings)
        first_ns = self._waiting[0] if self._waiting else stamp_ns
        self._aids.add(first_ns, layout.LEVEL, values)
        self._rules = self._rules_with(gravity)


def _require(imu: ImuSample) -> Vector:
    """Return the rate of turn; raise `SampleError` where a sample is not one to navigate by."""
    require_force(imu)
    require_covariances(imu)
    require_rate(imu)
    if imu.angular_velocity is None:
        raise MissingRateError(
            'the Imu measures no angular velocity, which the inertial navigator needs: take the '
            'topic of a device with a gyro'
        )
    return imu.angular_velocity
