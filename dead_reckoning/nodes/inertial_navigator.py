"""Node `inertial_navigator`: Odometry from an Imu with a gyro, corrected at each rest."""

from __future__ import annotations

from dead_reckoning.configuration import NAVIGATOR
from dead_reckoning.core.chain import Chain
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.navigator_stage import kept, load_kernels, navigator_stage
from dead_reckoning.core.stages import (
    AIDING,
    BESIDE,
    STATISTIC,
    THRESHOLD,
    navigator_inputs,
    navigator_outputs,
)
from dead_reckoning.nodes import compiling
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.transforms import mountings


class InertialNavigatorNode(ChainNode):
    """Take an Imu, `compass/data` and what aids it, publish `odom` and `stationary`."""

    def __init__(self) -> None:
        super().__init__('inertial_navigator', NAVIGATOR)
        settings = self.configuration[NavigatorSettings]
        own = [self.configuration[part] for part in settings.detector_parts]
        prepare(self)
        navigator = InertialNavigator(settings, self.common, *own)
        at = mountings(self, self.frames)
        self.connect(
            Chain([navigator_stage(navigator, at, frames=self.frames)]),
            inputs=navigator_inputs(settings),
            outputs=(*navigator_outputs(settings), STATISTIC, THRESHOLD),
            on_demand=(STATISTIC, THRESHOLD),
            optional=BESIDE,
        )
        serve(self, navigator)


def prepare(node: ChainNode) -> None:
    """Load what an inertial navigator needs; raises `StoppedError` for a signal meanwhile."""
    settings = node.configuration[NavigatorSettings]
    own = [node.configuration[part] for part in settings.detector_parts]
    compiling.prepare(node, kept, load_kernels, settings, node.common, *own)


def serve(node: ChainNode, navigator: InertialNavigator) -> None:
    """Give a node the services, figures and changeable parameters of an inertial navigator."""

    def reset() -> str:
        navigator.reset()
        return 'looking for rest, to align and begin at the origin'

    node.offer('reset', reset)
    node.offer('level', navigator.level)
    node.follow(navigator.settings, navigator.configure)
    node.show(lambda: figures(navigator))


def figures(navigator: InertialNavigator) -> dict[str, object]:
    """Return what /diagnostics shows of an inertial navigator."""
    of_rate, of_force = navigator.biases
    return {
        'aligned': navigator.aligned or 'not yet',
        'gyro_bias': ', '.join(f'{bias:.5f}' for bias in of_rate),
        'accelerometer_bias': ', '.join(f'{bias:.3f}' for bias in of_force),
        'stationary': 'yes' if navigator.stationary else 'no',
        'statistic': f'{navigator.statistic:.4g}',
        'threshold': f'{navigator.threshold:.4g}',
        'strides': navigator.strides.count,
        'distance': f'{navigator.strides.distance:.2f}',
        **navigator.counts,
        **{f'{name.replace("/", "_")}_dropped': navigator.dropped[name] for name in AIDING},
    }


NODE = InertialNavigatorNode
