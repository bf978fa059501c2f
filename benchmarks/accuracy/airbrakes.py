"""Airbrakes: a held sensor in six orientations; rest, up by about a metre, and back.

NCSU High-Powered Rocketry Club, AirbrakesV2: a LORD 3DM-CX5 at 1 kHz that says, twice as far
apart, what it takes for gravity and for linear acceleration.  That is another estimate, no truth.
"""

from __future__ import annotations

import csv
import gzip
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.accuracy import pictures
from benchmarks.accuracy.report import Report
from benchmarks.accuracy.signals import root_mean_square
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import NotLevelledError, RecordingError
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import matrix_from_quaternion, rotate_back
from dead_reckoning.core.samples import NANOSECONDS, ImuSample

Array = NDArray[np.float64]

NAME = 'Airbrakes'
PATTERN = 'airbrakes_updown'

ATTITUDES = ('estimate', 'rest')

MOVING = 1.0
"""The sensor moves from where its own linear acceleration first exceeds this [m/s²]."""


APART = 25.0
"""From line to line of the picture [m/s²]."""


@dataclass(frozen=True)
class Lift:
    """A recording: raw samples, and what the sensor itself made of them.

    ``stamps_ns``, shape (n,); ``force_s`` [m/s²] and ``turn_s`` [rad/s], shapes (n, 3).  Its own,
    at ``own_ns``, shape (m,): ``linear_s`` and ``up_s``, the reverse of its gravity, both of shape
    (m, 3) [m/s²].  All in the frame of the sensor.
    """

    stamps_ns: NDArray[np.int64]
    force_s: Array
    turn_s: Array
    own_ns: NDArray[np.int64]
    linear_s: Array
    up_s: Array


@dataclass(frozen=True)
class Removal:
    """What gravity removal made of the samples from number ``first`` on, frame of the sensor.

    ``linear_s``, shape (k, 3) [m/s²]; ``up_s``, of unit length, shape (k, 3).
    """

    first: int
    linear_s: Array
    up_s: Array


def measure(path: Path, output: Path) -> Report:
    """Measure all orientations of the folder."""
    found = sorted(path.glob('*.csv.gz'))
    if not found:
        raise RecordingError(f'{path}: no *.csv.gz in it; docs/accuracy.md says how to get them')
    report = Report('airbrakes', f'Airbrakes, {len(found)} orientations, all settings default')
    rows = []
    shown = []
    for recording in found:
        name = recording.name.removesuffix('.csv.gz')
        lift = load(recording)
        made: dict[str, Removal | None] = {}
        for attitude in ATTITUDES:
            removal = remove_gravity(lift, attitude)
            figures = None if removal is None else compare(lift, removal)
            report.figures.setdefault(attitude, {})[name] = figures
            rows.append((name if attitude == ATTITUDES[0] else '', attitude, *said(figures)))
            made[attitude] = removal
        shown.append((name, lift, made))
    report.add_table(
        'gravity removed, against what the sensor says itself',
        (
            '',
            'attitude',
            'at rest, mean [m/s²]',
            'difference at rest, RMS',
            'in motion, RMS',
            'itself in motion, RMS',
            'tilt apart, median',
            'most',
        ),
        rows,
    )
    report.pictures.append(draw(output / 'airbrakes.png', shown))
    return report


def remove_gravity(lift: Lift, attitude: str) -> Removal | None:
    """Push all samples through gravity removal; return None if it finds no rest to level at."""
    removal = GravityRemoval(GravitySettings(attitude=attitude), CommonSettings(), FrameSettings())
    linear, up = [], []
    rows = zip(lift.stamps_ns.tolist(), lift.force_s.tolist(), lift.turn_s.tolist(), strict=True)
    for stamp_ns, force, turn in rows:
        imu = ImuSample(stamp_ns, 'imu_link', tuple(force), angular_velocity=tuple(turn))
        try:
            levelled = removal.update(imu)
        except NotLevelledError:
            continue
        assert levelled.imu.orientation is not None
        rot_ws = matrix_from_quaternion(levelled.imu.orientation)
        linear.append(rotate_back(rot_ws, levelled.acceleration.acceleration))
        up.append(rot_ws[6:])
    if not linear:
        return None
    return Removal(len(lift.stamps_ns) - len(linear), np.array(linear), np.array(up))


