"""Count steps and judge the distance walked: AN-900's pedometer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dead_reckoning.core import kernels, step_detectors, step_lengths
from dead_reckoning.core.checks import require_force
from dead_reckoning.core.errors import SettingsError, StepCalibrationError
from dead_reckoning.core.parameters import Derived, Settings, parameter
from dead_reckoning.core.reorder import StampOrder
from dead_reckoning.core.resampler import Resampler
from dead_reckoning.core.samples import NANOSECONDS, ImuSample, Vector
from dead_reckoning.core.step_detectors import Step, StepDetector
from dead_reckoning.core.step_lengths import StepLengthModel
from dead_reckoning.core.step_window import LONGEST, StepWindow

AXES = ('x', 'y', 'z')


@dataclass(frozen=True, kw_only=True)
class PedometerSettings(Settings, prefix='pedometer'):
    """Which samples a pedometer counts, how, and how long a step is."""

    input: str = parameter(
        'imu/data_raw',
        'Topic it counts on; for a heading imu/data, or compass/data or odom beside either',
        choices=('imu/data_raw', 'imu/data'),
    )
    method: str = parameter(
        'rhythm',
        'How steps are found: rhythm (peaks, while they repeat as walking does), an900 (AN-900, '
        'corrected)',
        choices=step_detectors.names(),
    )
    axes: tuple[str, ...] = parameter(
        AXES,
        'Axes whose magnitude is counted on; AN-900 takes x and y, all fit any mounting',
        choices=AXES,
    )
    shortest_step: float = parameter(
        0.25,
        'Shortest time from step to step; what comes sooner is no step',
        unit='s',
        minimum=0.0,
        maximum=LONGEST,
        mutable=True,
    )
    longest_step: float = parameter(
        2.0,
        'Longest time from step to step; after it the walk has ended',
        unit='s',
        minimum=0.1,
        maximum=LONGEST,
        mutable=True,
    )
    length_model: str = parameter(
        'an900_equation2',
        'How long a step is: by its bounce (an900_equation2), the fullness of its curve '
        '(an900_equation1), its swing (weinberg), its roughness (kim), its time '
        '(cadence_height), or all alike (constant)',
        choices=step_lengths.names(),
    )
    k: float = parameter(
        Derived(
            lambda pedometer: pedometer.model.K,
            'that of the model: '
            + ', '.join(f'{name} {step_lengths.model(name).K:g}' for name in step_lengths.names()),
        ),
        'Constant of the length model, of which each length is a multiple; ~/calibrate finds it',
        unit='m for constant; docs/pedometer.md has those of the others',
        minimum=0.001,
        maximum=100.0,
        mutable=True,
    )
    height: float = parameter(
        1.7,
        'Height of the pedestrian, for cadence_height',
        unit='m',
        minimum=0.3,
        maximum=3.0,
        mutable=True,
    )
    averaging: float = parameter(
        1.0,
        "AN-900's avgconst: a step counts 1/averaging in the exponential average of step "
        'lengths; 1 averages nothing',
        unit='steps',
        minimum=1.0,
        maximum=1000.0,
        mutable=True,
    )
    calibration_distance: float = parameter(
        50.0,
        'Distance that is walked between ~/calibrate true and ~/calibrate false',
        unit='m',
        minimum=1.0,
        maximum=100_000.0,
        mutable=True,
    )
    state_file: str = parameter(
        '',
        'File that keeps steps and distance over restarts of the node, ~ for home; empty for none',
    )
    reorder_time: float = parameter(
        0.1,
        'How long samples are held back for those that come late; later ones are dropped',
        unit='s',
        minimum=0.0,
        maximum=0.9,
    )
    max_gap: float = parameter(
        1.0,
        'Longest time between samples over which a walk goes on; over a longer one it ends',
        unit='s',
        minimum=0.05,
        maximum=LONGEST,
    )
    heading: str = parameter(
        'any',
        'What the direction of the steps is taken from: compass (compass/data), orientation (yaw '
        'of the counted topic), any (the compass while it is heard, else the orientation), '
        'navigator (odom of the inertial navigator) or none',
        choices=('any', 'compass', 'orientation', 'navigator', 'none'),
    )
    heading_offset: float = parameter(
        0.0,
        'Angle from the heading of the device to the direction of walking, anticlockwise',
        unit='rad',
        minimum=-6.3,
        maximum=6.3,
        mutable=True,
    )
    heading_deviation: float = parameter(
        0.1,
        'One sigma of what else is between heading and direction of walking, the same all along',
        unit='rad',
        minimum=0.0,
        maximum=3.2,
        mutable=True,
    )
    length_deviation: float = parameter(
        0.06,
        "One sigma of k's relative error, the same for all steps; AN-900 reports 6 %",
        minimum=0.0,
        maximum=1.0,
        mutable=True,
    )
    step_deviation: float = parameter(
        0.1,
        "One sigma of a single step's relative error, of its length and direction",
        minimum=0.0,
        maximum=1.0,
        mutable=True,
    )

    @property
    def model(self) -> StepLengthModel:
        """The chosen model of step lengths."""
        chosen: StepLengthModel = step_lengths.model(self.length_model)
        return chosen

    @property
    def method_part(self) -> type[Settings]:
        """The class of the settings of the chosen method."""
        part: type[Settings] = step_detectors.detector_class(self.method).Settings
        return part

    def validate(self) -> None:
        """Raise `SettingsError` where the window of time admits nothing."""
        if not self.shortest_step < self.longest_step:
            raise SettingsError(
                f'pedometer.longest_step: {self.longest_step:g} s is not longer than '
                f'pedometer.shortest_step, {self.shortest_step:g} s'
            )


@dataclass(frozen=True, slots=True, eq=False)
class PedometerState:
    """The totals after a step, or at the end of a walk.

    ``stamp_ns``
        when the step ended, or the sample that ended the walk was taken [ns].
    ``steps``, ``distance``
        since the start or the last reset, distance in [m].
    ``step_length``
        of the last step, averaged if asked [m].
    ``cadence``
        steps per second over the last two steps of the walk, 0 when none goes on [Hz].
    ``duration``
        time since the step before [s]; 0 if this is no step but the end of a walk.
    """

    stamp_ns: int
    steps: int
    distance: float
    step_length: float
    cadence: float
    duration: float


@dataclass(frozen=True, slots=True)
class Totals:
    """What a pedometer goes on from after a restart of its program.

    ``steps``, ``distance``, ``step_length``
        as in `PedometerState`; the last one for the exponential average.
    """

    steps: int = 0
    distance: float = 0.0
    step_length: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """What a walk of a known distance showed: the constant ``k`` and the number of steps."""

    k: float
    steps: int


class Pedometer:
    """Count steps, add up their lengths.

    Samples are put in the order of their stamps and brought to the rate of the method; the
    magnitude of the chosen axes goes to the method, each step it finds to the model of step
    lengths.  docs/pedometer.md has the equations.

    The first sample only sets the start.  Stamps: late ones find their place within
    ``reorder_time``, later and repeated ones are refused; one that goes back by 1 s or more is a
    restart.  A restart or a gap ends the walk, nothing is counted over it, and the totals stay.  A
    clipped sample counts as it is.
    """

    def __init__(self, settings: PedometerSettings, method_settings: Settings) -> None:
        """``method_settings``: those of the chosen method."""
        self.settings = settings
        self.gaps = 0
        """Gaps longer than `max_gap` so far."""
        self.running = True
        """Whether it counts."""
        self._max_gap_ns = round(settings.max_gap * NANOSECONDS)
        self.model = settings.model
        """How long each step is, but for k."""
        self._window = StepWindow(settings.shortest_step, settings.longest_step)
        detector = step_detectors.detector_class(settings.method)
        self._detector: StepDetector = detector(method_settings, self._window)
        self._order: StampOrder[Vector] = StampOrder(settings.reorder_time)
        use_x, use_y, use_z = (float(axis in settings.axes) for axis in AXES)
        self._resampler = Resampler(detector.RATE, (use_x, use_y, use_z), bool(detector.KERNELS))
        self._last_ns: int | None = None
        self._calibration: tuple[int, float] | None = None
        self._calibrated_ns = 0
        self.reset()

    def reset(self) -> None:
        """Clear the totals and forget the walk; whether it counts stays."""
        self.steps = 0
        self.distance = 0.0
        self.step_length = 0.0
        self._calibration = None
        self._order.reset()
        self._end_walk()

    @property
    def totals(self) -> Totals:
        """What `resume` goes on from."""
        return Totals(self.steps, self.distance, self.step_length)

    def resume(self, totals: Totals) -> None:
        """Go on from totals as if they were its own, with a new walk."""
        self.reset()
        self.steps, self.distance = totals.steps, totals.distance
        self.step_length = totals.step_length

    def start(self) -> None:
        """Clear the totals and count."""
        self.reset()
        self.running = True

    def stop(self) -> list[PedometerState]:
        """Count no more and hold the totals; return what was left, as `flush`."""
        states = self.flush()
        self.running = False
        self._calibration = None
        self._order.reset()
        return states

    def flush(self) -> list[PedometerState]:
        """Return what is left, as at the end: steps that wait for later samples, and the end."""
        states: list[PedometerState] = []
        if self.running:
            for stamp_ns, vector in self._order.flush():
                self._take(stamp_ns, vector, states)
            if self._last_ns is not None:
                self._break_off(self._last_ns, states)
        return states

    def _end_walk(self) -> None:
        self.cadence = 0.0
        self._duration = 0.0
        self._last_ns = None
        self._resampler.reset()
        self._detector.reset()

    @property
    def walking(self) -> bool:
        """Whether a walk goes on."""
        return self._detector.walking

    @property
    def newest_ns(self) -> int | None:
        """The newest stamp [ns] that came; None before the first."""
        return self._order.newest_ns

    @property
    def restarts(self) -> int:
        """How often the stamps went back by 1 s or more."""
        return self._order.restarts

    def configure(self, settings: PedometerSettings) -> None:
        """Take over changed settings, all at once, without touching totals and walk."""
        self.settings = settings
        self._window.configure(settings.shortest_step, settings.longest_step)

    def configure_method(self, settings: Settings) -> None:
        """Take over changed settings of the method without touching totals and walk."""
        self._detector.configure(settings)

    def begin_calibration(self) -> None:
        """Take the steps from now on for the walk of the known distance.

        Of those that came before and are held back, that is the last one only: as late as it is,
        one will be missing at the end.
        """
        if not self.running:
            raise StepCalibrationError('the pedometer is stopped: call ~/start first')
        self._calibration = (0, 0.0)
        self._calibrated_ns = self.newest_ns or 0

    def end_calibration(self) -> Calibration:
        """Return what makes the walk since the start of the calibration as long as it was.

        The k in force stays until `configure`.  Raises `StepCalibrationError` where nothing was
        begun or nobody walked, `SettingsError` for a k beyond what is allowed; then the
        calibration goes on.
        """
        if self._calibration is None:
            raise StepCalibrationError(
                'no calibration was begun, or a stop or reset ended it: call ~/calibrate with '
                'true at the start of the distance'
            )
        steps, size = self._calibration
        if not size > 0.0:
            raise StepCalibrationError(
                f'{steps} steps since the start of the calibration: walk '
                'pedometer.calibration_distance, then call ~/calibrate with false again'
            )
        k = self.settings.calibration_distance / size
        self.settings.changed({'pedometer.k': k})
        self._calibration = None
        return Calibration(k, steps)

    def update(self, imu: ImuSample) -> list[PedometerState]:
        """Take one sample; return a state for each step it proves, and for the end of a walk.

        How long after a step that is, and how many of the first come together, is up to the
        method; `reorder_time` comes to it.  Raises `SampleError` (not finite, no acceleration,
        stale stamp), and then nothing changed.
        """
        require_force(imu)
        order = self._order
        restarts = order.restarts
        ordered = order.add(imu.stamp_ns, imu.specific_force)
        states: list[PedometerState] = []
        if order.restarts != restarts:
            self._break_off(imu.stamp_ns, states)
        if self.running:
            for stamp_ns, vector in ordered:
                self._take(stamp_ns, vector, states)
        return states

    def _take(self, stamp_ns: int, force: Vector, states: list[PedometerState]) -> None:
        last_ns, self._last_ns = self._last_ns, stamp_ns
        if last_ns is not None and stamp_ns - last_ns > self._max_gap_ns:
            self.gaps += 1
            self._break_off(last_ns, states)
            self._last_ns = stamp_ns
        for cell_ns, magnitude in self._resampler.add(stamp_ns, force):
            states += self.advance(cell_ns, magnitude)

    def advance(self, stamp_ns: int, magnitude: float) -> list[PedometerState]:
        """Take the next magnitude [m/s²], at the rate of the method; return what it proves."""
        detector = self._detector
        walked = detector.walking
        steps = detector.update(stamp_ns, magnitude)
        ends = walked and not detector.walking
        if not (steps or ends):
            return []
        states = [self._count(step) for step in steps]
        if ends:
            self._say_end(stamp_ns, states)
        return states

    def _break_off(self, stamp_ns: int, states: list[PedometerState]) -> None:
        walked = self._detector.walking
        states.extend(self._count(step) for step in self._detector.finish())
        if walked:
            self._say_end(stamp_ns, states)
        self._calibrated_ns = min(self._calibrated_ns, stamp_ns)  # a restart
        self._end_walk()

    def _say_end(self, stamp_ns: int, states: list[PedometerState]) -> None:
        self.cadence = self._duration = 0.0
        states.append(
            PedometerState(stamp_ns, self.steps, self.distance, self.step_length, 0.0, 0.0)
        )

    def _count(self, step: Step) -> PedometerState:
        size = self.model.size(step, self.settings.height)
        length = self.settings.k * size
        if self.steps >= 2:  # the first two stand for themselves, as in the listing
            averaging = self.settings.averaging
            length = ((averaging - 1.0) * self.step_length + length) / averaging
        begun_ns = self._calibrated_ns - round(step.duration * NANOSECONDS)
        if self._calibration is not None and step.stamp_ns > begun_ns:
            steps, total = self._calibration
            self._calibration = (steps + 1, total + size)
        self.steps += 1
        self.distance += length
        self.step_length = length
        before = self._duration or step.duration
        self._duration = step.duration
        self.cadence = 2.0 / (before + step.duration)
        return PedometerState(
            step.stamp_ns, self.steps, self.distance, length, self.cadence, step.duration
        )


def kept(method: str) -> bool:
    """Load the kernels of a method that an earlier run has kept; say whether those are all."""
    return all(kernels.load(kernel, *given) for kernel, given in _kernels(method))


def load_kernels(method: str) -> None:
    """Load the kernels of a method, or compile them, so that samples need not wait for it."""
    for kernel, given in _kernels(method):
        kernel(*given)


def _kernels(method: str) -> tuple[Any, ...]:
    """Return those of a detector, and of the resampler before it; nothing where it has none."""
    found = step_detectors.detector_class(method).KERNELS
    return (*Resampler.KERNELS, *found) if found else ()
