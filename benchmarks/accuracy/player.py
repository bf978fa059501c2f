"""Publish messages of a recording with their own stamps, faster than it was made.

``python -m benchmarks.accuracy.player RECORDING NAME=TOPIC… --speed S --subscribers N`` waits
until N subscriptions of each name have matched, plays, waits until all is acknowledged, and prints
how many messages of the first name it published.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import rclpy
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import Imu

from benchmarks.accuracy.played import played
from dead_reckoning.core.errors import DeadReckoningError, RecordingError
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import AIDING_ODOMETRY, IMU

DEADLINE = 30.0
"""How long [s] subscribers may take to come, or to acknowledge."""

PAUSE = 0.5
"""Time [s] about the first message of a name, by which others neither overtake it nor it them: a
navigator keeps what it takes from its first aiding on."""

MESSAGES = {IMU: Imu, AIDING_ODOMETRY: Odometry}


def play(path: Path, topics: dict[str, str], speed: float, subscribers: int) -> int:
    """Publish a recording; return the number of messages of the first name."""
    messages = played(path, topics)
    node = rclpy.create_node('player')
    # The whole recording fits into the queue: a subscriber that falls behind loses nothing.
    qos = QoSProfile(depth=max(1, len(messages)))
    publishers = {name: node.create_publisher(MESSAGES[name], name, qos) for name in topics}
    deadline = time.monotonic() + DEADLINE
    for name, publisher in publishers.items():
        while publisher.get_subscription_count() < subscribers:
            if time.monotonic() > deadline:
                raise RecordingError(f'{publisher.get_subscription_count()} subscribers of {name}')
            time.sleep(0.01)
    start, counts = time.monotonic(), dict.fromkeys(topics, 0)
    for time_ns, name, data in messages:
        due = start + (time_ns - messages[0][0]) / NANOSECONDS / speed
        first = not counts[name] and len(topics) > 1
        time.sleep(max(PAUSE if first else 0.0, due - time.monotonic()))
        publishers[name].publish(data)
        counts[name] += 1
        if first:
            time.sleep(PAUSE)
            start += 2.0 * PAUSE
    for publisher in publishers.values():
        if not publisher.wait_for_all_acked(Duration(seconds=DEADLINE)):
            raise RecordingError('subscribers did not acknowledge all messages')
    return next(iter(counts.values()))


def main() -> int:
    """Run the player."""
    parser = argparse.ArgumentParser()
    parser.add_argument('path', type=Path)
    parser.add_argument('topics', nargs='+', metavar='NAME=TOPIC')
    parser.add_argument('--speed', type=float, required=True)
    parser.add_argument('--subscribers', type=int, required=True)
    arguments = parser.parse_args(remove_ros_args(sys.argv)[1:])
    rclpy.init()
    try:
        topics = dict(text.split('=') for text in arguments.topics)
        print(play(arguments.path, topics, arguments.speed, arguments.subscribers))
    except DeadReckoningError as error:
        print(f'player: {error}', file=sys.stderr)
        return 1
    finally:
        rclpy.try_shutdown()
    return 0


if __name__ == '__main__':
    sys.exit(main())
