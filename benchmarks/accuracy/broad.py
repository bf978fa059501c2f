"""BROAD: a held inertial sensor with optical attitude and position beside it.

D. Laidig, M. Caruso, A. Cereatti, T. Seel, "BROAD: A Benchmark for Robust Inertial Orientation
Estimation", Data 6(7), 2021, doi 10.3390/data6070072.

The optical attitude goes into the chain as the orientation of the Imu, so gravity removal and
integration are measured, no estimate of attitude.  docs/accuracy.md says what each figure is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import pictures
from benchmarks.accuracy.drift import FREE, Drift, Pair, Truth, add_drift_table, drifts, every
from benchmarks.accuracy.optical import CUT_OFF, Mounting, OpticalTruth
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.signals import low_pass, root_mean_square, rotations
from benchmarks.accuracy.trial import START_NS, Trial, load
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.chain import FAULT
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import RecordingError, UnpairedError
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import ACCELERATION, IMU

Array = NDArray[np.float64]

NAME = 'BROAD'
PATTERN = 'broad/*.npz'

CALIBRATIONS = (1.0, 10.0)
"""Times of rest [s] from which the offset is taken: the default, and one that averages longer."""

SETTLED = 1.0
"""When [s] the offset is asked for: by then gravity has been measured."""

SPACING = 1.0
"""Distance [s] of the starts of free integration."""

PLAIN = {'10_undisturbed_slow_translation_A': {2.0: 0.03, 5.0: 0.18, 10.0: 0.81}}
"""Drift [m] of a plain double integration with the true attitude, where it is known."""


@dataclass(frozen=True)
class Run:
    """What the chain made of a trial.

    ``pairs`` are the samples that came through, ``index`` their numbers in the recording, shape
    (m,); ``acceleration_w``, shape (n, 3) [m/s²], is NaN where a sample was dropped, ``dropped``
    says why.
    """

    pairs: list[Pair]
    index: NDArray[np.int64]
    acceleration_w: Array
    dropped: Counter[str]
    gravity: float


def measure(path: Path, output: Path) -> Report:
    """Measure one recording."""
    trial = load(path)
    run = run_chain(trial)
    calibrated = {
        f'offset from {duration:g} s of rest': calibrate(path, run.pairs, duration)
        for duration in CALIBRATIONS
    }
    best = list(calibrated.values())[-1]
    corrected_w = run.acceleration_w - rotations(trial.attitude) @ np.array(best.offset)
    optical = OpticalTruth(trial.position_w, trial.attitude, trial.rate)
    mounting = optical.fit_mounting(low_pass(corrected_w, trial.rate, CUT_OFF), trial.moving)

    moving = np.flatnonzero(trial.moving[run.index])
    starts = every(SPACING, run.pairs, int(moving[0]), int(moving[-1]))
    markers = Truth(optical.position_w[run.index], optical.velocity_w[run.index])
    sensor = Truth(*(values[run.index] for values in optical.at_sensor(mounting)))
    measured = {
        **{name: drifts(run.pairs, markers, starts, own) for name, own in calibrated.items()},
        'and markers and delay fitted': drifts(run.pairs, sensor, starts, best),
    }

    known = {'a plain program': PLAIN[path.stem]} if path.stem in PLAIN else {}
    report = Report(f'broad-{path.stem}', f'BROAD, {path.stem}')
    _describe(report, trial, run, calibrated)
    _compare_accelerations(report, trial, run, corrected_w, optical, mounting)
    add_drift_table(
        report,
        f'drift of free integration: a start every {SPACING:g} s of the motion, with the optical '
        'velocity',
        measured,
        known,
    )
    report.pictures.append(
        _draw(output / f'{report.name}.png', trial, corrected_w, optical, measured, known)
    )
    return report


def run_chain(trial: Trial) -> Run:
    """Push all samples through gravity removal and integrator."""
    settings = Configuration({'gravity.attitude': 'message', **FREE})
    pipeline = Pipeline(
        settings[GravitySettings],
        settings[IntegratorSettings],
        settings[CommonSettings],
        settings[FrameSettings],
    )
    pairs: list[Pair] = []
    index = []
    dropped: Counter[str] = Counter()
    acceleration_w = np.full(trial.force_s.shape, np.nan)
    for number, imu in enumerate(trial.samples()):
        for name, value in pipeline.chain.push(IMU, imu):
            if name == ACCELERATION:
                pairs.append((value, imu))
                index.append(number)
                acceleration_w[number] = value.acceleration
            elif name == FAULT and not isinstance(value, UnpairedError):
                # What gravity removal drops has no partner at the integrator: said twice.
                dropped[type(value).__name__] += 1
    return Run(pairs, np.array(index), acceleration_w, dropped, pipeline.gravity.gravity)


def calibrate(path: Path, pairs: list[Pair], duration: float) -> Integrator:
    """Return an integrator that has learnt its offset as ``~/calibrate`` would, at rest."""
    settings = IntegratorSettings.from_values(
        {**FREE, 'integrator.calibration_duration': duration}
    )
    integrator = Integrator(settings, CommonSettings())
    asked_ns = START_NS + round(SETTLED * NANOSECONDS)
    future = None
    for acceleration, imu in pairs:
        if future is None and imu.stamp_ns >= asked_ns:
            future = integrator.calibrate()
        integrator.update(acceleration, imu)
        if future is not None and future.done():
            future.result()
            return integrator
    raise RecordingError(f'{path}: too short to take the offset from {duration:g} s')


def _describe(
    report: Report, trial: Trial, run: Run, calibrated: Mapping[str, Integrator]
) -> None:
    count, moving = len(trial.force_s), int(trial.moving.sum())
    lost = ', '.join(f'{n} {kind}' for kind, n in run.dropped.items()) or 'none'
    rows = [
        ('samples', f'{count}, {trial.rate:.1f} Hz'),
        ('in motion', f'{moving / trial.rate:.1f} of {count / trial.rate:.1f} s'),
        ('dropped', lost),
        ('gravity from rest', f'{run.gravity:.4f} m/s²'),
    ]
    for name, integrator in calibrated.items():
        rows.append((name, ', '.join(f'{value:+.4f}' for value in integrator.offset) + ' m/s²'))
    report.add_table('recording', ('', ''), rows)
    report.figures['recording'] = {
        'samples': count,
        'rate_hz': trial.rate,
        'motion_s': moving / trial.rate,
        'dropped': dict(run.dropped),
        'gravity': run.gravity,
        'offset': {name: list(own.offset) for name, own in calibrated.items()},
    }


def _compare_accelerations(
    report: Report,
    trial: Trial,
    run: Run,
    corrected_w: Array,
    optical: OpticalTruth,
    mounting: Mounting,
) -> None:
    published = low_pass(run.acceleration_w, trial.rate, CUT_OFF)
    corrected = low_pass(corrected_w, trial.rate, CUT_OFF)
    columns = {
        'as published': published - optical.acceleration_w,
        'offset taken off': corrected - optical.acceleration_w,
        'markers and delay fitted': corrected - optical.acceleration_at(mounting),
        'optical itself': optical.acceleration_w,
    }
    rows = []
    figures: dict[str, dict[str, float]] = {}
    for when, chosen in (('at rest', ~trial.moving), ('in motion', trial.moving)):
        values = {name: root_mean_square(signal[chosen]) for name, signal in columns.items()}
        figures[when] = values
        rows.append((when, *(f'{value:.3f}' for value in values.values())))
    report.add_table(
        f'linear acceleration less the optical one, RMS of an axis [m/s²], both below '
        f'{CUT_OFF:g} Hz',
        ('', *columns),
        rows,
    )
    mean = np.nanmean(columns['offset taken off'][trial.moving], axis=0)
    arm = ', '.join(f'{1000 * value:.1f}' for value in mounting.lever_arm_s)
    report.text.append(
        f'  fitted: the sensor is at ({arm}) mm from the markers and {1000 * mounting.delay:.1f} '
        f'ms late\n  mean error in motion, which integrates to drift: '
        f'({", ".join(f"{value:+.4f}" for value in mean)}) m/s²'
    )
    report.figures['acceleration_rmse'] = figures
    report.figures['lever_arm_m'] = mounting.lever_arm_s.tolist()
    report.figures['delay_s'] = mounting.delay
    report.figures['mean_error_in_motion'] = mean.tolist()


def _draw(
    path: Path,
    trial: Trial,
    corrected_w: Array,
    optical: OpticalTruth,
    measured: Mapping[str, list[Drift]],
    known: Mapping[str, Mapping[float, float]],
) -> Path:
    """Show a stretch of the motion, and how the drift grows."""
    first = int(np.flatnonzero(trial.moving)[0]) + round(10.0 * trial.rate)
    shown = slice(first, first + round(6.0 * trial.rate))
    time = np.arange(len(corrected_w))[shown] / trial.rate
    ours = low_pass(corrected_w, trial.rate, CUT_OFF)[shown]
    theirs = optical.acceleration_w[shown]
    figure, (above, below, right) = pictures.two_and_one(f'BROAD, {path.stem[6:]}')
    above.plot(time, theirs[:, 0], label='optical', **pictures.TRUTH)
    above.plot(time, ours[:, 0], label='gravity removed', **pictures.ESTIMATE)
    above.set_ylabel('acceleration east [m/s²]')
    pictures.legend_above(above)
    for axis, name in enumerate(('east', 'north', 'up')):
        below.plot(time, (ours - theirs)[:, axis], label=name, color=pictures.AXES[axis])
    below.set_ylabel('difference [m/s²]')
    below.set_xlabel('time [s]')
    pictures.legend_above(below)
    pictures.draw_drift(right, measured, known)
    return pictures.save(figure, path)
