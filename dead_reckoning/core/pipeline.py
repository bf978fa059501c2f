"""A whole chain from one configuration, for `pipeline` live and for replays of recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from dead_reckoning.core.chain import Chain, Stage
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.mounting import Mountings, mountings_of
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.parameters import Parts, Settings, parameter
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.core.stages import (
    ACCELERATION,
    IMU,
    ODOMETRY,
    PEDOMETER_OUTPUTS,
    STATIONARY,
    STATISTIC,
    THRESHOLD,
    RestOutput,
    StepOutputs,
    gravity_input,
    gravity_inputs,
    gravity_stage,
    integrator_stage,
    navigator_inputs,
    navigator_outputs,
    pedometer_inputs,
    pedometer_stage,
)
from dead_reckoning.core.step_odometry import StepOdometry

if TYPE_CHECKING:  # its kernels are imported where it is used
    from dead_reckoning.core.navigator import InertialNavigator
    from dead_reckoning.core.navigator_stage import BodyStates

INTEGRATOR, PEDOMETER, NAVIGATOR = 'integrator', 'pedometer', 'inertial_navigator'


@dataclass(frozen=True, kw_only=True)
class PipelineSettings(Settings, prefix='pipeline'):
    """Which source feeds the chain and which estimators it ends in."""

    source: str = parameter(
        'topic',
        'topic (imu/data_raw, or imu/data where gravity.attitude is message) or one of those of '
        'the driver',
        choices=('topic', 'simulated', 'serial', 'iio', 'i2c'),
    )
    estimators: tuple[str, ...] = parameter(
        (INTEGRATOR,),
        'Estimators at the end of the chain: integrator or inertial_navigator, which both give '
        'odom, and pedometer',
        choices=(INTEGRATOR, PEDOMETER, NAVIGATOR),
    )
    log_csv: str = parameter(
        '', 'File to log each state to, as text; empty for none. The mbed page logs such a file'
    )
    duration: float = parameter(
        0.0,
        'End after this time, by the stamps of the states; 0 for never. The mbed page ends after '
        '15 s',
        unit='s',
        minimum=0.0,
    )

    def validate(self) -> None:
        """Raise `SettingsError` where two give odom, or none, and states are logged or timed."""
        given = {INTEGRATOR, NAVIGATOR} & set(self.estimators)
        if len(given) == 2:
            raise SettingsError(
                'pipeline.estimators: integrator and inertial_navigator exclude each other, as '
                'both give odom; leave one out'
            )
        if given:
            return
        for key, asked in (('log_csv', self.log_csv != ''), ('duration', self.duration > 0.0)):
            if asked:
                raise SettingsError(
                    f'pipeline.{key}: it goes by the states of the integrator or the '
                    'inertial_navigator; add one to pipeline.estimators'
                )


class Pipeline:
    """The estimators that the settings ask for, composed; what is not there is None.

    Gravity is removed for the integrator, and for a pedometer that counts on an `imu/data` that
    does not come from elsewhere.
    """

    def __init__(
        self,
        parts: Parts,
        more: Iterable[Stage] = (),
        mountings: Mountings | None = None,
        *,
        blocks: bool = False,
    ) -> None:
        """``more`` are stages that stand at the end and take what they name.

        With ``blocks`` the chain takes and gives blocks of samples, for whole recordings
        (`block_stages`).  ``mountings`` are those of the parameters, unless a node gives its own,
        from TF.  Raises
        `SettingsError` where the parameters ask for TF, and none are given.
        """
        make = _stages(blocks)
        mountings = mountings or mountings_of(parts[FrameSettings])
        estimators = parts[PipelineSettings].estimators
        common = parts[CommonSettings]
        self.gravity: GravityRemoval | None = None
        self.integrator: Integrator | None = None
        self.pedometer: Pedometer | None = None
        self.step_odometry: StepOdometry | None = None
        self.navigator: InertialNavigator | None = None
        self.body: BodyStates | None = None
        """Carries the states of the navigator to the body."""
        self.inputs: tuple[str, ...] = ()
        """Topics that have to come from outside."""
        self.between: tuple[str, ...] = ()
        """Topics of samples on their way to the estimators."""
        self.outputs: tuple[str, ...] = ()
        """Topics of the estimators."""
        self.rest = RestOutput()
        """Says when the body rests."""
        self.steps: StepOutputs | None = None
        """Says what steps there were."""
        stages: list[Stage] = []
        gravity, pedometer = parts[GravitySettings], parts[PedometerSettings]
        counts = PEDOMETER in estimators
        taken = gravity_input(gravity.attitude)
        inputs: list[str] = []
        if INTEGRATOR in estimators or (counts and pedometer.input == IMU != taken):
            self.gravity = GravityRemoval(gravity, common, parts[FrameSettings])
            stages.append(make.gravity(self.gravity, mountings))
            inputs += gravity_inputs(gravity.attitude)
            self.between = (ACCELERATION,) if taken == IMU else (ACCELERATION, IMU)
        if INTEGRATOR in estimators:
            self.integrator = Integrator(parts[IntegratorSettings], common)
            stages.append(make.integrator(self.integrator, mountings, self.rest))
            self.outputs += (ODOMETRY, STATIONARY)
        made = {IMU} if self.gravity is not None and taken != IMU else set()
        if NAVIGATOR in estimators:
            from dead_reckoning.core.navigator import InertialNavigator
            from dead_reckoning.core.navigator_stage import BodyStates

            navigator = parts[NavigatorSettings]
            own = [parts[part] for part in navigator.detector_parts]
            self.navigator = InertialNavigator(navigator, common, *own)
            self.body = BodyStates(self.navigator, mountings)
            frames = parts[FrameSettings]
            stages.append(make.navigator(self.navigator, mountings, self.body, self.rest, frames))
            self.outputs += navigator_outputs(navigator)
            if not blocks:
                self.between += (STATISTIC, THRESHOLD)
            inputs += [name for name in navigator_inputs(navigator) if name not in made]
            made.add(ODOMETRY)
        if counts:
            along = pedometer.heading == 'navigator'
            if along and NAVIGATOR not in estimators:
                raise SettingsError(
                    "pedometer.heading: 'navigator' is not allowed, as pipeline.estimators has "
                    'none; add inertial_navigator there, or take another heading'
                )
            self.pedometer = Pedometer(pedometer, parts[pedometer.method_part])
            self.step_odometry = StepOdometry(pedometer, common)
            self.steps = StepOutputs(self.pedometer, self.step_odometry)
            stages.append(
                make.pedometer(self.pedometer, self.step_odometry, mountings, self.steps)
            )
            self.outputs += PEDOMETER_OUTPUTS
            inputs += [name for name in pedometer_inputs(pedometer) if name not in made]
        self.inputs = tuple(dict.fromkeys(inputs))
        if blocks and counts and along:
            stages = [_in_parts(stages, self.inputs)]
        self.stages: tuple[Stage, ...] = (*stages, *more)
        self.chain = Chain(self.stages)


class _Stages(NamedTuple):
    gravity: Callable[[GravityRemoval, Mountings], Stage]
    integrator: Callable[[Integrator, Mountings, RestOutput], Stage]
    pedometer: Callable[[Pedometer, StepOdometry, Mountings, StepOutputs], Stage]
    navigator: Callable[
        [InertialNavigator, Mountings, BodyStates, RestOutput, FrameSettings], Stage
    ]


def _stages(blocks: bool) -> _Stages:
    if not blocks:
        return _Stages(gravity_stage, integrator_stage, pedometer_stage, _navigator_stage)
    # Imported here: a live node has no use for it.
    from dead_reckoning.core.block_stages import (
        gravity_block_stage,
        integrator_block_stage,
        navigator_block_stage,
        pedometer_block_stage,
    )

    return _Stages(
        gravity_block_stage, integrator_block_stage, pedometer_block_stage, navigator_block_stage
    )


def _in_parts(stages: Iterable[Stage], inputs: Iterable[str]) -> Stage:
    from dead_reckoning.core.block_stages import in_parts

    return in_parts(stages, inputs)


def _navigator_stage(
    navigator: InertialNavigator,
    mountings: Mountings,
    body: BodyStates,
    rest: RestOutput,
    frames: FrameSettings,
) -> Stage:
    from dead_reckoning.core.navigator_stage import navigator_stage

    return navigator_stage(navigator, mountings, body, rest, frames)
