"""Simulated drives, aided and not: what is seen of the attitude, and CH Robotics' Table 1.

A vehicle with a consumer's MEMS sensor drives figures of eight, with stops.  While it still rests
someone sets a pose whose attitude is off.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.accuracy import pictures
from benchmarks.accuracy.inertial import EXPECTED, VEHICLE, Values
from benchmarks.accuracy.report import Goal, Report
from benchmarks.accuracy.simulated_drives import driven, from_its_start
from benchmarks.accuracy.simulated_walks import UP, Walk, measured
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.chain import FAULT, Output
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.reference import attitude_error
from dead_reckoning.core.samples import (
    UNMEASURED_VARIANCE,
    Matrix,
    NavigationState,
    PoseSample,
    VelocitySample,
)
from dead_reckoning.core.stages import (
    AIDING_ODOMETRY,
    AIDING_POSE,
    AIDING_TWIST,
    ODOMETRY,
    RAW,
    SET_POSE,
)

Array = NDArray[np.float64]

NAME = 'aided drives, simulated'

RUNS = 50
BOUND = 1.96 * float(np.sqrt(2.0 / (3 * RUNS)))
"""Half of the interval of 95 % about 1, for three dimensions and so many runs."""

PARTS = ('position', 'velocity', 'attitude')

RATE = 100.0
"""Of the Imu [Hz]."""

SENSOR = {
    'force_noise': 2e-3, 'rate_noise': 1.7e-4, 'force_bias': (0.05, 0.05, 0.0),
    'rate_bias': 0.005, 'scale': 0.003,
}  # fmt: skip
"""A consumer's: 0.2 mg/√Hz and 0.01 °/s/√Hz, biases of 5 mg and 0.3 °/s, 0.3 % of scale.

