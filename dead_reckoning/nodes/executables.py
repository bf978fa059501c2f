"""The executables of `ros2 run`: each runs the node of the module of its name.

Nothing slow is imported here, so that `run` hears signals from the first moment on.
"""

from __future__ import annotations

from dead_reckoning.nodes.run import run


def accelerometer_driver() -> int:
    """Run the node `accelerometer_driver`."""
    return run('accelerometer_driver')


def compass_driver() -> int:
    """Run the node `compass_driver`."""
    return run('compass_driver')


def gravity_removal() -> int:
    """Run the node `gravity_removal`."""
    return run('gravity_removal')


def inertial_navigator() -> int:
    """Run the node `inertial_navigator`."""
    return run('inertial_navigator')


def integrator() -> int:
    """Run the node `integrator`."""
    return run('integrator')


def pedometer() -> int:
    """Run the node `pedometer`."""
    return run('pedometer')


def pipeline() -> int:
    """Run the node `pipeline`."""
    return run('pipeline')
