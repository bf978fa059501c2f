"""The two ends of a node under test, each a process of its own.

``python -m benchmarks.traffic publish TOPIC`` publishes an Imu for each line ``RATE SECONDS`` on
its standard input as often and as long as that says, and answers with the stamps [ns] as JSON.
``… listen`` takes in `odom`; it answers a line ``COUNT`` once so many came since the last answer,
or none for a while, with pairs of the stamp and the time of arrival.  Stamps are times of
publishing, by the monotonic clock, which all processes share.
"""

from __future__ import annotations

import json
import select
import sys
import time
from dataclasses import replace
from struct import Struct

import rclpy
from nav_msgs.msg import Odometry
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Imu

from benchmarks.feeder import sample
from dead_reckoning.core.samples import IDENTITY_QUATERNION, NANOSECONDS
from dead_reckoning.core.stages import ODOMETRY
from dead_reckoning.wire import encode_imu

QOS = QoSProfile(depth=5000)
"""Reliable, and deep enough for seconds: what gets lost was too much, no hiccup."""

QUIET = 1.0
"""So long [s] nothing comes before the listener takes it that no more will."""

SWING = 2.0
"""Half of this time [s] the sensor swings, half of it it rests."""

PAUSE = 0.0002
"""Shortest sleep [s] of the publisher; what falls due meanwhile goes out in one go."""

_STAMP = Struct('<iI')


def publish(topic: str) -> None:
    """Publish as often as asked for."""
    publisher = rclpy.create_node('publisher').create_publisher(Imu, topic, QOS)
    while not publisher.get_subscription_count():
        time.sleep(0.01)
    for line in sys.stdin:
        rate, seconds = map(float, line.split())
        stamps: list[int] = []
        start = time.monotonic()
        while (elapsed := time.monotonic() - start) < seconds:
            # Where the rate is too high for it, it never catches up.
            while elapsed < seconds and len(stamps) < elapsed * rate:
                stamp_ns = time.monotonic_ns()
                imu = sample(stamp_ns, len(stamps) / rate, SWING)
                data = encode_imu(replace(imu, orientation=IDENTITY_QUATERNION))
                publisher.publish(data)
                stamps.append(stamp_ns)
                if len(stamps) % 1000 == 0:
                    elapsed = time.monotonic() - start
            time.sleep(max(PAUSE, len(stamps) / rate - (time.monotonic() - start)))
        print(json.dumps(stamps), flush=True)


def listen() -> None:
    """Take in what comes."""
    node = rclpy.create_node('listener')
    came: list[tuple[int, int]] = []

    def take(data: bytes) -> None:
        sec, nanosec = _STAMP.unpack_from(data, 4)
        came.append((sec * NANOSECONDS + nanosec, time.monotonic_ns()))

    node.create_subscription(Odometry, ODOMETRY, take, QOS, raw=True)
    executor = EventsExecutor()
    executor.add_node(node)
    print('ready', flush=True)
    while True:
        if not select.select([sys.stdin], [], [], 0.0)[0]:
            executor.spin_once(timeout_sec=0.02)
            continue
        line = sys.stdin.readline()
        if not line:
            break
        asked_ns = time.monotonic_ns()
        while len(came) < int(line):
            last_ns = max(came[-1][1], asked_ns) if came else asked_ns
            if time.monotonic_ns() - last_ns > QUIET * NANOSECONDS:
                break
            executor.spin_once(timeout_sec=0.02)
        print(json.dumps(came), flush=True)
        came.clear()
    executor.shutdown()


def main() -> int:
    """Run one of the two until the standard input ends."""
    rclpy.init()
    try:
        if sys.argv[1] == 'publish':
            publish(sys.argv[2])
        else:
            listen()
    except ExternalShutdownException:
        pass
    finally:
        rclpy.try_shutdown()
    return 0


if __name__ == '__main__':
    sys.exit(main())
