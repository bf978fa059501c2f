"""Broadcast world → body, and hear how sensors sit on the body, where tf2_ros is installed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.time import Time

from dead_reckoning.core.checks import require_vector
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import DependencyError, MissingMountingError
from dead_reckoning.core.mounting import Mounting, Mountings, mountings_of
from dead_reckoning.core.rotation import normalized
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


def mountings(node: Node, frames: FrameSettings) -> Mountings:
    """Return how sensors sit on the body, as `frames.mounting` says.

    Raises `DependencyError` where that is TF, and tf2_ros is not installed.
    """
    if frames.mounting == 'tf':
        say = node.get_logger().info
        return MountingsFromTransforms(frames.body, static_transforms(node, frames.body), say)
    return mountings_of(frames)


class MountingsFromTransforms:
    """Ask for the mounting of each sensor until it is there, and then no more: it sits.

    ``look_up`` returns the transform from a frame to the body, and raises `LookupError`, with the
    reason, while there is none; ``say`` takes a sentence for the user.
    """

    def __init__(
        self,
        body: str,
        look_up: Callable[[str], TransformStamped],
        say: Callable[[str], object],
    ) -> None:
        self._body = body
        self._look_up = look_up
        self._say = say
        self._found: dict[str, Mounting] = {}

    def __call__(self, frame_id: str) -> Mounting:
        """Return the mounting of a sensor.

        Raises `MissingMountingError` while there is none, and `NotFiniteError` while its lever arm
        is none.
        """
        found = self._found.get(frame_id)
        if found is not None:
            return found
        try:
            transform = self._look_up(frame_id)
        except LookupError as error:
            raise MissingMountingError(
                f'waiting on /tf_static for how {frame_id!r} sits on {self._body!r} ({error}): '
                'start robot_state_publisher or static_transform_publisher, or set '
                'frames.mounting to parameters'
            ) from error
        found = mounting_from(transform)
        require_vector(
            found.translation, f'lever arm of {frame_id}', 'see who publishes it on /tf_static'
        )
        self._found[frame_id] = found
        x, y, z = found.translation
        self._say(f'{frame_id} sits on {self._body} at ({x:g}, {y:g}, {z:g}) m, as TF says')
        return found


def static_transforms(node: Node, body: str) -> Callable[[str], TransformStamped]:
    """Listen to /tf_static; return a function that looks up the transform from a frame to a body.

    That one raises `LookupError`, with tf2's reason, while there is none.  Raises
    `DependencyError` where tf2_ros is not installed.
    """
    try:
        from tf2_msgs.msg import TFMessage
        from tf2_ros import Buffer, TransformException
    except ImportError as error:
        raise DependencyError(
            'frames.mounting is tf, and tf2_ros is not installed: install '
            'ros-jazzy-tf2-ros-py, or set frames.mounting to parameters'
        ) from error
    buffer = Buffer()

    def take(message: Any) -> None:
        for transform in message.transforms:
            buffer.set_transform_static(transform, 'dead_reckoning')

    # tf2_ros' own listener would take the whole of /tf as well.
    latched = QoSProfile(depth=100, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(TFMessage, '/tf_static', take, latched)

    def look_up(frame_id: str) -> TransformStamped:
        try:
            return buffer.lookup_transform(body, frame_id, Time())
        except TransformException as error:
            raise LookupError(f'tf2: {str(error).strip(" .")}') from error

    return look_up


def mounting_from(transform: TransformStamped) -> Mounting:
    """Read a transform from the sensor to the body, as tf2 looks it up."""
    moved, turned = transform.transform.translation, transform.transform.rotation
    return Mounting(
        normalized((turned.x, turned.y, turned.z, turned.w)), (moved.x, moved.y, moved.z)
    )
