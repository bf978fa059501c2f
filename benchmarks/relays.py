"""Hand each Imu on as an Odometry and compute nothing: what any rclpy node pays at least.

``python -m benchmarks.relays typed``: messages in, messages out, `SingleThreadedExecutor`, as the
tutorials have it.  ``… lean``: bytes in, the stamp patched into a prepared message, bytes out, and
the `EventsExecutor`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import rclpy
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from sensor_msgs.msg import Imu

from benchmarks.traffic import QOS
from dead_reckoning.core.samples import NavigationState
from dead_reckoning.core.stages import ODOMETRY, RAW
from dead_reckoning.wire import odometry_encoder

STAMP = slice(4, 12)
"""Where sec and nanosec stand in a serialized message with a header."""


def typed(node: Node) -> None:
    """Relay messages."""
    publisher = node.create_publisher(Odometry, ODOMETRY, QOS)

    def relay(imu: Imu) -> None:
        odometry = Odometry(child_frame_id='base_link')
        odometry.header.stamp = imu.header.stamp
        odometry.header.frame_id = 'odom'
        odometry.pose.pose.orientation = imu.orientation
        odometry.twist.twist.angular = imu.angular_velocity
        publisher.publish(odometry)

    node.create_subscription(Imu, RAW, relay, QOS)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    executor.spin()


def lean(node: Node) -> None:
    """Relay bytes."""
    publisher = node.create_publisher(Odometry, ODOMETRY, QOS)
    prepared = odometry_encoder('odom', 'base_link')(
        NavigationState(0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    )
    before, after = prepared[: STAMP.start], prepared[STAMP.stop :]

    def relay(imu: bytes) -> None:
        publisher.publish(before + imu[STAMP] + after)

    node.create_subscription(Imu, RAW, relay, QOS, raw=True)
    executor = EventsExecutor()
    executor.add_node(node)
    while rclpy.ok():
        executor.spin_once(timeout_sec=0.1)


RELAYS: dict[str, Callable[[Node], None]] = {'typed': typed, 'lean': lean}


def main() -> int:
    """Relay until told to stop."""
    rclpy.init()
    try:
        RELAYS[sys.argv[1]](rclpy.create_node('relay'))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()
    return 0


if __name__ == '__main__':
    sys.exit(main())
