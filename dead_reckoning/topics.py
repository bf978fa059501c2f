"""The topics by name: message type, bytes to samples and back, one by one and in blocks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from dead_reckoning import block_wire, wire
from dead_reckoning.core import stages
from dead_reckoning.core.common import FrameSettings


@dataclass(frozen=True)
class Topic:
    """How one topic is spoken; ``decode`` is None where nothing of this package reads it."""

    type: str
    encode: Callable[[Any], bytes] | None = None
    """None where nothing of this package writes it."""
    decode: Callable[[bytes], Any] | None = None
    encode_block: Callable[[Any], list[bytes]] | None = None
    """Of what comes in blocks, the messages of one."""
    latched: bool = False
    source: str = ''
    """Who publishes it, for those who miss it; empty where nobody does."""


def topics(frames: FrameSettings) -> dict[str, Topic]:
    """Return all topics of samples and states, by relative name."""
    imu = Topic(
        'sensor_msgs/msg/Imu',
        wire.encode_imu,
        wire.decode_imu,
        block_wire.encode_imus,
        source='the driver of the sensor',
    )
    odometry = Topic(
        'nav_msgs/msg/Odometry',
        wire.odometry_encoder(frames.world, frames.body),
        wire.decode_odometry,
        block_wire.odometries_encoder(frames.world, frames.body),
    )
    number = Topic('std_msgs/msg/Float64', wire.encode_float64, wire.decode_float64, latched=True)
    pose = Topic(
        'geometry_msgs/msg/PoseWithCovarianceStamped',
        decode=wire.decode_pose_with_covariance,
        source='whatever measures the pose',
    )
    return {
        stages.RAW: imu,
        stages.IMU: replace(imu, source='gravity_removal, or a driver that knows its attitude'),
        stages.COMPASS: replace(imu, source='compass_driver'),
        stages.ACCELERATION: Topic(
            'geometry_msgs/msg/AccelWithCovarianceStamped',
            wire.encode_acceleration,
            wire.decode_acceleration,
            block_wire.encode_accelerations,
            source='gravity_removal',
        ),
        stages.ODOMETRY: replace(odometry, source='inertial_navigator'),
        stages.GROUND_TRUTH: replace(odometry, source='the simulated accelerometer_driver'),
        stages.AN3397: replace(odometry, source='accelerometer_driver with such a board'),
        stages.SMOOTHED: odometry,
        stages.PATH: Topic('nav_msgs/msg/Path', wire.path_encoder(frames.world), latched=True),
        stages.AIDING_TWIST: Topic(
            'geometry_msgs/msg/TwistWithCovarianceStamped',
            decode=wire.decode_twist,
            source='whatever measures velocity',
        ),
        stages.AIDING_ODOMETRY: Topic(
            'nav_msgs/msg/Odometry',
            decode=wire.decode_odometry_twist,
            source='wheels, or whatever gives odometry',
        ),
        stages.AIDING_POSE: pose,
        stages.SET_POSE: replace(pose, source=''),  # it comes once, and silence is no fault
        stages.STATIONARY: Topic('std_msgs/msg/Bool', wire.encode_bool, latched=True),
        stages.STATISTIC: replace(number, latched=False),
        stages.THRESHOLD: replace(number, latched=False),
        stages.STEPS: Topic(
            'std_msgs/msg/UInt32', wire.encode_uint32, wire.decode_uint32, latched=True
        ),
        stages.DISTANCE: number,
        stages.STEP_LENGTH: number,
        stages.CADENCE: number,
        stages.STEP_ODOMETRY: odometry,
    }
