"""Start the driver of the accelerometer and the nodes that make a position and steps of it.

Where the configuration estimates by the inertial navigator, or counts steps on a topic and nothing
else, those of ``pipeline.estimators`` start instead, and the driver only where an argument or the
configuration names its source, or an argument its motion; then steps are counted on what it gives.
"""

from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from dead_reckoning.configuration import read_values
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.sources.driver_settings import DriverSettings

PACKAGE = 'dead_reckoning'
DRIVER, PEDOMETER, NAVIGATOR = 'accelerometer_driver', 'pedometer', 'inertial_navigator'
NODES = (DRIVER, 'gravity_removal', 'integrator', PEDOMETER)
SHARE = Path(__file__).absolute().parents[1]
RVIZ_CONFIG = SHARE / 'rviz' / 'dead_reckoning.rviz'
AS_CONFIGURED = 'empty: as the configuration says'


def generate_launch_description() -> LaunchDescription:
    """Describe the arguments and the nodes."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'config',
                default_value='mma7260qt.yaml',
                description="Parameter file: a path, or the name of one of the package's own",
            ),
            _declare_setting('source'),
            _declare_setting('motion'),
            DeclareLaunchArgument(
                'namespace', default_value='', description='Namespace of nodes and topics'
            ),
            DeclareLaunchArgument(
                'use_sim_time',
                default_value='',
                choices=['', 'true', 'false'],
                description=f'Take the time from /clock; {AS_CONFIGURED}',
            ),
            DeclareLaunchArgument(
                'rviz',
                default_value='false',
                choices=['true', 'false'],
                description='Show the odometry in RViz',
            ),
            OpaqueFunction(function=_nodes),
        ]
    )


def _declare_setting(name: str) -> DeclareLaunchArgument:
    """Declare an argument that replaces the driver's parameter of that name, if given."""
    setting = next(p for p in DriverSettings.parameters() if p.name == name)
    return DeclareLaunchArgument(
        name,
        default_value='',
        choices=['', *setting.choices],
        description=f'{setting.description}; {AS_CONFIGURED}',
    )


def _nodes(context: LaunchContext) -> list[Node]:
    def argument(name: str) -> str:
        return LaunchConfiguration(name).perform(context)

    given: dict[str, str | bool] = {}
    for name in ('source', 'motion'):
        if argument(name):
            given[f'driver.{name}'] = argument(name)
    if argument('use_sim_time'):
        given['use_sim_time'] = argument('use_sim_time') == 'true'
    config = _parameter_file(argument('config'))
    executables = _executables(config, driven=any(name.startswith('driver.') for name in given))
    if executables == [DRIVER, PEDOMETER]:
        given['pedometer.input'] = 'imu/data_raw'  # no other node makes imu/data of it
    nodes = [
        Node(
            package=PACKAGE,
            executable=name,
            namespace=argument('namespace'),
            parameters=[config, *([given] if given else [])],
            output='screen',
        )
        for name in executables
    ]
    if argument('rviz') == 'true':
        # Topics of the view are relative: it shows those of this namespace.
        nodes.append(
            Node(
                package='rviz2',
                executable='rviz2',
                namespace=argument('namespace'),
                arguments=['-d', str(RVIZ_CONFIG)],
            )
        )
    return nodes


def _executables(config: Path, driven: bool) -> list[str]:
    try:
        values = read_values(config)
    except SettingsError:  # one section for each node, say; what is wrong the nodes tell
        return list(NODES)
    estimators = list(values.get('pipeline.estimators', ()))
    counts_only = estimators == [PEDOMETER] and values.get('pipeline.source') == 'topic'
    if NAVIGATOR not in estimators and not counts_only:
        return list(NODES)
    return [*([DRIVER] if driven or 'driver.source' in values else []), *estimators]


def _parameter_file(config: str) -> Path:
    for path in (Path(config), SHARE / 'config' / config):
        if path.is_file():
            return path
    own = ', '.join(sorted(path.name for path in (SHARE / 'config').glob('*.yaml')))
    raise RuntimeError(f'config: no file {config!r}; give a path, or one of {own}')
