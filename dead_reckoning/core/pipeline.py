"""A whole chain from one configuration, for `pipeline` live and for replays of recordings."""

from __future__ import annotations

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


class Pipeline:
    """The estimators that the settings ask for, composed."""

    def __init__(
        self,
        gravity: GravitySettings,
        integrator: IntegratorSettings,
        common: CommonSettings,
        frames: FrameSettings,
    ) -> None:
        self.gravity = GravityRemoval(gravity, common, frames)
        self.integrator = Integrator(integrator, common)
        stages: list[Stage] = [gravity_stage(self.gravity), integrator_stage(self.integrator)]
        self.chain = Chain(stages)
