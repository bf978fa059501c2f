"""The presets: which values the files of config/ choose, and what for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Preset:
    """A file of config/: what it is for, and the values that differ from the defaults.

    ``whole`` writes every parameter, else only those that differ.  ``other`` values are another
    choice, which the words explain: they stand below the first as comments.
    """

    name: str
    words: str
    values: Mapping[str, Any]
    whole: bool = False
    other: Mapping[str, Any] = field(default_factory=dict)


PRESETS = (
    Preset(
        'mma7260qt',
        'The default: an MMA7260QT at ±1.5 g behind a 12-bit ADC, simulated. Every parameter of '
        'every node is here with its default; what is commented out follows from other values.',
        {},
        whole=True,
    ),
    Preset(
        'an3397',
        'Freescale AN3397: an MMA7260QT at ±1.5 g behind an 8-bit ADC, moved about in the plane; '
        '64 conversions a sample, a window of ±3 counts of 16.1 mg, 25 quiet samples that end the '
        'movement of an axis. As comments its other choice, "±2 sample steps for an average of '
        '16 samples".',
        {
            'driver.motion': 'square',
            'driver.sensor': 'mma7260qt',
            'driver.range_g': 1.5,
            'driver.adc_bits': 8,
            'driver.samples_per_message': 64,
            'driver.calibration_samples': 1024,
            'integrator.method': 'trapezoid',
            'integrator.axes': ['x', 'y'],
            'integrator.window_minimum': -0.474,
            'integrator.window_maximum': 0.474,
            'integrator.movement_end': 'each',
            'integrator.movement_end_samples': 25,
        },
        other={
            'driver.samples_per_message': 16,
            'integrator.window_minimum': -0.316,
            'integrator.window_maximum': 0.316,
        },
    ),
    Preset(
        'an3397_board',
        'The board of Freescale AN3397, which integrates itself: positions on an3397/odom, of '
        'accelerometer_driver only (docs/devices/an3397.md). Neither the baud rate nor the last '
        'byte is in the document; nor is the way of a unit, which is best measured.',
        {
            'driver.source': 'serial',
            'driver.sensor': 'mma7260qt',
            'driver.range_g': 1.5,
            'driver.adc_bits': 8,
            'driver.serial.port': '/dev/ttyUSB0',
            'driver.serial.baud': 9_600,
            'driver.serial.protocol': 'an3397',
            'driver.serial.an3397.counts_per_unit': 64,
            'driver.serial.an3397.end_of_frame': 254,
        },
    ),
    Preset(
        'mbed',
        'The mbed tutorial "Dead Reckoning": an ADXL345 at ±16 g and 3200 Hz, averaged to 100 Hz, '
        'distance along the heading of a compass, logged for 15 s. Run `pipeline` and '
        '`compass_driver` with it; a vehicle of the simulator drives them in curves. '
        'adxl345.yaml is for the real sensors.',
        {
            'driver.motion': 'vehicle',
            'driver.sensor': 'adxl345',
            'driver.range_g': 16.0,
            'driver.sample_rate': 3200.0,
            'driver.samples_per_message': 32,
            'driver.noise': 5.66,  # the sheet's count at 100 Hz, and √32 of it at 3200 Hz
            'driver.vehicle.length': 6.0,
            'driver.vehicle.width': 3.0,
            'driver.vehicle.loops': 1,
            'driver.vehicle.loop_time': 9.0,
            'driver.vehicle.pause': 0.7,
            'gravity.attitude': 'rest',
            'integrator.method': 'trapezoid',
            'integrator.axes': ['x'],
            'integrator.window_minimum': -0.12,
            'integrator.window_maximum': 0.12,
            'pipeline.source': 'simulated',
            'pipeline.log_csv': 'results.csv',
            'pipeline.duration': 15.0,
        },
    ),
    Preset(
        'adxl345',
        'A real ADXL345 on an I²C bus, at ±16 g and 100 Hz, with an HMC6352 compass beside it: '
        'run `pipeline` and `compass_driver` with it (docs/devices/adxl345.md). As comments: the '
        'sensor where a driver of the Linux kernel has it.',
        {
            'driver.source': 'i2c',
            'driver.sensor': 'adxl345',
            'driver.range_g': 16.0,
            'driver.i2c.bus': 1,
            'driver.i2c.address': 0x53,
            'driver.i2c.rate': 100.0,
            'compass.source': 'hmc6352',
            'compass.hmc6352.bus': 1,
            'gravity.attitude': 'rest',
            'integrator.axes': ['x'],
            'pipeline.source': 'i2c',
        },
        other={'driver.source': 'iio', 'pipeline.source': 'iio'},
    ),
    Preset(
        'an900',
        'The pedometer of Analog Devices AN-900: an ADXL330 worn with its y axis up, 30 messages '
        'a second of four conversions each, steps counted on x and y; simulated, on a walk. A '
        'device that stands upright has no level rest to find its zero-g offsets in.',
        {
            'driver.motion': 'walk',
            'driver.sensor': 'adxl330',
            'driver.sample_rate': 120.0,
            'driver.samples_per_message': 4,
            'driver.calibrate_on_start': False,
            'driver.walk.roll': 1.5708,
            'pedometer.method': 'an900',
            'pedometer.axes': ('x', 'y'),
            'pedometer.length_model': 'an900_equation2',
            'pipeline.estimators': ('pedometer',),
        },
    ),
    Preset(
        'zstar',
        'A Freescale ZSTAR (RD3152MMA7260Q), polled through its USB stick: 8 bits at ±1.5 g, '
        '16.1 mg a count, three of them the window as in AN3397 (docs/devices/zstar.md). Another '
        'range goes into both range_g.',
        {
            'driver.source': 'serial',
            'driver.sensor': 'mma7260qt',
            'driver.range_g': 1.5,
            'driver.adc_bits': 8,
            'driver.calibration_samples': 256,
            'driver.serial.port': '/dev/ttyACM0',
            'driver.serial.protocol': 'zstar',
            'driver.serial.zstar.range_g': 1.5,
            'driver.serial.zstar.poll_rate': 50.0,
            'integrator.window_minimum': -0.474,
            'integrator.window_maximum': 0.474,
            'pipeline.source': 'serial',
        },
    ),
    Preset(
        'zstar3',
        'A Freescale ZSTAR3, polled through its USB stick: 16 bits at ±1.5 g. A count is finer '
        'than the noise of the sensor, 0.058 m/s², three of which are the window '
        '(docs/devices/zstar.md). Another range goes into both range_g. As comments the order of '
        'the bytes and the sign that were not chosen; neither is confirmed.',
        {
            'driver.source': 'serial',
            'driver.sensor': 'mma7260qt',
            'driver.range_g': 1.5,
            'driver.adc_bits': 16,
            'driver.calibration_samples': 256,
            'driver.serial.port': '/dev/ttyACM0',
            'driver.serial.protocol': 'zstar3',
            'driver.serial.zstar3.range_g': 1.5,
            'driver.serial.zstar3.poll_rate': 50.0,
            'driver.serial.zstar3.byte_order': 'big',
            'driver.serial.zstar3.signed': True,
            'integrator.window_minimum': -0.173,
            'integrator.window_maximum': 0.173,
            'pipeline.source': 'serial',
        },
        other={
            'driver.serial.zstar3.byte_order': 'little',
            'driver.serial.zstar3.signed': False,
        },
    ),
    Preset(
        'witilt3',
        'A SparkFun WiTilt v3 over Bluetooth: 10 bits at ±1.5 g, 4.0 mg a count, three of them '
        'the window as in AN3397 (docs/devices/witilt3.md). Another range goes into both range_g. '
        'As a comment: the speed of older boards.',
        {
            'driver.source': 'serial',
            'driver.sensor': 'mma7260qt',
            'driver.range_g': 1.5,
            'driver.adc_bits': 10,
            'driver.serial.port': '/dev/rfcomm0',
            'driver.serial.baud': 115_200,
            'driver.serial.protocol': 'witilt3',
            'driver.serial.witilt3.range_g': 1.5,
            'driver.serial.witilt3.channels': 'xyzr',
            'integrator.window_minimum': -0.119,
            'integrator.window_maximum': 0.119,
            'pipeline.source': 'serial',
        },
        other={'driver.serial.baud': 57_600},
    ),
    Preset(
        'hex',
        'A board with an MMA7260QT at ±1.5 g and 10 bits that sends lines AAAAXXXYYYZZZ: 4.0 mg a '
        'count, three of them the window as in AN3397 (docs/devices/hex.md).',
        {
            'driver.source': 'serial',
            'driver.sensor': 'mma7260qt',
            'driver.range_g': 1.5,
            'driver.adc_bits': 10,
            'driver.serial.port': '/dev/ttyUSB0',
            'driver.serial.baud': 115_200,
            'driver.serial.protocol': 'hex',
            'integrator.window_minimum': -0.119,
            'integrator.window_maximum': 0.119,
            'pipeline.source': 'serial',
        },
    ),
    Preset(
        'wockets',
        'An MIT Wocket, an MMA7260QT at 10 bits worn somewhere on the body, over Bluetooth; its '
        'range is not confirmed (docs/devices/wockets.md). Counts steps.',
        {
            'driver.source': 'serial',
            'driver.sensor': 'mma7260qt',
            'driver.range_g': 4.0,
            'driver.adc_bits': 10,
            'driver.serial.port': '/dev/rfcomm0',
            'driver.serial.protocol': 'wockets',
            'pedometer.method': 'rhythm',
            'pipeline.source': 'serial',
            'pipeline.estimators': ['pedometer'],
        },
    ),
    Preset(
        'pedestrian',
        'Who walks with an IMU, anywhere on the body: a phone in a hand, a pocket or a bag, a '
        'sensor on a belt, a watch. Run `pedometer` or `pipeline` with it, or replay a recording. '
        'Where the Imu has an orientation, its yaw is the heading, unless a compass is heard; '
        'without either steps and distance come all the same. As a comment: what points ahead is '
        'y, as of a phone that is held in front, not x (docs/pedometer.md).',
        {
            'gravity.attitude': 'message',
            'pedometer.method': 'rhythm',
            'pedometer.input': 'imu/data',
            'pedometer.heading': 'any',
            'pedometer.heading_offset': 0.0,
            'pipeline.source': 'topic',
            'pipeline.estimators': ['pedometer'],
        },
        other={'pedometer.heading_offset': 1.5708},
    ),
    Preset(
        'foot_mounted',
        'An IMU with a gyro on a foot, walking or running: run `pipeline` or `inertial_navigator` '
        'with it, or replay a recording. Rest a second or two at the start, and at the end. What '
        'is not here are the defaults, which are those of a foot (docs/navigation.md).',
        {
            'navigator.input': 'imu/data_raw',
            'navigator.detector': ['shoe'],
            'navigator.look_ahead': 0.045,
            'navigator.floor': True,
            'pipeline.source': 'topic',
            'pipeline.estimators': ['inertial_navigator'],
        },
    ),
    Preset(
        'inertial',
        'Any IMU with a gyro, held or mounted: run `pipeline` or `inertial_navigator` with it, or '
        'replay a recording. The attitude is what it knows; that the body is never fast for long '
        'points to the vertical, and keeps the position near where it is. Not for a vehicle at a '
        'steady speed (docs/navigation.md).',
        {
            'navigator.input': 'imu/data_raw',
            'navigator.acceleration_noise': 0.06,
            'navigator.rate_scale': 1.5e-3,
            'navigator.rate_walk': 5e-4,
            'navigator.rate_bias': 0.0087,
            'navigator.acceleration_bias': 0.03,
            'navigator.pivot': 0.0,
            'navigator.height': 0.0,
            'navigator.floor': False,
            'navigator.zero_velocity': False,
            'navigator.gravity_direction': True,
            'navigator.held_velocity': 0.4,
            'navigator.look_ahead': 0.0,
            'pipeline.source': 'topic',
            'pipeline.estimators': ['inertial_navigator'],
        },
    ),
    Preset(
        'vehicle',
        'A wheeled robot or a car with an IMU and a gyro: run `pipeline` or `inertial_navigator` '
        'with it, or replay a recording. Its wheels roll along x, and it stops now and then; what '
        'measures its speed or place, aiding/odom, aiding/twist, aiding/pose, bounds what drifts '
        '(docs/aiding.md). Rest a second or two at the start.',
        {
            'navigator.input': 'imu/data_raw',
            'navigator.acceleration_bias': 0.1,
            'navigator.pivot': 0.0,
            'navigator.height': 0.0,
            'navigator.patience': 1e6,
            'navigator.floor': False,
            'navigator.nonholonomic': True,
            'navigator.axle': [0.0, 0.0, 0.0],
            'navigator.rate_scale': 0.01,
            'navigator.aiding_angle': 0.02,
            'navigator.aiding_correlation': 0.5,
            'navigator.window': 0.3,
            'navigator.minimum': 0.15,
            'navigator.look_ahead': 0.3,
            'navigator.shoe.least': 0.01,
            'navigator.shoe.share': 0.0,
            'pipeline.source': 'topic',
            'pipeline.estimators': ['inertial_navigator'],
            'frames.mounting': 'parameters',
            'frames.mounting_rotation': [0.0, 0.0, 0.0],
            'frames.mounting_translation': [0.0, 0.0, 0.0],
        },
    ),
    Preset(
        'imu6dof4',
        'A SparkFun IMU 6DOF v4 on a serial port: an MMA7260Q behind 10 bits, its gyroscopes '
        'carry the attitude that takes gravity off. Run `pipeline` with it; the range is that '
        'chosen in the menu of the board (docs/devices/imu6dof4.md).',
        {
            'driver.source': 'serial',
            'driver.sensor': 'mma7260qt',
            'driver.range_g': 1.5,
            'driver.adc_bits': 10,
            'driver.sample_rate': 100.0,
            'driver.gyro.range': 5.24,  # 300 °/s
            'driver.gyro.noise': 0.0017,
            'driver.gyro.resolution': 0.017,  # a count
            'driver.serial.port': '/dev/ttyUSB0',
            'driver.serial.baud': 115_200,
            'driver.serial.protocol': 'imu6dof4',
            'gravity.attitude': 'estimate',
            'integrator.method': 'kalman',
            'integrator.window_minimum': -0.2,
            'integrator.window_maximum': 0.2,  # five counts: 3.4 times the noise of one reading
            'pipeline.source': 'serial',
        },
    ),
    Preset(
        'um7',
        'A CH Robotics UM7 on a serial port, as in the note "Using Accelerometers to Estimate '
        'Position and Velocity": its own attitude takes gravity off, the rest is integrated '
        'twice. Run `pipeline` with it; what the UM7 must send is in docs/devices/um7.md.',
        {
            'driver.source': 'serial',
            'driver.sensor': 'um7',
            'driver.sample_rate': 100.0,
            'driver.serial.port': '/dev/ttyUSB0',
            'driver.serial.baud': 115_200,
            'driver.serial.protocol': 'um7',
            'gravity.attitude': 'message',
            'integrator.method': 'euler',
            'pipeline.source': 'serial',
        },
    ),
    Preset(
        'robot_localization',
        'A robot with an IMU and a gyro, for robot_localization: run `pipeline` with it; its '
        'filter fuses the twist of odom and is the one that broadcasts odom → base_link '
        '(docs/robot_localization.md). As a comment: how the IMU sits on base_link, from TF.',
        {
            'gravity.attitude': 'estimate',
            'integrator.method': 'kalman',
            'pipeline.source': 'topic',
            'pipeline.estimators': ['integrator'],
            'frames.world': 'odom',
            'frames.body': 'base_link',
            'frames.mounting': 'parameters',
            'frames.mounting_rotation': [0.0, 0.0, 0.0],
            'frames.mounting_translation': [0.0, 0.0, 0.0],
            'frames.publish_tf': False,
        },
        other={'frames.mounting': 'tf'},
    ),
)


def values_of(name: str) -> Mapping[str, Any]:
    """Return the values that a preset chooses."""
    return next(preset.values for preset in PRESETS if preset.name == name)
