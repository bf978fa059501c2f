"""A Clearpath Jackal: its Imu over DDS through the nodes, beside its wheels, and aided by them.

The recording is one of the tests of robot_localization (BSD-3-Clause, Charles River Analytics).
docs/accuracy.md says what each figure is, and how far the wheels can be trusted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import pictures
from benchmarks.accuracy.accounting import Live, account
from benchmarks.accuracy.aided import measure_aiding
from benchmarks.accuracy.drift import FREE, Drift, Pair, Truth, add_drift_table, drifts, every
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.signals import root_mean_square, rotations
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import matrix_from_quaternion, rotate_back
from dead_reckoning.core.samples import NANOSECONDS, ImuSample, NavigationState
from dead_reckoning.core.stages import ACCELERATION, IMU, ODOMETRY
from dead_reckoning.sources.bags import read_imu, read_odometry

Array = NDArray[np.float64]
Stamps = NDArray[np.int64]

NAME = 'Jackal'
PATTERN = 'robot_bags/jackal_*.bag'

TOPIC = '/imu/data'
WHEELS = '/jackal_velocity_controller/odom'

PARAMETERS = {'gravity.attitude': 'message', **FREE}

SPACING = 0.5
"""Distance [s] of the starts of free integration."""

STANDING = 0.02
"""Below this speed of its wheels [m/s] the robot stands."""


def measure(path: Path, output: Path) -> Report:
    """Play the recording through the nodes and compare."""
    from benchmarks.accuracy.live import play  # needs ROS, which other recordings do not

    samples = list(read_imu(path, TOPIC))
    wheels = Wheels(path)
    live = play(path, TOPIC, len(samples), PARAMETERS)
    report = Report(f'jackal-{path.stem}', f'Jackal, {path.stem}')
    account(report, len(samples), live)
    if not live.states or not live.accelerations:
        return report
    compare_with_direct(report, samples, live)

    by_stamp = {imu.stamp_ns: imu for imu in samples}
    pairs = [(own, by_stamp[own.stamp_ns]) for own in live.accelerations]
    truth = wheels.truth(pairs)
    known = np.flatnonzero(~np.isnan(truth.position[:, 0]))
    starts = every(SPACING, pairs, int(known[0]), int(known[-1]))
    settings = Configuration(PARAMETERS)
    integrator = Integrator(settings[IntegratorSettings], settings[CommonSettings])
    measured = {'against the wheels': drifts(pairs, truth, starts, integrator)}
    add_drift_table(
        report,
        f'drift of free integration: a start every {SPACING:g} s, with the velocity of the wheels',
        measured,
        {},
    )
    drive = Drive(live.states, wheels)
    _describe(report, drive)
    measure_aiding(report, path, TOPIC, WHEELS, samples)
    report.pictures.append(_draw(output / f'{report.name}.png', drive, truth, measured))
    return report


class Wheels:
    """The forward speed that the wheels tell, and what follows from it.

    Their yaw is of no use, as the robot skids when it turns; so the attitude of the Imu says where
    forward is: the truth is the wheels' speed along the body's x axis, integrated.
    """

    def __init__(self, path: Path) -> None:
        """Raise `RecordingError` where the recording has no wheel odometry."""
        states = list(read_odometry(path, WHEELS))
        if not states:
            raise RecordingError(f'{path}: {WHEELS} holds no message')
        self._stamps = np.array([state.stamp_ns for state in states])
        self._speed = np.array([_in_body(state)[0] for state in states])

    def speed(self, stamps_ns: Stamps) -> Array:
        """Return the speed [m/s] at some stamps; NaN before the first and after the last."""
        speed: Array = np.interp(stamps_ns, self._stamps, self._speed, np.nan, np.nan)
        return speed

    def truth(self, pairs: Sequence[Pair]) -> Truth:
        """Return position and velocity at each sample, in the world of the Imu's attitude."""
        stamps_ns = np.array([imu.stamp_ns for _, imu in pairs])
        forward_w = rotations(np.array([imu.orientation for _, imu in pairs]))[:, :, 0]
        velocity = forward_w * self.speed(stamps_ns)[:, None]
        known = ~np.isnan(velocity[:, 0])
        steps = np.diff(stamps_ns[known])[:, None] / NANOSECONDS
        moved = 0.5 * (velocity[known][1:] + velocity[known][:-1]) * steps
        position = np.full(velocity.shape, np.nan)
        position[known] = np.concatenate((np.zeros((1, 3)), np.cumsum(moved, axis=0)))
        return Truth(position, velocity)


