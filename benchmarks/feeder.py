"""Publish `imu/data_raw` at a steady rate and count the `odom` that comes back.

``python -m benchmarks.feeder RATE LISTENERS`` waits until so many subscriptions have matched,
writes a line once it publishes, goes on until its standard input ends, and then writes how many
messages it sent, and how many came back since the first did.
"""

from __future__ import annotations

import select
import sys
import time
from math import pi, sin

import rclpy
from nav_msgs.msg import Odometry
from rclpy.experimental import EventsExecutor
from rclpy.qos import QoSProfile
from sensor_msgs.msg import Imu

from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS, ImuSample, Matrix
from dead_reckoning.core.stages import ODOMETRY, RAW
from dead_reckoning.wire import encode_imu

DEPTH = 1000
FORCE_NOISE: Matrix = (1e-4, 0.0, 0.0, 0.0, 1e-4, 0.0, 0.0, 0.0, 1e-4)
RATE_NOISE: Matrix = (1e-6, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 1e-6)
PERIOD = 10.0
"""Swings for one half of it [s], rests for the other."""


def sample(stamp_ns: int, elapsed: float, period: float = PERIOD) -> ImuSample:
    """Return the sample at a time: rest, then 2 Hz to and fro, as a walk shakes."""
    swinging = elapsed % period > 0.5 * period
    swing = sin(4.0 * pi * elapsed) if swinging else 0.0
    return ImuSample(
        stamp_ns,
        'imu_link',
        (swing, 0.0, GRAVITY + 2.0 * swing),
        FORCE_NOISE,
        (0.0, 0.0, 0.3 * swing),
        RATE_NOISE,
    )


def main() -> int:
    """Run the feeder."""
    rate, listeners = float(sys.argv[1]), int(sys.argv[2])
    rclpy.init()
    node = rclpy.create_node('feeder')
    publisher = node.create_publisher(Imu, RAW, QoSProfile(depth=DEPTH))
    received: list[int] = [0]

    def count(_: bytes) -> None:
        received[0] += 1

    node.create_subscription(Odometry, ODOMETRY, count, QoSProfile(depth=DEPTH), raw=True)
    executor = EventsExecutor()
    executor.add_node(node)
    while publisher.get_subscription_count() < listeners:
        executor.spin_once(timeout_sec=0.05)
    print('publishing', flush=True)
    start, start_ns = time.monotonic(), time.time_ns()
    taken = sent = before = 0
    while True:
        elapsed = time.monotonic() - start
        while taken < elapsed * rate:
            after = taken / rate
            publisher.publish(encode_imu(sample(start_ns + round(after * NANOSECONDS), after)))
            taken += 1
        if received[0] == 0:
            before = taken  # gravity removal still looks for rest
        sent = taken - before
        executor.spin_once(timeout_sec=0.0005)
        if taken % 100 == 0 and select.select([sys.stdin], [], [], 0.0)[0]:
            break
    deadline = time.monotonic() + 2.0
    while received[0] < sent and time.monotonic() < deadline:
        executor.spin_once(timeout_sec=0.05)
    print(sent, received[0], flush=True)
    executor.shutdown()
    rclpy.try_shutdown()
    return 0


if __name__ == '__main__':
    sys.exit(main())
