"""Publish the Imu of a recording on ``imu/data`` with its own stamps, faster than it was made.

``python -m benchmarks.accuracy.player RECORDING --topic T --speed S --subscribers N`` waits until
N subscriptions have matched, plays, waits until all is acknowledged, and prints how many messages
it published.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import rclpy
from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import Imu

from dead_reckoning.core.errors import DeadReckoningError, RecordingError
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import IMU
from dead_reckoning.sources.bags import read_imu
from dead_reckoning.wire import encode_imu

DEADLINE = 30.0
"""How long [s] subscribers may take to come, or to acknowledge."""


def play(path: Path, topic: str, speed: float, subscribers: int) -> int:
    """Publish a recording; return the number of messages."""
    samples = list(read_imu(path, topic))
    node = rclpy.create_node('player')
    # The whole recording fits into the queue: a subscriber that falls behind loses nothing.
    publisher = node.create_publisher(Imu, IMU, QoSProfile(depth=max(1, len(samples))))
    deadline = time.monotonic() + DEADLINE
    while publisher.get_subscription_count() < subscribers:
        if time.monotonic() > deadline:
            raise RecordingError(f'{publisher.get_subscription_count()} subscribers of {IMU}')
        time.sleep(0.01)
    start = time.monotonic()
    for sample in samples:
        due = start + (sample.stamp_ns - samples[0].stamp_ns) / NANOSECONDS / speed
        time.sleep(max(0.0, due - time.monotonic()))
        publisher.publish(encode_imu(sample))
    if not publisher.wait_for_all_acked(Duration(seconds=DEADLINE)):
        raise RecordingError('subscribers did not acknowledge all messages')
    return len(samples)


def main() -> int:
    """Run the player."""
    parser = argparse.ArgumentParser()
    parser.add_argument('path', type=Path)
    parser.add_argument('--topic', required=True)
    parser.add_argument('--speed', type=float, required=True)
    parser.add_argument('--subscribers', type=int, required=True)
    arguments = parser.parse_args(remove_ros_args(sys.argv)[1:])
    rclpy.init()
    try:
        print(play(arguments.path, arguments.topic, arguments.speed, arguments.subscribers))
    except DeadReckoningError as error:
        print(f'player: {error}', file=sys.stderr)
        return 1
    finally:
        rclpy.try_shutdown()
    return 0


if __name__ == '__main__':
    sys.exit(main())
