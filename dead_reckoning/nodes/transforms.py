"""Broadcast world → body, where tf2_ros is installed."""

from __future__ import annotations

from collections.abc import Callable

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node

from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import DependencyError
from dead_reckoning.core.samples import NANOSECONDS, NavigationState


def transform_sender(node: Node, frames: FrameSettings) -> Callable[[NavigationState], None]:
    """Return a function that broadcasts a state as a transform.

    Raises `DependencyError` where tf2_ros is not installed.
    """
    try:
        from tf2_ros import TransformBroadcaster
    except ImportError as error:
        raise DependencyError(
            'frames.publish_tf is true, and tf2_ros is not installed: install '
            'ros-jazzy-tf2-ros-py, or set frames.publish_tf to false'
        ) from error
    broadcaster = TransformBroadcaster(node)

    def send(state: NavigationState) -> None:
        transform = TransformStamped(child_frame_id=frames.body)
        transform.header.frame_id = frames.world
        sec, nanosec = divmod(state.stamp_ns, NANOSECONDS)
        transform.header.stamp.sec, transform.header.stamp.nanosec = sec, nanosec
        moved, turned = transform.transform.translation, transform.transform.rotation
        moved.x, moved.y, moved.z = state.position
        turned.x, turned.y, turned.z, turned.w = state.attitude
        broadcaster.sendTransform(transform)

    return send
