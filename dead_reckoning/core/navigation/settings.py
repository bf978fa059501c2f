"""Settings of the inertial navigator."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.core import stationarity
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.parameters import Settings, parameter


@dataclass(frozen=True, kw_only=True)
class NavigatorSettings(Settings, prefix='navigator'):
    """How the inertial navigator aligns, what it believes, and when it holds the body for resting.

    The defaults are those of a sensor on a foot.  docs/navigation.md gives the reason of each, and
    what half and twice of it cost on recordings.
    """

    input: str = parameter(
        'imu/data_raw',
        'Topic of its Imu, with an angular velocity: imu/data for a device that has only that; '
        'its orientation is not used',
        choices=('imu/data_raw', 'imu/data'),
    )
    rest_duration: float = parameter(
        0.5, 'How long the device must rest to be aligned', unit='s', minimum=0.05, maximum=60.0
    )
    rest_deviation: float = parameter(
        0.3,
        'Largest standard deviation of an axis of the accelerometer that still counts as rest',
        unit='m/s²',
        minimum=1e-6,
        maximum=5.0,
    )
    rest_rate_deviation: float = parameter(
        0.02,
        'Largest standard deviation of an axis of the gyro that still counts as rest',
        unit='rad/s',
        minimum=1e-6,
        maximum=1.0,
    )
    max_gap: float = parameter(
        0.5,
        'Longest time between samples that is integrated; over a longer one position and attitude '
        'are held, the velocity is forgotten, and uncertainty grows',
        unit='s',
        minimum=0.001,
        maximum=60.0,
    )
    gap_speed: float = parameter(
        2.0, 'One sigma of the speed that a gap may hide', unit='m/s', minimum=0.0, maximum=1000.0
    )
    force_range: float = parameter(
        0.0,
        'Full scale of the accelerometer: a sample that reaches it may hide as much again; 0: '
        'not known',
        unit='m/s²',
        minimum=0.0,
    )
    rate_range: float = parameter(
        0.0,
        'Full scale of the gyro: a sample that reaches it may hide as much again; 0: not known',
        unit='rad/s',
        minimum=0.0,
    )
    averaging: float = parameter(
        1.0,
        'A sample is the mean over so much of the time since the one before: 1 after a filter '
        'that goes with the rate, as most sensors have, or where samples were averaged; 0 for '
        'values of an instant',
        minimum=0.0,
        maximum=3.0,
    )
    acceleration_noise: float = parameter(
        0.12,
        'Noise of the acceleration: errors of scale, of alignment and of timing over a swing of '
        '20 to 50 m/s², which are far more than the noise of the sensor',
        unit='m/s²/√Hz',
        minimum=1e-6,
        maximum=100.0,
    )
    sampling_noise: float = parameter(
        0.15,
        'What a change of the force between two samples may hide, as part of its integral: '
        'impacts',
        minimum=0.0,
        maximum=10.0,
    )
    rate_noise: float = parameter(
        3e-4, 'Noise of the gyro', unit='rad/s/√Hz', minimum=1e-9, maximum=1.0
    )
    rate_scale: float = parameter(
        0.0,
        'Noise of the gyro that grows with the rate: the share of it by which scale and axes are '
        'wrong, times the root of twice the time for which a turn keeps its way',
        unit='√s',
        minimum=0.0,
        maximum=1.0,
    )
    rate_walk: float = parameter(
        5e-5,
        'One sigma by which the bias of the gyro wanders in a second',
        unit='rad/s/√s',
        minimum=0.0,
        maximum=1.0,
    )
    acceleration_walk: float = parameter(
        1e-3,
        'One sigma by which the bias of the accelerometer wanders in a second',
        unit='m/s²/√s',
        minimum=0.0,
        maximum=10.0,
    )
    rate_bias: float = parameter(
        0.0035,
        'One sigma of the bias of the gyro when it is switched on, calibrated: 0.2 °/s',
        unit='rad/s',
        minimum=0.0,
        maximum=1.0,
    )
    acceleration_bias: float = parameter(
        0.5,
        'One sigma of the bias of the accelerometer, which at rest can not be told from a tilt; 0 '
        'leaves the bias out',
        unit='m/s²',
        minimum=0.0,
        maximum=10.0,
    )
    zero_velocity: bool = parameter(
        True, 'Take the velocity for zero while the detector finds rest', mutable=True
    )
    stance_velocity: float = parameter(
        0.01,
        'One sigma of the velocity of a foot that stands',
        unit='m/s',
        minimum=1e-6,
        maximum=100.0,
    )
    pivot: float = parameter(
        0.1,
        'One sigma of where the point lies about which a standing foot turns',
        unit='m',
        minimum=0.0,
        maximum=10.0,
    )
    height: float = parameter(
        0.08,
        'How high the sensor sits above that point, on the instep',
        unit='m',
        minimum=0.0,
        maximum=10.0,
    )
    correlation: float = parameter(
        0.15,
        'How long the error of the velocity at rest stays the same: half a stance, so that one '
        'stance counts as two measurements, whatever the rate of the samples',
        unit='s',
        minimum=1e-4,
        maximum=1000.0,
    )
    gate: float = parameter(
        50.0,
        'Largest NIS of a velocity or a rate, of three degrees of freedom, that is believed; far '
        'above 3, as it is there for blunders only',
        minimum=1.0,
    )
    patience: float = parameter(
        0.1,
        'After so long a rest that is not believed it is believed all the same; long for a '
        'vehicle, whose steady drive looks like rest',
        unit='s',
        minimum=0.0,
        maximum=1e6,
    )
    axis_gate: float = parameter(
        11.0,
        'Largest NIS of what is measured along one axis, yaw or slip of wheels, that is believed: '
        '3.3 sigma',
        minimum=1.0,
    )
    zero_rate: bool = parameter(
        True, 'Learn the bias of the gyro while it is still in a rest', mutable=True
    )
    still_window: float = parameter(
        0.4,
        'Over how long the gyro must be still to learn its bias: shorter than the rests of people '
        'who are about to walk, longer than the middle of a stance',
        unit='s',
        minimum=0.05,
        maximum=60.0,
    )
    still_deviation: float = parameter(
        0.0049,
        'Largest standard deviation of the rate over that time, beyond what the sensor shows at '
        'its stillest: 0.28 °/s, between the sway of a resting foot and a stance in a walk',
        unit='rad/s',
        minimum=0.0,
        maximum=1.0,
    )
    still_noise: float = parameter(
        0.0087,
        "Largest standard deviation that is taken for the sensor's own: 0.5 °/s",
        unit='rad/s',
        minimum=0.0,
        maximum=1.0,
    )
    sway: float = parameter(
        7e-4,
        'One sigma of the angle of a resting foot: 0.04°',
        unit='rad',
        minimum=1e-6,
        maximum=1.0,
    )
    floor: bool = parameter(
        True,
        'Hold stances for being as high as the one before where they nearly are',
        mutable=True,
    )
    floor_deviation: float = parameter(
        0.01,
        'One sigma of the height of stances on one floor',
        unit='m',
        minimum=1e-4,
        maximum=1.0,
    )
    floor_gate: float = parameter(
        0.01,
        'Stances are on one floor if their heights differ by less than this and floor_slope of '
        'the stride; else a new floor begins',
        unit='m',
        minimum=0.0,
        maximum=10.0,
    )
    floor_slope: float = parameter(
        0.025,
        'Part of the stride that adds to floor_gate: between the errors of level walking and a '
        'ramp of 5 %',
        minimum=0.0,
        maximum=1.0,
    )
    compass: bool = parameter(True, 'Take the yaw of a compass, where there is one', mutable=True)
    compass_timeout: float = parameter(
        1.0,
        'How old the yaw of a compass may be at the alignment, and after how long its silence is '
        'said',
        unit='s',
        minimum=0.01,
        maximum=3600.0,
    )
    compass_correlation: float = parameter(
        60.0,
        'How long what a compass is wrong by stays the same: iron on the way',
        unit='s',
        minimum=0.0,
        maximum=1e6,
    )
    gravity_direction: bool = parameter(
        False,
        'Take the body for held, so that it never gets fast: its velocity then shows where down '
        'is. Not for a vehicle or a body that is carried far',
        mutable=True,
    )
    held_velocity: float = parameter(
        1.0, 'One sigma of the velocity of a held body', unit='m/s', minimum=1e-3, maximum=100.0
    )
    held_time: float = parameter(
        1.0, 'How long that velocity stays the same', unit='s', minimum=1e-4, maximum=1000.0
    )
    nonholonomic: bool = parameter(
        False,
        'Take the body for a vehicle whose axle moves neither sideways nor up; needs axes of the '
        'body, x forward (frames.mounting_rotation)',
        mutable=True,
    )
    slip: float = parameter(
        0.1,
        'One sigma of the velocity of the axle sideways and up',
        unit='m/s',
        minimum=1e-6,
        maximum=100.0,
    )
    slip_angle: float = parameter(
        0.01,
        'One sigma of the angle by which an axle slips, or the sensor is mounted askew',
        unit='rad',
        minimum=0.0,
        maximum=1.0,
    )
    slip_time: float = parameter(
        1.0, 'How long a slip stays the same', unit='s', minimum=1e-4, maximum=1000.0
    )
    axle: tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.0),
        'Where the axle that is not steered is, seen from the sensor, in the axes of the body',
        unit='m', minimum=-1000.0, maximum=1000.0, length=3,
    )  # fmt: skip
    smoothing: bool = parameter(
        False,
        'Smooth the way since the last stance once the foot has left the next one, and publish it '
        'as odom_smoothed and path',
    )
    aiding_twist: bool = parameter(
        True, 'Take the velocities of aiding/twist, where there are any', mutable=True
    )
    aiding_odom: bool = parameter(
        True, 'Take the velocities of aiding/odom, where there are any', mutable=True
    )
    aiding_pose: bool = parameter(
        True, 'Take the poses of aiding/pose, where there are any', mutable=True
    )
    aiding_gate: float = parameter(
        16.3,
        'Largest NIS of a velocity or a position from elsewhere, of three degrees of freedom, '
        'that is believed: one in a thousand is beyond',
        minimum=1.0,
    )
    aiding_patience: float = parameter(
        5.0,
        'After so long a time in which all of them are refused they are believed: then the filter '
        'is wrong, not they',
        unit='s',
        minimum=0.0,
        maximum=1e6,
    )
    aiding_angle: float = parameter(
        0.0,
        'One sigma of the angle by which the axes of what measures a velocity are askew to those '
        'of the sensor; it adds to the covariance of the message',
        unit='rad',
        minimum=0.0,
        maximum=1.0,
    )
    aiding_correlation: float = parameter(
        0.0,
        'How long what such a measurement is wrong by stays the same, as the slip of wheels: the '
        'more there are in that time, the less each counts',
        unit='s',
        minimum=0.0,
        maximum=1e6,
    )
    aiding_delay: float = parameter(
        0.5,
        'How old a measurement may be: it is taken at its stamp, as the states since are kept',
        unit='s',
        minimum=0.0,
        maximum=10.0,
    )
    twist_lever_arm: tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.0),
        'Where on the body that moves of which aiding/twist, in the world or the body frame, '
        'gives the velocity, as the antenna of a GNSS; axes of the body',
        unit='m', minimum=-1000.0, maximum=1000.0, length=3,
    )  # fmt: skip
    pose_lever_arm: tuple[float, float, float] = parameter(
        (0.0, 0.0, 0.0),
        'Where on the body that is of which aiding/pose gives the position; axes of the body',
        unit='m', minimum=-1000.0, maximum=1000.0, length=3,
    )  # fmt: skip
    detector: tuple[str, ...] = parameter(
        ('shoe',),
        'What finds rest: shoe (generalised likelihood ratio), angular_rate (its energy), '
        'acceleration_variance, magnitude (of the force), movement_end (the count of AN3397); '
        'several of them vote',
        choices=stationarity.names(),
    )
    votes: int = parameter(
        0, 'So many detectors make a rest; 0: all of them', minimum=0, maximum=100
    )
    window: float = parameter(
        0.05, 'Over how long a detector looks', unit='s', minimum=0.0, maximum=10.0
    )
    minimum: float = parameter(
        0.02,
        'How long a rest is at least, as far as look_ahead reaches',
        unit='s',
        minimum=0.0,
        maximum=10.0,
    )
    look_ahead: float = parameter(
        0.045,
        'How far a detector may look ahead, and what comes out may be late: half the window and '
        'the shortest rest. With 0 rests are found later',
        unit='s',
        minimum=0.0,
        maximum=10.0,
    )
    hysteresis: float = parameter(
        1.0, 'So many times the threshold ends a rest', minimum=1.0, maximum=100.0
    )
    memory: float = parameter(
        2.0,
        'Over how long the threshold follows the swings of the gait: the longest stride',
        unit='s',
        minimum=0.0,
        maximum=60.0,
    )
    rest_factor: float = parameter(
        1.5,
        'So many times what a detector showed of the rest that the navigator aligned at is rest '
        'still, which noise hardly reaches',
        minimum=1.0,
        maximum=100.0,
    )

    @property
    def detector_parts(self) -> tuple[type[Settings], ...]:
        """The classes of the detectors' own settings, in order."""
        return tuple(stationarity.detector_class(name).Settings for name in self.detector)

    def validate(self) -> None:
        """Raise `SettingsError` where more votes are asked for than there are."""
        if self.votes > len(self.detector):
            raise SettingsError(
                f'navigator.votes: {self.votes} of {len(self.detector)} detectors; name more in '
                'navigator.detector, or ask for fewer'
            )
