"""The launch files: their arguments and nodes, and a real launch until odometry comes out."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
LAUNCH = ROOT / 'launch'
NODES = ('accelerometer_driver', 'gravity_removal', 'integrator', 'pedometer')
PATIENCE = 30.0

pytest.importorskip(
    'launch_ros', reason='launch_ros is not installed: it comes with ROS 2, not with its wheels'
)

from launch import LaunchContext  # noqa: E402
from launch.actions import DeclareLaunchArgument, OpaqueFunction  # noqa: E402
from launch.launch_description_sources import PythonLaunchDescriptionSource  # noqa: E402

RUN = """
import sys
from launch import LaunchDescription, LaunchService
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource

source = PythonLaunchDescriptionSource(sys.argv[1])
arguments = [argument.split(':=') for argument in sys.argv[2:]]
service = LaunchService()
service.include_launch_description(
    LaunchDescription([IncludeLaunchDescription(source, launch_arguments=arguments)])
)
sys.exit(service.run())
"""


def describe(name):
    source = PythonLaunchDescriptionSource(str(LAUNCH / name))
    return source.get_launch_description(LaunchContext())


def nodes(**arguments):
    """Return the nodes that dead_reckoning.launch.py starts, given these arguments."""
    context = LaunchContext()
    context.launch_configurations.update(arguments)
    started = []
    for entity in describe('dead_reckoning.launch.py').entities:
        if isinstance(entity, DeclareLaunchArgument):
            entity.visit(context)
        elif isinstance(entity, OpaqueFunction):
            started += entity.visit(context)
    return started


def test_arguments_and_their_defaults():
    declared = describe('dead_reckoning.launch.py').get_launch_arguments()
    assert {a.name: ''.join(part.text for part in a.default_value) for a in declared} == {
        'config': 'mma7260qt.yaml',
        'source': '',
        'motion': '',
        'namespace': '',
        'use_sim_time': '',
        'rviz': 'false',
    }
    assert all(argument.description for argument in declared)


def test_the_nodes_are_those_of_the_package():
    assert [(node.node_package, node.node_executable) for node in nodes()] == [
        ('dead_reckoning', name) for name in NODES
    ]


def test_a_preset_of_the_inertial_navigator_starts_it_instead(tmp_path):
    def started(**arguments):
        return [node.node_executable for node in nodes(**arguments)]

    for preset in ('foot_mounted.yaml', 'inertial.yaml'):
        assert started(config=preset) == ['inertial_navigator']
    simulated = started(config='foot_mounted.yaml', source='simulated')
    assert simulated == ['accelerometer_driver', 'inertial_navigator']
    own = tmp_path / 'own.yaml'
    own.write_text(
        '/**: {ros__parameters: {driver.source: serial,'
        ' pipeline.estimators: [pedometer, inertial_navigator]}}'
    )
    expected = ['accelerometer_driver', 'pedometer', 'inertial_navigator']
    assert started(config=str(own)) == expected
    assert started(config='robot_localization.yaml') == list(NODES)


def test_a_preset_that_only_counts_steps_starts_the_pedometer_alone():
    assert [node.node_executable for node in nodes(config='pedestrian.yaml')] == ['pedometer']
    for argument, value in (('source', 'simulated'), ('motion', 'walk')):
        started = nodes(config='pedestrian.yaml', **{argument: value})
        assert [node.node_executable for node in started] == ['accelerometer_driver', 'pedometer']
    assert [node.node_executable for node in nodes(config='an900.yaml')] == list(NODES)


def test_rviz_starts_only_if_asked():
    assert [node.node_executable for node in nodes(rviz='true')] == [*NODES, 'rviz2']


@pytest.mark.parametrize(
    ('argument', 'value', 'said'),
    [
        ('source', 'carrier pigeon', 'simulated'),
        ('motion', 'waltz', 'slide'),
        ('use_sim_time', 'perhaps', 'true'),
        ('config', 'no/such.yaml', 'mma7260qt.yaml'),
    ],
)
def test_a_wrong_argument_names_what_is_allowed(argument, value, said):
    with pytest.raises(RuntimeError) as error:
        nodes(**{argument: value})
    assert argument in str(error.value)
    assert value in str(error.value)
    assert said in str(error.value)


@pytest.fixture
def installation(tmp_path):
    """What `ros2 launch` finds the executables by, without a build."""
    index = tmp_path / 'share/ament_index/resource_index/packages'
    index.mkdir(parents=True)
    (index / 'dead_reckoning').touch()
    library = tmp_path / 'lib/dead_reckoning'
    library.mkdir(parents=True)
    for name in NODES:
        path = library / name
        path.write_text(
            f'#!/bin/sh\nexec "{sys.executable}" -m dead_reckoning.nodes {name} "$@"\n'
        )
        path.chmod(0o755)
    return tmp_path


@pytest.fixture
def launched(installation, domain_id):
    """Start launch files; end them as Ctrl-C does, and see that nothing stays behind."""
    environment = dict(
        os.environ,
        AMENT_PREFIX_PATH=os.pathsep.join(
            filter(None, (str(installation), os.environ.get('AMENT_PREFIX_PATH')))
        ),
        PYTHONPATH=os.pathsep.join(filter(None, (str(ROOT), os.environ.get('PYTHONPATH')))),
        ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST',
        ROS_DOMAIN_ID=str(domain_id),
        ROS_LOG_DIR=str(installation / 'log'),
    )
    started = []

    def launch(name, *arguments):
        command = [sys.executable, '-c', RUN, str(LAUNCH / name), *arguments]
        started.append(subprocess.Popen(command, env=environment, start_new_session=True))

    yield launch
    for process in started:
        os.killpg(process.pid, signal.SIGINT)
        try:
            status = process.wait(PATIENCE)
        finally:
            left = group_lives(process.pid)
            if left:
                os.killpg(process.pid, signal.SIGKILL)
        assert status == 0
        assert not left


def group_lives(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def first_odometry(domain, topic, wanted):
    from nav_msgs.msg import Odometry

    return first(domain, Odometry, topic, wanted)


def first(domain, kind, topic, wanted):
    """Return the first message on a topic that is as wanted."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.qos import qos_profile_sensor_data

    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    try:
        node = rclpy.create_node('listener', context=context)
        seen = []
        node.create_subscription(kind, topic, seen.append, qos_profile_sensor_data)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.5)
            if seen and wanted(seen[-1]):
                return seen[-1]
        pytest.fail(f'{topic}: {len(seen)} messages within {PATIENCE} s, none as wanted')
    finally:
        rclpy.try_shutdown(context=context)


def test_dead_reckoning_launch_publishes_odometry_in_its_namespace(launched, domain_id):
    launched('dead_reckoning.launch.py', 'namespace:=robot1', 'motion:=rest')
    message = first_odometry(domain_id, '/robot1/odom', lambda message: True)
    assert (message.header.frame_id, message.child_frame_id) == ('odom', 'base_link')


def test_pedestrian_launch_counts_the_steps_of_a_simulated_walk(launched, domain_id):
    from std_msgs.msg import UInt32

    launched('dead_reckoning.launch.py', 'config:=pedestrian.yaml', 'motion:=walk')
    assert first(domain_id, UInt32, 'pedometer/steps', lambda message: message.data >= 10)


def test_demo_launch_arrives_at_half_a_metre(launched, domain_id):
    launched('demo.launch.py')
    arrived = first_odometry(domain_id, '/odom', lambda m: m.pose.pose.position.x > 0.45)
    assert arrived.pose.pose.position.x < 0.6
