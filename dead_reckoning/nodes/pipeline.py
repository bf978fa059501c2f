"""Node `pipeline`: the whole chain in one process."""

from __future__ import annotations

from pathlib import Path

from dead_reckoning.configuration import DRIVER
from dead_reckoning.core.chain import Stage
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.pipeline import Pipeline, PipelineSettings
from dead_reckoning.core.stages import (
    ACCELERATION,
    GROUND_TRUTH,
    IMU,
    ODOMETRY,
    RAW,
    STATIONARY,
    gravity_input,
    gravity_inputs,
)
from dead_reckoning.nodes import gravity_removal, integrator
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.simulated_driver import SimulatedDriver
from dead_reckoning.tables import OdometryLog, stop_after


class PipelineNode(ChainNode):
    """Go the whole way from an Imu topic, or from a sensor, to `odom` without a topic between."""

    def __init__(self) -> None:
        parts = (PipelineSettings, *DRIVER, GravitySettings, IntegratorSettings)
        super().__init__('pipeline', parts)
        self._log: OdometryLog | None = None
        configuration = self.configuration
        settings = configuration[PipelineSettings]
        parts_built = Pipeline(
            configuration[GravitySettings],
            configuration[IntegratorSettings],
            self.common,
            self.frames,
            self._ending(settings),
        )
        attitude = configuration[GravitySettings].attitude
        taken = gravity_input(attitude)
        from_topic = settings.source == 'topic'
        between = [ACCELERATION]
        if taken == RAW:
            between.append(IMU)
        if not from_topic:
            between += [RAW, GROUND_TRUTH]
        self.connect(
            parts_built.chain,
            inputs=[name for name in gravity_inputs(attitude) if from_topic or name != taken],
            outputs=(ODOMETRY, STATIONARY, *between),
            on_demand=between,
        )
        if not from_topic:
            self.driver = SimulatedDriver(self, configuration)
        gravity_removal.serve(self, parts_built.gravity)
        integrator.serve(self, parts_built.integrator)

    def _ending(self, settings: PipelineSettings) -> list[Stage]:
        """Return the stages for `pipeline.log_csv` and `pipeline.duration`, if asked for."""
        stages: list[Stage] = []
        if settings.log_csv:
            self._log = OdometryLog(Path(settings.log_csv).expanduser())
            stages.append(self._log.stage())
        if settings.duration > 0.0:
            stages.append(stop_after(settings.duration, self.finish))
        return stages

    def destroy_node(self) -> None:
        """Close the log, too."""
        if self._log is not None:
            self._log.close()
        super().destroy_node()


NODE = PipelineNode
