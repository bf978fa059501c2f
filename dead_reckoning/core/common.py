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
    """Names of the frames (REP-105)."""

    world: str = parameter('odom', 'World frame: ENU, z up, continuous')
    body: str = parameter('base_link', 'Body frame: x forward, y left, z up')
    sensor: str = parameter('imu_link', "Frame of the driver's own sensor")
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
