"""Settings that every node shares: executor, frames, and what to assume where input is silent."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Settings, parameter


@dataclass(frozen=True, kw_only=True)
class CommonSettings(Settings, prefix='common'):
    """What all nodes share."""

    executor: str = parameter(
        'events',
        'Executor of the node: rclpy.experimental.EventsExecutor, or the SingleThreadedExecutor, '
        'which costs several times as much per message',
        choices=('events', 'single'),
    )
    attitude_deviation: float = parameter(
        0.0175,
        'One sigma of an attitude that comes without a covariance, or is held from rest; '
        '1° of tilt is 0.171 m/s² of gravity taken for motion',
        unit='rad',
        minimum=0.0,
        maximum=3.2,
    )
    noise_deviation: float = parameter(
        0.05,
        'One sigma of the noise of a specific force that comes without a covariance',
        unit='m/s²',
        minimum=0.0,
    )
    rate_deviation: float = parameter(
        0.005,
        'One sigma of the noise of an angular velocity that comes without a covariance',
        unit='rad/s',
        minimum=0.0,
        maximum=10.0,
    )
    turn_deviation: float = parameter(
        0.2,
        'One sigma of the rate at which the device may turn while nothing measures it: without a '
        'gyro, with a compass that fell silent, or over a gap',
        unit='rad/s',
        minimum=0.0,
        maximum=100.0,
    )
    input_timeout: float = parameter(
        3.0,
        'How long an input that brought messages may bring none, or /clock stand, before that is '
        'said on /diagnostics; by the clock on the wall',
        unit='s',
        minimum=0.1,
        maximum=3600.0,
    )
    service_timeout: float = parameter(
        20.0,
        'How long a service that needs samples waits for them before it answers that they lack',
        unit='s',
        minimum=0.1,
        maximum=3600.0,
    )


@dataclass(frozen=True, kw_only=True)
class FrameSettings(Settings, prefix='frames'):
    """Names of the frames (REP-105), and how the sensor sits on the body."""

    world: str = parameter('odom', 'World frame: ENU, z up, continuous')
    body: str = parameter('base_link', 'Body frame: x forward, y left, z up')
    sensor: str = parameter('imu_link', "Frame of the driver's own sensor")
    mounting: str = parameter(
        'parameters',
        'Where it is known from how the sensor sits on the body: parameters (the next two) or tf '
        '(the static transform from the frame_id of each Imu to frames.body; needs tf2_ros)',
        choices=('parameters', 'tf'),
    )
    mounting_rotation: tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.0),
        'Roll, pitch and yaw of the sensor in the body, in this order about the fixed axes of '
        'the body, as static_transform_publisher takes them',
        unit='rad', minimum=-6.3, maximum=6.3, length=3,
    )  # fmt: skip
    mounting_translation: tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.0), 'Where the sensor sits in the body, its lever arm', unit='m',
        minimum=-1000.0, maximum=1000.0, length=3,
    )  # fmt: skip
    publish_tf: bool = parameter(
        False, 'Broadcast world → body; a stack has one broadcaster of it, so this is off'
    )

    def validate(self) -> None:
        """Raise `SettingsError` where a name is empty or two frames are one."""
        for key, value in self.values().items():
            if value == '':
                raise SettingsError(f'{key}: an empty frame name; give a name such as odom')
        if self.world == self.body:
            raise SettingsError(
                f'frames.body: {self.body!r} is the world frame too; use another name'
            )
