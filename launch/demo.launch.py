"""Slide the simulated accelerometer from A to B; topic odom tells where it thinks it is."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource


def generate_launch_description() -> LaunchDescription:
    """Describe the nodes on the simulated slide."""
    launch_file = Path(__file__).absolute().with_name('dead_reckoning.launch.py')
    return LaunchDescription(
        [
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(launch_file)),
                launch_arguments={'source': 'simulated', 'motion': 'slide'}.items(),
            ),
        ]
    )
