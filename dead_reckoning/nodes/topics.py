"""The topics by name: message type, quality of service, bytes to samples and back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from geometry_msgs.msg import AccelWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy
from sensor_msgs.msg import Imu
from std_msgs.msg import Bool, Float64, UInt32

from dead_reckoning.core import stages
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.nodes import wire

DEPTH = 100
"""Queue of publishers and subscriptions: what a hiccup of a tenth of a second at 1 kHz needs."""


@dataclass(frozen=True)
class Topic:
    """How one topic is spoken; ``decode`` is None where nothing of this package reads it."""

    message: Any
    encode: Callable[[Any], bytes]
    decode: Callable[[bytes], Any] | None = None
    latched: bool = False
    source: str = ''
    """Who publishes it, for those who miss it; empty where nobody does."""


def topics(frames: FrameSettings) -> dict[str, Topic]:
    """Return all topics of samples and states, by relative name."""
    encode_odometry = wire.odometry_encoder(frames.world, frames.body)
    imu = Topic(Imu, wire.encode_imu, wire.decode_imu, source='the driver of the sensor')
    odometry = Topic(Odometry, encode_odometry, wire.decode_odometry)
    number = Topic(Float64, wire.encode_float64, wire.decode_float64, latched=True)
    return {
        stages.RAW: imu,
        stages.IMU: replace(imu, source='gravity_removal, or a driver that knows its attitude'),
        stages.COMPASS: replace(imu, source='compass_driver'),
        stages.ACCELERATION: Topic(
            AccelWithCovarianceStamped,
            wire.encode_acceleration,
            wire.decode_acceleration,
            source='gravity_removal',
        ),
        stages.ODOMETRY: odometry,
        stages.GROUND_TRUTH: replace(odometry, source='the simulated accelerometer_driver'),
        stages.STATIONARY: Topic(Bool, wire.encode_bool, latched=True),
        stages.STEPS: Topic(UInt32, wire.encode_uint32, wire.decode_uint32, latched=True),
        stages.DISTANCE: number,
        stages.STEP_LENGTH: number,
        stages.CADENCE: number,
        stages.STEP_ODOMETRY: odometry,
    }


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
