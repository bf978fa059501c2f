"""What rclpy adds to the topics: classes of messages, other encodings, quality of service."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import (
    AccelWithCovarianceStamped,
    PoseWithCovarianceStamped,
    TwistWithCovarianceStamped,
)
from nav_msgs.msg import Odometry, Path
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu
from std_msgs.msg import Bool, Float64, UInt32

from dead_reckoning.core.errors import EncodingError, WireError
from dead_reckoning.topics import Topic

DEPTH = 100
"""Queue of publishers and subscriptions: what a hiccup of a tenth of a second at 1 kHz needs."""

CLASSES = {
    'geometry_msgs/msg/AccelWithCovarianceStamped': AccelWithCovarianceStamped,
    'geometry_msgs/msg/PoseWithCovarianceStamped': PoseWithCovarianceStamped,
    'geometry_msgs/msg/TwistWithCovarianceStamped': TwistWithCovarianceStamped,
    'nav_msgs/msg/Odometry': Odometry,
    'nav_msgs/msg/Path': Path,
    'sensor_msgs/msg/Imu': Imu,
    'std_msgs/msg/Bool': Bool,
    'std_msgs/msg/Float64': Float64,
    'std_msgs/msg/UInt32': UInt32,
}


def message_class(topic: Topic) -> Any:
    """Return the class of a topic's messages."""
    return CLASSES[topic.type]


def decoder(topic: Topic) -> Callable[[bytes], Any]:
    """Return what reads the bytes of a topic; raises `WireError`.

    What is not little-endian CDR goes through rclpy's own serialization once.
    """
    decode, message_type = topic.decode, message_class(topic)
    assert decode is not None, f'nothing reads a {topic.type}'

    def read(data: bytes) -> Any:
        try:
            return decode(data)
        except EncodingError:
            return decode(_little_endian(data, message_type))

    return read


def _little_endian(data: bytes, message_type: Any) -> bytes:
    try:
        return bytes(serialize_message(deserialize_message(data, message_type)))
    except RuntimeError as problem:
        raise WireError(
            f'{len(data)} bytes are no {message_type.__name__}: {problem}'
        ) from problem


def publisher_qos(latched: bool) -> QoSProfile:
    """Publish reliably, so that reliable and best-effort subscribers both match."""
    if not latched:
        return QoSProfile(depth=DEPTH)
    return QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


def subscription_qos() -> QoSProfile:
    """Subscribe best-effort, so that every publisher matches."""
    return QoSProfile(
        depth=DEPTH,
        history=QoSHistoryPolicy.KEEP_LAST,
        reliability=QoSReliabilityPolicy.BEST_EFFORT,
    )
