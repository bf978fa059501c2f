"""Node `pedometer`: steps, how long they are, and where they lead."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.parameter import Parameter as RosParameter

from dead_reckoning.configuration import PEDOMETER
from dead_reckoning.core import step_detectors
from dead_reckoning.core.chain import Chain
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.pedometer import (
    Pedometer,
    PedometerSettings,
    PedometerState,
    kept,
    load_kernels,
)
from dead_reckoning.core.stages import (
    COMPASS,
    PEDOMETER_OUTPUTS,
    TOTALS,
    StepOutputs,
    pedometer_inputs,
    pedometer_stage,
)
from dead_reckoning.core.step_odometry import StepOdometry
from dead_reckoning.nodes import compiling
from dead_reckoning.nodes.chain_node import STEADY, ChainNode
from dead_reckoning.nodes.totals_file import LONGEST_WAIT, TotalsFile
from dead_reckoning.nodes.transforms import mountings


class PedometerNode(ChainNode):
    """Take an Imu and `compass/data`, publish the totals on change and `pedometer/odom`."""

    def __init__(self) -> None:
        super().__init__('pedometer', PEDOMETER)
        settings = self.configuration[PedometerSettings]
        prepare(self)
        pedometer = Pedometer(settings, self.configuration[settings.method_part])
        odometry = StepOdometry(settings, self.common)
        says = StepOutputs(pedometer, odometry)
        self.connect(
            Chain([pedometer_stage(pedometer, odometry, mountings(self, self.frames), says)]),
            inputs=pedometer_inputs(settings),
            outputs=PEDOMETER_OUTPUTS,
            optional=() if settings.heading == 'compass' else (COMPASS,),
        )
        resume(self, pedometer, says)
        serve(self, pedometer, odometry, calibrate='calibrate')


def prepare(node: ChainNode) -> None:
    """Load what finds the steps; raises `StoppedError` for a signal meanwhile."""
    method = node.configuration[PedometerSettings].method
    if step_detectors.detector_class(method).KERNELS:
        compiling.prepare(node, kept, load_kernels, method)


def resume(node: ChainNode, pedometer: Pedometer, says: StepOutputs) -> None:
    """Let the totals of a connected node outlast it, where `pedometer.state_file` asks for it.

    Raises `SettingsError` where the file can't be kept.
    """
    if not pedometer.settings.state_file:
        return
    file = TotalsFile(pedometer.settings.state_file)
    node.at_end(file.close)
    if file.damage is not None:
        node.diagnostics.fault(file.damage)
    pedometer.resume(file.totals)
    says.keep = file.keep
    node.create_timer(LONGEST_WAIT, lambda: node.put_out(says.due()), clock=STEADY)
    node.watch(lambda: [] if (error := file.error) is None else [(str(file.path), error)])
    node.push(TOTALS, ())


def serve(
    node: ChainNode, pedometer: Pedometer, odometry: StepOdometry, *, calibrate: str
) -> None:
    """Give a node the services, figures and changeable parameters of a pedometer.

    ``calibrate`` names the service that calibrates the step length.
    """

    def say(text: str, states: Sequence[PedometerState] = ()) -> str:
        node.push(TOTALS, states)
        return text

    def start() -> str:
        pedometer.start()
        odometry.reset()
        return say('counting from zero')

    def stop() -> str:
        return say('stopped: the totals are held', pedometer.stop())

    def reset() -> str:
        pedometer.reset()
        odometry.reset()
        return say('steps and distance are zero')

    def calibrate_length(walking: bool) -> str:
        distance = pedometer.settings.calibration_distance
        if walking:
            pedometer.begin_calibration()
            return f'walk {distance:g} m, then call this with false'
        found = pedometer.end_calibration()
        (result,) = node.set_parameters([RosParameter('pedometer.k', value=found.k)])
        if not result.successful:
            raise SettingsError(result.reason)
        return (
            f'pedometer.k is {found.k:.4f} {pedometer.settings.model.UNIT}: {found.steps} steps '
            f'over {distance:g} m, {distance / found.steps:.3f} m each'
        )

    def configure(settings: PedometerSettings) -> None:
        pedometer.configure(settings)
        odometry.configure(settings)

    node.offer('start', start)
    node.offer('stop', stop)
    node.offer('reset', reset)
    node.offer_switch(calibrate, calibrate_length)
    node.follow(pedometer.settings, configure)
    method_settings = node.configuration[pedometer.settings.method_part]
    node.follow(method_settings, pedometer.configure_method)
    node.show(lambda: figures(pedometer))


def figures(pedometer: Pedometer) -> dict[str, object]:
    """Return what /diagnostics shows of a pedometer."""
    return {
        'steps': pedometer.steps,
        'distance': f'{pedometer.distance:.2f}',
        'counting': 'yes' if pedometer.running else 'stopped',
        'walking': 'yes' if pedometer.walking else 'no',
        'k': f'{pedometer.settings.k:.4f} {pedometer.settings.model.UNIT}',
    }


NODE = PedometerNode
