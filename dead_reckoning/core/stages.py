"""What each estimator takes and gives in a chain, by topic name."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable

from dead_reckoning.core.chain import END, FAULT, NOTICE, Output, Stage
from dead_reckoning.core.errors import GapError, RestartError, SampleError
from dead_reckoning.core.gravity import GravityRemoval, Levelled
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.mounting import Mountings, unmounted
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.pairing import StampPairs
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings, PedometerState, Totals
from dead_reckoning.core.samples import ImuSample, LinearAcceleration, NavigationState
from dead_reckoning.core.stamps import Timeline
from dead_reckoning.core.step_odometry import StepOdometry

RAW = 'imu/data_raw'
IMU = 'imu/data'
COMPASS = 'compass/data'
ACCELERATION = 'imu/linear_acceleration'
ODOMETRY = 'odom'
STATIONARY = 'stationary'
STATISTIC = 'stationary/statistic'
THRESHOLD = 'stationary/threshold'
SMOOTHED = 'odom_smoothed'
PATH = 'path'
AIDING_TWIST = 'aiding/twist'
AIDING_ODOMETRY = 'aiding/odom'
AIDING_POSE = 'aiding/pose'
SET_POSE = 'set_pose'
AIDING = (AIDING_TWIST, AIDING_ODOMETRY, AIDING_POSE, SET_POSE)
BESIDE = (COMPASS, *AIDING)
"""Topics beside that of the Imu."""
GROUND_TRUTH = 'ground_truth/odom'
AN3397 = 'an3397/odom'
STEPS = 'pedometer/steps'
DISTANCE = 'pedometer/distance'
STEP_LENGTH = 'pedometer/step_length'
CADENCE = 'pedometer/cadence'
STEP_ODOMETRY = 'pedometer/odom'
TOTALS = 'pedometer/totals'
"""No topic: put the states that came by other than samples, or none, into a chain under this name,
and what is new of the totals comes out."""

LEVELLED = 'levelled'
"""No topic: what gravity removal made of a sample, acceleration and attitude together."""

ODOMETRY_MESSAGE = 'odom as bytes'
"""No topic: what `ODOMETRY` is, written already."""

STEP = 'step'
"""No topic: the `PedometerState` of each step."""

PEDOMETER_OUTPUTS = (STEPS, DISTANCE, STEP_LENGTH, CADENCE, STEP_ODOMETRY)


def gravity_input(attitude: str) -> str:
    """Name the topic that gravity removal takes: an Imu with its attitude, or without."""
    return IMU if attitude == 'message' else RAW


def gravity_inputs(attitude: str) -> tuple[str, ...]:
    """Name all topics that gravity removal takes: an Imu, and where it helps a compass."""
    taken = gravity_input(attitude)
    return (taken,) if taken == IMU else (taken, COMPASS)


def navigator_inputs(settings: NavigatorSettings) -> tuple[str, ...]:
    """Name all topics that the inertial navigator takes: an Imu, and beside it what there is."""
    return (settings.input, *BESIDE)


def navigator_outputs(settings: NavigatorSettings) -> tuple[str, ...]:
    """Name all topics of the inertial navigator, but for what its detector goes by."""
    return (ODOMETRY, STATIONARY, *((SMOOTHED, PATH) if settings.smoothing else ()))


def gravity_stage(removal: GravityRemoval, mountings: Mountings = unmounted) -> Stage:
    """Take an Imu; give the linear acceleration, and the Imu with attitude if it came without.

    Both together come out as `LEVELLED`, for the integrator in the same chain.  Where the attitude
    does not come with the Imu, a compass is taken too, for the yaw of the body.  Inside, the axes
    are those of the body; topics are in the frame of the sensor.
    """

    def take(imu: ImuSample) -> list[Output]:
        mounting = mountings(imu.frame_id)
        turned = mounting.to_body(imu)
        outputs: list[Output] = []
        restarts, levelled = removal.restarts, removal.levelled
        try:
            made = removal.update(turned)
        except SampleError as error:
            outputs.append((FAULT, error))
        else:
            handed = imu
            if made.imu is not turned:
                handed = mounting.to_sensor(made.imu)
                outputs.append((IMU, handed))
            outputs.append((ACCELERATION, made.acceleration))
            outputs.append((LEVELLED, Levelled(handed, made.acceleration)))
        if removal.restarts != restarts:
            outputs.append((FAULT, RestartError('the stamps went back: looking for rest anew')))
        if removal.levelled is not levelled:  # the same words may be said anew
            outputs.append((NOTICE, f'levelled: {removal.levelled}'))
        if removal.findings:
            outputs.extend((FAULT, finding) for finding in removal.findings)
            removal.findings.clear()
        return outputs

    def turn(compass: ImuSample) -> list[Output]:
        removal.follow_compass(compass)
        return []

    taken = gravity_input(removal.settings.attitude)
    return {taken: take} if taken == IMU else {taken: take, COMPASS: turn}


def pairing_stage() -> Stage:
    """Take acceleration and attitude as two topics; give those of equal stamps as one.

    A sample that could be no part of a pair, since gravity removal refuses the like of it, or by
    its stamp, is a fault of its own and waits for no partner.
    """
    pairs: StampPairs[LinearAcceleration, ImuSample] = StampPairs()
    accelerations, attitudes = Timeline(), Timeline()

    def give(pair: tuple[LinearAcceleration, ImuSample] | None) -> list[Output]:
        outputs: list[Output] = []
        lost = pairs.collect_lost(ACCELERATION, IMU)
        if lost is not None:
            outputs.append((FAULT, lost))
        if pair is not None:
            acceleration, imu = pair
            outputs.append((LEVELLED, Levelled(imu, acceleration)))
        return outputs

    def take_acceleration(sample: LinearAcceleration) -> list[Output]:
        accelerations.advance(sample.stamp_ns)
        return give(pairs.left(sample.stamp_ns, sample))

    def take_attitude(imu: ImuSample) -> list[Output]:
        Integrator.require(imu)
        attitudes.advance(imu.stamp_ns)
        return give(pairs.right(imu.stamp_ns, imu))

    return {ACCELERATION: take_acceleration, IMU: take_attitude}


class RestOutput:
    """Say whether the body rests, when that changes."""

    def __init__(self) -> None:
        self._said: bool | None = None

    def of(self, stationary: bool) -> list[Output]:
        """Return what is new of it."""
        if stationary is self._said:
            return []
        self._said = stationary
        return [(STATIONARY, stationary)]


def integrator_stage(
    integrator: Integrator,
    mountings: Mountings = unmounted,
    rest: RestOutput | None = None,
) -> Stage:
    """Take what gravity removal made; give the state of the body, and rest on change."""
    rests = rest or RestOutput()

    def integrate(levelled: Levelled) -> list[Output]:
        outputs: list[Output] = []
        restarts, gaps = integrator.restarts, integrator.gaps
        mounting = mountings(levelled.imu.frame_id)
        state = integrator.update(
            levelled.acceleration, mounting.to_body(levelled.imu), mounting.translation
        )
        if integrator.restarts != restarts:
            outputs.append((FAULT, RestartError('the stamps went back: starting at the origin')))
        if integrator.gaps != gaps:
            outputs.append((FAULT, _gap(integrator.settings.max_gap)))
        outputs.append((ODOMETRY, state))
        return outputs + rests.of(state.stationary)

    return {LEVELLED: integrate}


def pedometer_inputs(settings: PedometerSettings) -> tuple[str, ...]:
    """Name the topics that a pedometer takes: the Imu, and what gives the heading beside it."""
    if settings.heading in ('compass', 'any'):
        return (settings.input, COMPASS)
    return (settings.input, ODOMETRY) if settings.heading == 'navigator' else (settings.input,)


class StepOutputs:
    """Give the totals of a pedometer as they change, and the way at each step.

    What is said was kept before; what can't be at once waits, in order, until it is.
    """

    def __init__(self, pedometer: Pedometer, odometry: StepOdometry) -> None:
        self._pedometer = pedometer
        self._odometry = odometry
        self._said: dict[str, float] = {}
        self._waiting: deque[tuple[Callable[[], bool], list[Output]]] = deque()
        self.keep: Callable[[Totals], Callable[[], bool]] = lambda _: _at_once
        """Keeps totals where they outlast the program; returns what says whether that is done."""

    def of(self, states: Iterable[PedometerState]) -> list[Output]:
        """Return what comes of states, at first the totals too."""
        outputs: list[Output] = []
        for state in states:
            outputs.extend(self._changes(state))
            if state.duration > 0.0:  # else the walk ended
                outputs.append((STEP, state))
            walked = self._odometry.update(state)
            if walked is not None:
                outputs.append((STEP_ODOMETRY, walked))
        return self._kept(outputs) if self._said else self._kept(outputs) + self.changes()

    def changes(self) -> list[Output]:
        """Return the totals that are others than those that came out last."""
        return self._kept(self._changes(self._pedometer))

    def due(self) -> list[Output]:
        """Return what had to wait and need not any more."""
        outputs: list[Output] = []
        while self._waiting and self._waiting[0][0]():
            outputs += self._waiting.popleft()[1]
        return outputs

    def _kept(self, outputs: list[Output]) -> list[Output]:
        if outputs:
            self._waiting.append((self.keep(self._pedometer.totals), outputs))
        return self.due()

    def _changes(self, totals: Pedometer | PedometerState) -> list[Output]:
        now: dict[str, float] = {
            STEPS: totals.steps,
            DISTANCE: totals.distance,
            STEP_LENGTH: totals.step_length,
            CADENCE: totals.cadence,
        }
        new: list[Output] = [(n, now[n]) for n in now if self._said.get(n) != now[n]]
        self._said.update(now)
        return new


def _at_once() -> bool:
    return True


def pedometer_stage(
    pedometer: Pedometer,
    odometry: StepOdometry,
    mountings: Mountings = unmounted,
    says: StepOutputs | None = None,
) -> Stage:
    """Take an Imu and what gives the heading; give the totals on change, the way at each step."""
    steps = says or StepOutputs(pedometer, odometry)

    def count(imu: ImuSample) -> list[Output]:
        imu = mountings(imu.frame_id).to_body(imu)
        outputs: list[Output] = []
        restarts, gaps = pedometer.restarts, pedometer.gaps
        states = pedometer.update(imu)
        if pedometer.restarts != restarts:
            outputs.append((FAULT, RestartError('the stamps went back: the walk has ended')))
        if pedometer.gaps != gaps:
            outputs.append((FAULT, _walk_ended(pedometer.settings.max_gap)))
        try:
            odometry.take_orientation(imu)
        except SampleError as error:
            outputs.append((FAULT, error))
        return outputs + steps.of(states)

    def turn(imu: ImuSample) -> tuple[()]:
        odometry.take_compass(imu)
        return ()

    def follow(state: NavigationState) -> tuple[()]:
        odometry.take_navigator(state)
        return ()

    taken: Stage = {
        pedometer.settings.input: count,
        COMPASS: turn,
        TOTALS: lambda states: [*steps.of(states), *steps.changes()],
        END: lambda _: steps.of(pedometer.flush()),
    }
    return {**taken, ODOMETRY: follow} if pedometer.settings.heading == 'navigator' else taken


def _gap(max_gap: float) -> GapError:
    return GapError(
        f'no samples for more than {max_gap:g} s: position and velocity are held, their '
        'uncertainty grows; if the sensor is that slow, raise integrator.max_gap'
    )


def _walk_ended(max_gap: float) -> GapError:
    return GapError(
        f'no samples for more than {max_gap:g} s: the walk has ended, and no step is counted over '
        'it; if the sensor is that slow, raise pedometer.max_gap'
    )
