"""Settings of the gravity removal."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.core.rest import GRAVITY


@dataclass(frozen=True, kw_only=True)
class GravitySettings(Settings, prefix='gravity'):
    """How the gravity removal learns the attitude and the magnitude of gravity."""

    attitude: str = parameter(
        'rest',
        'Source of the attitude: message (the orientation of imu/data), rest (roll and pitch from '
        'the gravity vector at rest, held; yaw from compass/data, or 0) or estimate (gyro and '
        'gravity; yaw from compass/data, or free)',
        choices=('message', 'rest', 'estimate'),
    )
    magnitude: float = parameter(
        GRAVITY, 'Gravity, until it is measured at rest', unit='m/s²', minimum=9.7, maximum=9.9
    )
    measure: bool = parameter(
        True,
        'Take the magnitude of gravity from the first rest: a sensor may well rest at 1.008 g. '
        'With attitude: rest and estimate it is always measured',
    )
    rest_duration: float = parameter(
        0.5, 'How long the device must rest to be levelled', unit='s', minimum=0.05, maximum=60.0
    )
    rest_deviation: float = parameter(
        0.3,
        'Largest standard deviation of an axis that still counts as rest',
        unit='m/s²',
        minimum=1e-6,
        maximum=5.0,
    )
    compass_timeout: float = parameter(
        1.0,
        'How long the last yaw of compass/data is believed; after that its uncertainty grows, or, '
        'with attitude: estimate, the gyro alone carries it on',
        unit='s',
        minimum=0.01,
        maximum=3600.0,
    )
    tilt_time: float = parameter(
        4.0,
        'Time constant with which attitude: estimate takes the tilt from gravity: longer holds it '
        'better against accelerations, shorter against drift of the gyro',
        unit='s',
        minimum=0.1,
        maximum=1000.0,
    )
    compass_time: float = parameter(
        10.0,
        'Time constant with which the yaw of attitude: estimate follows compass/data',
        unit='s',
        minimum=0.01,
        maximum=10_000.0,
    )
    rest_rate: float = parameter(
        0.01,
        'Largest rate of turn beyond the known bias of the gyro that still counts as rest; '
        'attitude: estimate takes a slower turn for bias',
        unit='rad/s',
        minimum=1e-6,
        maximum=1.0,
    )
    rest_rate_deviation: float = parameter(
        0.02,
        'Largest standard deviation of an axis of the gyro that still counts as rest',
        unit='rad/s',
        minimum=1e-6,
        maximum=1.0,
    )
    rate_offset: float = parameter(
        0.1,
        'Largest bias that a gyro may show at the first rest',
        unit='rad/s',
        minimum=0.0,
        maximum=10.0,
    )
    rate_scale_deviation: float = parameter(
        0.005,
        "One sigma of the relative error of the gyro's sensitivity",
        minimum=0.0,
        maximum=1.0,
    )
    rate_walk: float = parameter(
        0.0001,
        'One sigma by which the bias of the gyro wanders in a second',
        unit='rad/s/√s',
        minimum=0.0,
        maximum=1.0,
    )
    max_gap: float = parameter(
        0.5,
        'Longest time between samples over which attitude: estimate integrates the gyro; over a '
        'longer one the attitude is held and its uncertainty grows',
        unit='s',
        minimum=0.001,
        maximum=60.0,
    )