def compare(lift: Lift, removal: Removal) -> dict[str, float]:
    """Return the figures of one orientation, at the moments of the sensor's own."""
    time = lift.stamps_ns[removal.first :]
    met = lift.own_ns >= time[0]
    own_ns, theirs = lift.own_ns[met], lift.linear_s[met]
    ours = resample(own_ns, time, removal.linear_s)
    up = resample(own_ns, time, removal.up_s)
    moved = np.flatnonzero(np.linalg.norm(theirs, axis=1) > MOVING)
    begin = int(moved[0]) if len(moved) else len(own_ns)
    return {
        'rest_mean': float(np.linalg.norm(ours[:begin].mean(axis=0))) if begin else float('nan'),
        'rest_rms': root_mean_square((ours - theirs)[:begin]),
        'motion_rms': root_mean_square((ours - theirs)[begin:]),
        'itself_rms': root_mean_square(theirs[begin:]),
        **dict(zip(('tilt_median', 'tilt_most'), _apart(up, lift.up_s[met]), strict=True)),
    }


def resample(wanted_ns: NDArray[np.int64], stamps_ns: NDArray[np.int64], values: Array) -> Array:
    """Interpolate vectors, shape (n, 3), at other moments."""
    origin = stamps_ns[0]
    at, known = (wanted_ns - origin) / NANOSECONDS, (stamps_ns - origin) / NANOSECONDS
    return np.column_stack([np.interp(at, known, column) for column in values.T])


def _apart(ours: Array, theirs: Array) -> tuple[float, float]:
    """Return median and largest angle between vectors, shapes (n, 3) [°]."""
    lengths = np.linalg.norm(ours, axis=1) * np.linalg.norm(theirs, axis=1)
    across = np.linalg.norm(np.cross(ours, theirs), axis=1) / lengths
    along = np.einsum('ni,ni->n', ours, theirs) / lengths
    angle = np.degrees(np.arctan2(across, along))
    return float(np.median(angle)), float(angle.max())


def said(figures: dict[str, float] | None) -> list[str]:
    """Return the figures of one orientation as words."""
    if figures is None:
        return ['no rest', *[''] * 5]
    return [
        f'{value:.2f}°' if key.startswith('tilt') else f'{value:.3f}'
        for key, value in figures.items()
    ]


def draw(path: Path, shown: list[tuple[str, Lift, dict[str, Removal | None]]]) -> Path:
    """Show the acceleration along the vertical in each orientation, below each other."""
    figure, axes = pictures.one('Airbrakes: acceleration upwards, gravity removed')
    for row, (_, lift, made) in enumerate(shown):
        start, offset = lift.stamps_ns[0], -APART * row
        axes.plot(
            (lift.own_ns - start) / NANOSECONDS,
            _upwards(lift.linear_s, lift.up_s) + offset,
            label=None if row else 'the sensor itself',
            **pictures.TRUTH,
        )
        for (attitude, removal), colour in zip(made.items(), pictures.AXES, strict=False):
            if removal is not None:
                time = (lift.stamps_ns[removal.first :] - start) / NANOSECONDS
                up = _upwards(removal.linear_s, removal.up_s) + offset
                axes.plot(time, up, color=colour, linewidth=1.2, label=attitude)
    handles = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    axes.legend(handles.values(), handles.keys(), loc='lower right', ncols=3)
    axes.set_yticks([-APART * row for row in range(len(shown))], [name for name, _, _ in shown])
    axes.set_xlabel(f'time [s]; {APART:g} m/s² from line to line')
    return pictures.save(figure, path)


def _upwards(vector_s: Array, up_s: Array) -> Array:
    """Return the part of vectors, shape (n, 3), along others of any length."""
    part: Array = np.einsum('ni,ni->n', vector_s, up_s) / np.linalg.norm(up_s, axis=1)
    return part


def load(path: Path) -> Lift:
    """Read one orientation; raises `RecordingError` where something is missing."""
    try:
        with gzip.open(path, 'rt', encoding='utf-8', newline='') as lines:
            rows = list(csv.DictReader(lines))
        raw = [row for row in rows if row['scaledAccelX']]
        own = [row for row in rows if row['estLinearAccelX']]
        if not raw or not own:
            raise ValueError('no samples, or no estimates, in it')
        return Lift(
            np.array([int(row['timestamp']) for row in raw]),
            GRAVITY * _vectors(raw, 'scaledAccel'),
            _vectors(raw, 'scaledGyro'),
            np.array([int(row['timestamp']) for row in own]),
            _vectors(own, 'estLinearAccel'),
            -_vectors(own, 'estGravityVector'),
        )
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise RecordingError(f'{path}: {type(error).__name__}, {error}') from error


def _vectors(rows: list[dict[str, str]], name: str) -> Array:
    return np.array([[float(row[f'{name}{axis}']) for axis in 'XYZ'] for row in rows])
