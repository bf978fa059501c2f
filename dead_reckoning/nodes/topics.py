"""The topics by name: message type, quality of service, bytes to samples and back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
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
    """How one topic is spoken; ``decode`` is None where nothing of this package listens."""

    message: Any
    encode: Callable[[Any], bytes]
    decode: Callable[[bytes], Any] | None = None
    latched: bool = False


def topics(frames: FrameSettings) -> dict[str, Topic]:
    """Return all topics of samples and states, by relative name."""
    encode_odometry = wire.odometry_encoder(frames.world, frames.body)
    imu = Topic(Imu, wire.encode_imu, wire.decode_imu)
    odometry = Topic(Odometry, encode_odometry, wire.decode_odometry)
    number = Topic(Float64, wire.encode_float64, wire.decode_float64, latched=True)
    return {
        stages.RAW: imu,
        stages.IMU: imu,
        stages.COMPASS: imu,
        stages.ACCELERATION: Topic(
            AccelWithCovarianceStamped, wire.encode_acceleration, wire.decode_acceleration
        ),
        stages.ODOMETRY: odometry,
        stages.GROUND_TRUTH: odometry,
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
