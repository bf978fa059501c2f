"""A whole chain from one configuration, for `pipeline` live and for replays of recordings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from dead_reckoning.core.chain import Chain, Stage
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.stages import gravity_stage, integrator_stage


@dataclass(frozen=True, kw_only=True)
class PipelineSettings(Settings, prefix='pipeline'):
    """Which source feeds the chain and which estimators it ends in."""

    source: str = parameter(
        'topic',
        'topic (imu/data_raw, or imu/data where gravity.attitude is message) or one of those of '
        'the driver',
        choices=('topic', 'simulated'),
    )
    estimators: tuple[str, ...] = parameter(
        ('integrator',), 'Estimators at the end of the chain', choices=('integrator',)
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


class Pipeline:
    """The estimators that the settings ask for, composed."""

    def __init__(
        self,
        gravity: GravitySettings,
        integrator: IntegratorSettings,
        common: CommonSettings,
        frames: FrameSettings,
        more: Iterable[Stage] = (),
    ) -> None:
        """``more`` are stages that stand at the end and take what they name."""
        self.gravity = GravityRemoval(gravity, common, frames)
        self.integrator = Integrator(integrator, common)
        stages = [gravity_stage(self.gravity), integrator_stage(self.integrator)]
        self.chain = Chain([*stages, *more])