class Drive:
    """The Odometry of one uninterrupted integration over the whole recording."""

    def __init__(self, states: Sequence[NavigationState], wheels: Wheels) -> None:
        stamps_ns = np.array([state.stamp_ns for state in states])
        self.time: Array = (stamps_ns - stamps_ns[0]) / NANOSECONDS
        self.position_w: Array = np.array([state.position for state in states])
        self.velocity_b: Array = np.array([_in_body(state) for state in states])
        self.deviation_w: Array = np.sqrt([state.velocity_covariance[::4] for state in states])
        self.wheel_speed = wheels.speed(stamps_ns)

    def standing_at_the_end(self) -> NDArray[np.bool_]:
        """Say which samples come after the last motion of the wheels, shape (n,)."""
        moving = np.flatnonzero(np.abs(self.wheel_speed) >= STANDING)
        last = int(moving[-1]) if len(moving) else 0
        return np.arange(len(self.time)) > last

    def distance(self, speed: Array) -> float:
        """Integrate a speed [m/s], shape (n,), over the drive [m]."""
        mean = 0.5 * (np.abs(speed[1:]) + np.abs(speed[:-1]))
        return float(np.nansum(mean * np.diff(self.time)))


def _in_body(state: NavigationState) -> tuple[float, float, float]:
    return rotate_back(matrix_from_quaternion(state.attitude), state.velocity)


def compare_with_direct(report: Report, samples: Sequence[ImuSample], live: Live) -> None:
    """Check that the nodes gave what the same chain gives when it is called."""
    settings = Configuration(PARAMETERS)
    pipeline = Pipeline(settings)
    direct: dict[str, list[tuple[int, object]]] = {ACCELERATION: [], ODOMETRY: []}
    for imu in samples:
        for name, value in pipeline.chain.push(IMU, imu):
            if name == ACCELERATION:
                direct[name].append((value.stamp_ns, value.acceleration))
            elif name == ODOMETRY:
                direct[name].append((value.stamp_ns, value.position))
    accelerations = [(own.stamp_ns, own.acceleration) for own in live.accelerations]
    positions = [(own.stamp_ns, own.position) for own in live.states]
    same = direct == {ACCELERATION: accelerations, ODOMETRY: positions}
    report.figures['equal_to_direct_chain'] = same
    report.text.append(
        '  the same chain called directly gives '
        + ('the same numbers, bit for bit' if same else 'OTHER numbers')
    )
    if not same:
        report.faults.append('the nodes and the chain called directly give different numbers')


def _describe(report: Report, drive: Drive) -> None:
    standing = drive.standing_at_the_end()
    figures = {
        'duration_s': float(drive.time[-1]),
        'wheel_distance_m': drive.distance(drive.wheel_speed),
        'integrated_distance_m': drive.distance(np.linalg.norm(drive.velocity_b, axis=1)),
        'side_velocity_rms': root_mean_square(drive.velocity_b[:, 1]),
        'up_velocity_rms': root_mean_square(drive.velocity_b[:, 2]),
    }
    rows = [
        ('distance by the wheels', f'{figures["wheel_distance_m"]:.1f} m'),
        ('distance integrated', f'{figures["integrated_distance_m"]:.1f} m'),
        ('velocity to the side, in the body, RMS', f'{figures["side_velocity_rms"]:.3f} m/s'),
        ('velocity upwards, in the body, RMS', f'{figures["up_velocity_rms"]:.3f} m/s'),
    ]
    if standing.any():
        left = drive.velocity_b[standing].mean(axis=0)
        figures['velocity_standing_at_the_end'] = left.tolist()
        deviation = drive.deviation_w[-1]
        figures['velocity_deviation_at_the_end'] = deviation.tolist()
        rows += [
            ('velocity left when it stands at the end, body', _vector(left)),
            ('its σ as published, world', _vector(deviation)),
        ]
    report.add_table(
        f'one free integration over all of {drive.time[-1]:.0f} s, without any aid', ('', ''), rows
    )
    report.figures['drive'] = figures


def _vector(values: Array) -> str:
    return '(' + ', '.join(f'{value:.3f}' for value in values) + ') m/s'


def _draw(path: Path, drive: Drive, truth: Truth, measured: Mapping[str, list[Drift]]) -> Path:
    """Show speed and path of the whole drive, and how the drift grows."""
    figure, (above, below, right) = pictures.two_and_one('Jackal, one free integration')
    above.plot(drive.time, drive.wheel_speed, label='wheels', **pictures.TRUTH)
    above.plot(drive.time, drive.velocity_b[:, 0], label='integrated', **pictures.ESTIMATE)
    above.set_ylabel('forward speed [m/s]')
    pictures.legend_above(above)
    for axis, name in ((1, 'to the side'), (2, 'upwards')):
        colour = pictures.AXES[axis]
        below.plot(drive.time, drive.velocity_b[:, axis], label=name, color=colour)
    below.set_ylabel('other velocity, body [m/s]')
    below.set_xlabel('time [s]')
    pictures.legend_above(below)
    pictures.draw_drift(right, measured, {})
    return pictures.save(figure, path)
