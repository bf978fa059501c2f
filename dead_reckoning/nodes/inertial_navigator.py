"""Node `inertial_navigator`: Odometry from an Imu with a gyro, corrected at each rest."""

from __future__ import annotations

from dead_reckoning.configuration import NAVIGATOR
from dead_reckoning.core.chain import Chain
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.navigator_stage import navigator_stage
from dead_reckoning.core.stages import COMPASS, ODOMETRY, STATIONARY, STATISTIC, THRESHOLD
from dead_reckoning.nodes import parameters
from dead_reckoning.nodes.chain_node import ChainNode
from dead_reckoning.nodes.transforms import mountings


class InertialNavigatorNode(ChainNode):
    """Take an Imu and `compass/data`, publish `odom` and `stationary`."""

    def __init__(self) -> None:
        super().__init__('inertial_navigator', NAVIGATOR)
        settings = self.configuration[NavigatorSettings]
        of_detector = self.configuration[settings.detector_part]
        navigator = InertialNavigator(settings, self.common, of_detector)
        self.connect(
            Chain([navigator_stage(navigator, mountings(self, self.frames))]),
            inputs=(settings.input, COMPASS),
            outputs=(ODOMETRY, STATIONARY, STATISTIC, THRESHOLD),
            on_demand=(STATISTIC, THRESHOLD),
            optional=(COMPASS,),
        )
        serve(self, navigator)


def serve(node: ChainNode, navigator: InertialNavigator) -> None:
    """Give a node the services, figures and changeable parameters of an inertial navigator."""

    def reset() -> str:
        navigator.reset()
        return 'looking for rest, to align and begin at the origin'

    node.offer('reset', reset)
    node.offer('level', navigator.level)
    parameters.follow_changes(node, navigator.settings, navigator.apply)
    node.show(lambda: figures(navigator))


def figures(navigator: InertialNavigator) -> dict[str, object]:
    """Return what /diagnostics shows of an inertial navigator."""
    return {
        'aligned': navigator.aligned or 'not yet',
        'stationary': 'yes' if navigator.stationary else 'no',
        'statistic': f'{navigator.statistic:.4g}',
        'threshold': f'{navigator.threshold:.4g}',
        'strides': navigator.strides.count,
        'path_length': f'{navigator.strides.path_length:.2f}',
        **navigator.counts,
    }


NODE = InertialNavigatorNode
