"""Node `pipeline`: the whole chain in one process."""

from __future__ import annotations

from pathlib import Path

from dead_reckoning.configuration import DRIVER, NAVIGATOR, PEDOMETER
from dead_reckoning.core.chain import Stage
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.pedometer import PedometerSettings
from dead_reckoning.core.pipeline import Pipeline, PipelineSettings
from dead_reckoning.core.stages import AIDING, BESIDE, IMU, RAW
from dead_reckoning.live import live_chain
from dead_reckoning.nodes import gravity_removal, inertial_navigator, integrator, pedometer
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.driver import driver_of
from dead_reckoning.nodes.loading import load
from dead_reckoning.nodes.transforms import mountings
from dead_reckoning.tables import OdometryLog, stop_after

_REMEDIES = {
    RAW: "set gravity.attitude to 'rest' or 'estimate', or navigator.input and pedometer.input, "
    "as far as they are used, to 'imu/data_raw'",
    IMU: "set gravity.attitude to 'message', or navigator.input and pedometer.input, as far as "
    "they are used, to 'imu/data'",
}
_NO_REMEDY = 'it is no Imu: leave it to accelerometer_driver'


class PipelineNode(ChainNode):
    """Go the whole way from an Imu topic, or from a sensor, to the estimators' outputs.

    Nothing but what someone subscribes is published between.
    """

    def __init__(self) -> None:
        parts = (PipelineSettings, *DRIVER, GravitySettings, IntegratorSettings)
        super().__init__('pipeline', (*parts, *PEDOMETER, *NAVIGATOR))
        settings = self.configuration[PipelineSettings]
        from_topic = settings.source == 'topic'
        if 'inertial_navigator' in settings.estimators:
            inertial_navigator.prepare(self)
        if 'pedometer' in settings.estimators:
            pedometer.prepare(self)
        pipeline = Pipeline(
            self.configuration, self._ending(settings), mountings(self, self.frames)
        )
        inputs = [name for name in pipeline.inputs if from_topic or name in BESIDE]
        between = list(pipeline.between)
        driver = None if from_topic else driver_of(self.configuration)
        if driver is not None:
            given = driver.outputs(self.configuration)
            lacking = [name for name in pipeline.inputs if name not in (*BESIDE, *given)]
            if lacking:
                raise SettingsError(
                    f"pipeline.source: '{settings.source}' gives {given[0]}, and the estimators "
                    f'take {lacking[0]}; {_REMEDIES.get(given[0], _NO_REMEDY)}'
                )
            between += given
        live = live_chain(pipeline, self.configuration)
        if live is not None:
            self.show(lambda: {'compiled': live.taken})
        self.connect(
            live or pipeline.chain,
            inputs=inputs,
            outputs=(*pipeline.outputs, *between),
            on_demand=between,
            optional=AIDING if self._needs_compass(pipeline) else BESIDE,
        )
        if pipeline.pedometer is not None and pipeline.steps is not None:
            pedometer.resume(self, pipeline.pedometer, pipeline.steps)
        if driver is not None:
            self.driver = driver(self, self.configuration)
        if pipeline.gravity is not None:
            gravity_removal.serve(self, pipeline.gravity)
        if pipeline.integrator is not None:
            integrator.serve(self, pipeline.integrator)
        if pipeline.navigator is not None:
            inertial_navigator.serve(self, pipeline.navigator)
        if pipeline.pedometer is not None and pipeline.step_odometry is not None:
            # ~/calibrate is a Trigger here already: the driver's and the integrator's.
            pedometer.serve(
                self, pipeline.pedometer, pipeline.step_odometry, calibrate='pedometer/calibrate'
            )
        if live is not None:  # last: its thread ends with the node
            load(self, live)

    def _needs_compass(self, pipeline: Pipeline) -> bool:
        return (
            pipeline.pedometer is not None
            and self.configuration[PedometerSettings].heading == 'compass'
        )

    def _ending(self, settings: PipelineSettings) -> list[Stage]:
        """Return the stages for `pipeline.log_csv` and `pipeline.duration`, if asked for."""
        stages: list[Stage] = []
        if settings.log_csv:
            log = OdometryLog(Path(settings.log_csv).expanduser())
            self.at_end(log.close)
            stages.append(log.stage())
        if settings.duration > 0.0:
            stages.append(stop_after(settings.duration, self.finish))
        return stages


NODE = PipelineNode