The bias along the vertical is in the g that the alignment finds.
"""

NOTHING_ELSE = {
    f'navigator.{name}': value
    for name, value in {
        'zero_velocity': False, 'zero_rate': False, 'nonholonomic': False, 'sampling_noise': 0.0,
        'averaging': 0.0, 'acceleration_walk': 0.0, 'rate_walk': 0.0, 'rate_scale': 0.0,
        'aiding_angle': 0.0, 'aiding_correlation': 0.0,
        'acceleration_noise': SENSOR['force_noise'],
        'rate_noise': SENSOR['rate_noise'], 'acceleration_bias': 0.05,
        'rate_bias': SENSOR['rate_bias'],
    }.items()
}  # fmt: skip
TOLD: Values = {**VEHICLE, **NOTHING_ELSE}
"""The filter believes what is drawn, and knows nothing but what aids."""

SET = 2.0
"""When the pose is set, on a drive that begins at 3 s [s]."""
OFF = np.radians((2.0, 2.0, 5.0))
"""One sigma of its roll, pitch and yaw [rad]."""
SPEED = 0.1
"""One sigma of a velocity that aids, along each axis [m/s]."""
PLACE = 1.0
"""One sigma of a position that aids, along each axis [m]."""
OUTAGE = (80.0, 110.0)
"""Without aiding [s]."""
SETTLED = SET + 30.0
"""When the tilt is to be known [s]."""
TILT = 0.2
"""Goal of its RMS [°]."""
TIMES = (3.0, 7.0, 12.0, 22.0, SETTLED, 60.0, 80.0, 110.0, 120.0, 150.0)
"""When it is looked at [s]."""

EXACT = 1e-6
"""Variance of what is known [m², rad²]."""


@dataclass(frozen=True)
class Aid:
    """What measures beside the Imu: the topic, and how often [Hz]."""

    topic: str
    rate: float


GNSS = Aid(AIDING_TWIST, 1.0)
AIDS = {
    'nothing': None,
    'speed of the wheels, 10 Hz': Aid(AIDING_ODOMETRY, 10.0),
    'velocity of GNSS, 1 Hz': GNSS,
    'position of GNSS, 1 Hz': Aid(AIDING_POSE, 1.0),
}


class Errors(NamedTuple):
    """Errors of the parts, shape (n, parts, 3), and their covariances, (n, parts, 3, 3)."""

    found: Array
    covariance: Array


def measure(output: Path) -> Report:
    """Measure all of it."""
    report = Report('aided_drives', f'Aided drives, simulated, {RUNS} runs')
    drive = from_its_start(driven(rate=RATE, loops=3))
    _add_attitude(report, drive)
    _add_consistency(report, drive)
    _add_table_of_ch_robotics(report)
    report.pictures.append(_draw(output / 'aiding-attitude.png', drive))
    return report


def _add_attitude(report: Report, drive: Walk) -> None:
    """Drive with the settings of all vehicles."""
    runs = _runs(drive, SENSOR, VEHICLE)
    rms = np.sqrt(np.mean(runs.found**2, axis=0))
    sigma = np.sqrt(np.mean(np.diagonal(runs.covariance, axis1=3, axis2=4), axis=0))
    rows = []
    for k, time in enumerate(TIMES):
        cells = []
        for of in (rms[k], sigma[k]):
            tilt, yaw = np.degrees((np.sqrt(np.mean(of[2, :2] ** 2)), of[2, 2]))
            cells.append((float(np.linalg.norm(of[0])), float(tilt), float(yaw)))
        rows.append([f'{time:g} s', *(f'{a:.2f} ({b:.2f})' for a, b in zip(*cells, strict=True))])
        if time == SETTLED:
            report.figures['settled_deg'] = {'tilt': cells[0][1], 'yaw': cells[0][2]}
            what = 'aided drive (simulated): roll and pitch after 30 s, RMS [°]'
            report.aim(what, cells[0][1], TILT)
    head = ('', 'position [m]', 'roll, pitch [°]', 'yaw [°]')
    report.add_table('RMS (σ), vehicle.yaml, velocity of GNSS; none of it 80 to 110 s', head, rows)
    end = TIMES.index(OUTAGE[1])
    errors = np.linalg.norm(runs.found[:, end, 0], axis=1)
    sigmas = np.sqrt(np.trace(runs.covariance[:, end, 0], axis1=1, axis2=2))
    within = float(np.mean(errors < 3.0 * sigmas))
    report.figures['outage_within_3_sigma'] = within
    what = 'aided drive (simulated): position after an outage of 30 s within 3σ'
    report.goals.append(Goal(what, '≥ 95 %', f'{within:.0%}', within >= 0.95))


def _add_consistency(report: Report, drive: Walk) -> None:
    """Let the filter believe what is drawn: eᵀP⁻¹e/3 is 1 in the mean then."""
    runs = _runs(drive, {**SENSOR, 'scale': 0.0}, TOLD)
    solved = np.linalg.solve(runs.covariance, runs.found[..., None])[..., 0]
    anees = np.mean(np.sum(runs.found * solved, axis=3), axis=0) / 3.0
    rows = [
        (f'{time:g} s', *(f'{value:.2f}' for value in row))
        for time, row in zip(TIMES, anees, strict=True)
    ]
    rows.append(('mean', *(f'{value:.2f}' for value in anees.mean(axis=0))))
    within = np.mean(np.abs(anees - 1.0) < BOUND)
    caption = f'ANEES, filter told the truth; {within:.0%} of the values in 1 ± {BOUND:.2f}'
    report.add_table(caption, ('', *PARTS), rows)
    report.figures['anees'] = dict(zip(PARTS, anees.mean(axis=0).tolist(), strict=True))
    for part, mean in report.figures['anees'].items():
        wanted = f'{1.0 - BOUND:.2f} to {1.0 + BOUND:.2f}'
        met = bool(abs(mean - 1.0) <= BOUND)
        report.goals.append(Goal(f'ANEES, {part}: aided drive', wanted, f'{mean:.2f}', met))


def _add_table_of_ch_robotics(report: Report) -> None:
    """Let a filter that nothing aids rest with its attitude off, and see where it gets."""
    last = 60
    time = np.arange(round((SET + last) * RATE) + 1) / RATE
    still = np.zeros((len(time), 3))
    rest = Walk(time, still + UP, still, still, still, np.tile(np.eye(3), (len(time), 1, 1)))
    rows, worst = [], 0.0
    for row in attitude_error.table(corrected=True):
        turn = Rotation.from_rotvec([0.0, np.radians(float(row.angle)), 0.0])
        states = _navigated(rest, TOLD, turn, None, np.random.default_rng(0))
        at = {after: len(states) - 1 - round((last - after) * RATE) for after in (10, last)}
        cells = [(float(np.linalg.norm(states.velocity[at[10]])), float(row.velocity))]
        cells += [
            (float(np.linalg.norm(states.position[k])), float(position))
            for k, position in zip(at.values(), row.positions, strict=False)
        ]
        worst = max(worst, *(100.0 * abs(found / table - 1.0) for found, table in cells))
        rows.append([f'{row.angle}°', *(f'{found:.4g} ({table:g})' for found, table in cells)])
    head = ('attitude off by', 'velocity, 10 s [m/s]', 'position, 10 s [m]', '60 s [m]')
    report.add_table("unaided, and CH Robotics' Table 1 with ½ a t²", head, rows)
    report.aim("CH Robotics' Table 1 by the unaided filter, worst cell [%]", worst, 1.0)


def _runs(drive: Walk, sensor: Mapping[str, Any], values: Values) -> Errors:
    """Return the errors at `TIMES` of all runs, each part with the runs as its first axis."""
    runs = []
    for seed in range(RUNS):
        random = np.random.default_rng(10_000 + seed)
        turn = Rotation.from_rotvec(random.normal(0.0, OFF))
        drawn = measured(drive, seed, **sensor)
        states = _navigated(drawn, values, turn, GNSS, random)
        runs.append(_errors(drive, states, np.searchsorted(drive.time, TIMES)))
    return Errors(*(np.array(part) for part in zip(*runs, strict=True)))


def _errors(true: Walk, states: StateBlock, samples: NDArray[np.int64]) -> Errors:
    """Return errors as the filter has them: that of the velocity along the axes it has found."""
    at = samples - (len(true.time) - len(states))
    attitude, truth = Rotation.from_quat(states.attitude[at]), true.rotation[samples]
    twist_b = np.einsum('nij,ni->nj', truth, true.velocity[samples])
    found = (
        true.position[samples] - states.position[at],
        attitude.apply(twist_b) - states.velocity[at],
        (Rotation.from_matrix(truth) * attitude.inv()).as_rotvec(),
    )
    covariances = (
        states.position_covariance, states.velocity_covariance, states.attitude_covariance
    )  # fmt: skip
    return Errors(
        np.stack(found, axis=1),
        np.stack([each[at].reshape(-1, 3, 3) for each in covariances], axis=1),
    )


def _navigated(
    drawn: Walk, values: Values, turn: Rotation, aid: Aid | None, random: np.random.Generator
) -> StateBlock:
    """Drive the pipeline, set a pose that is turned, and give it what aids."""
    chain = Pipeline(Configuration(values)).chain
    states: list[NavigationState] = []

    def take(outputs: list[Output]) -> None:
        for name, value in outputs:
            if name == ODOMETRY:
                states.append(value)
            elif name == FAULT and not isinstance(value, EXPECTED):
                raise value

    for topic, sample in _samples(drawn, turn, aid, random):
        take(chain.push(topic, sample))
    take(chain.end())
    return StateBlock.of(states)


def _samples(
    drawn: Walk, turn: Rotation, aid: Aid | None, random: np.random.Generator
) -> Iterator[tuple[str, Any]]:
    """Give what comes, with its topic, in order."""
    block = drawn.block()
    begin = round(SET * RATE)
    for k, now in enumerate(drawn.time.tolist()):
        yield RAW, block.sample(k)
        stamp_ns = int(block.stamp_ns[k])
        position = drawn.position[k]
        if k == begin:
            rotation = Rotation.from_matrix(drawn.rotation[k])
            attitude = tuple((turn * rotation).as_quat().tolist())
            yield SET_POSE, PoseSample(
                stamp_ns, '', tuple(position.tolist()), _diagonal(EXACT, EXACT, EXACT),
                attitude, _diagonal(*OFF**2),
            )  # fmt: skip
        idle = k <= begin or OUTAGE[0] <= now < OUTAGE[1]
        if aid is None or idle or (k - begin) % round(RATE / aid.rate):
            continue
        noise = random.standard_normal(3)
        known = _diagonal(*3 * (SPEED**2,))
        if aid.topic == AIDING_TWIST:
            velocity = tuple((drawn.velocity[k] + SPEED * noise).tolist())
            yield aid.topic, VelocitySample(stamp_ns, 'odom', velocity, known)
        elif aid.topic == AIDING_ODOMETRY:
            forward = float(drawn.rotation[k, :, 0] @ drawn.velocity[k] + SPEED * noise[0])
            known = _diagonal(SPEED**2, UNMEASURED_VARIANCE, UNMEASURED_VARIANCE)
            yield aid.topic, VelocitySample(stamp_ns, '', (forward, 0.0, 0.0), known)
        else:
            at = tuple((position + PLACE * noise).tolist())
            known, unknown = _diagonal(*3 * (PLACE**2,)), _diagonal(*3 * (UNMEASURED_VARIANCE,))
            yield aid.topic, PoseSample(stamp_ns, '', at, known, (0.0, 0.0, 0.0, 1.0), unknown)


def _diagonal(x: float, y: float, z: float) -> Matrix:
    return (float(x), 0.0, 0.0, 0.0, float(y), 0.0, 0.0, 0.0, float(z))


def _draw(path: Path, drive: Walk) -> Path:
    """Show σ of the tilt and of the yaw, by what aids."""
    figure, _, (above, below) = pictures.beside('σ of the attitude by what aids', 0)
    figure.set_size_inches(12.0, 6.5)
    drawn = measured(drive, 0, **{**SENSOR, 'scale': 0.0})
    turn = Rotation.from_rotvec(np.random.default_rng(0).normal(0.0, OFF))
    for (name, aid), colour in zip(AIDS.items(), pictures.COLOURS, strict=False):
        states = _navigated(drawn, TOLD, turn, aid, np.random.default_rng(1))
        time = drawn.time[-len(states) :]
        sigma = np.degrees(np.sqrt(states.attitude_covariance[:, [0, 4, 8]]))
        tilt = np.sqrt(np.mean(sigma[:, :2] ** 2, axis=1))
        above.plot(time, tilt, color=colour, label=name)
        below.plot(time, sigma[:, 2], color=colour)
    for axes, what in ((above, 'roll and pitch'), (below, 'yaw')):
        axes.axvspan(*OUTAGE, color='#eeeeee', zorder=0)
        axes.set_yscale('log')
        axes.set_ylabel(f'σ of {what} [°]')
        axes.yaxis.set_major_formatter('{x:g}')
    below.set_xlabel('time [s]; grey: nothing aids')
    pictures.legend_above(above)
    return pictures.save(figure, path)
