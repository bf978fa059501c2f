"""Read what is compared: tables of poses or steps, TUM files, topics of recordings.

Every fault raises an `InputError` that names the file and, in a text, the line and the value.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from itertools import chain, islice
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.errors import InputError, RecordingError
from dead_reckoning.sources import bags
from dead_reckoning.tools.evaluate.steps import Steps
from dead_reckoning.tools.evaluate.trajectory import Trajectory

POSE = ('px', 'py', 'pz', 'qx', 'qy', 'qz', 'qw')
DEVIATION = ('sx', 'sy', 'sz')
TUM = ('timestamp', 'tx', 'ty', 'tz', 'qx', 'qy', 'qz', 'qw')
WHOLE = ('stamp_ns', 'step')
"""Columns of whole numbers; the others hold any."""

LATEST = 2.0**63 / 1e9
"""What a timestamp has to be less than, to be one in nanoseconds [s]."""

FARTHEST = 1e12
"""A position farther from the origin [m] is a mistake; its square might be no number."""

SHORTEST = 1e-3
"""The least norm of a quaternion; a shorter one is a mistake and no rotation."""

Columns = dict[str, NDArray[Any]]


def read_truth(path: Path, topic: str | None = None) -> Trajectory | Steps:
    """Read poses or steps: a recording, a table with a header, or else a TUM file."""
    if topic is not None or path.is_dir() or path.suffix in bags.SUFFIXES:
        return read_topic(path, topic)
    header = _header(path)
    if 'px' in header:
        return read_trajectory(path)
    if 'step' in header:
        return read_steps(path)
    if 'stamp_ns' in header:
        raise InputError(
            f'{path}, line 1: neither a column px, as in odometry.csv, nor step, as in steps.csv'
        )
    return read_tum(path)


def read_trajectory(path: Path) -> Trajectory:
    """Read a table with the columns of odometry.csv; those of σ may be missing."""
    deviation = DEVIATION if set(DEVIATION) <= set(_header(path)) else ()
    columns = _columns(path, ('stamp_ns', *POSE, *deviation))
    return _trajectory(path, columns, POSE, columns['stamp_ns'], deviation)


def read_tum(path: Path) -> Trajectory:
    """Read ``timestamp tx ty tz qx qy qz qw`` [s, m], blanks between, # before comments."""
    columns = _columns(path, TUM, header=False)
    latest = float(np.abs(columns['timestamp']).max(initial=0.0))
    if latest >= LATEST:
        raise InputError(f'{path}: {latest:.4g} is no timestamp in seconds')
    stamp_ns = np.rint(columns['timestamp'] * 1e9).astype(np.int64)
    return _trajectory(path, columns, TUM[1:], stamp_ns)


def read_steps(path: Path) -> Steps:
    """Read a table with the column step, the total; stamp_ns and distance [m] may be missing."""
    header = _header(path)
    more = [name for name in ('stamp_ns', 'distance') if name in header]
    columns = _columns(path, ('step', *more))
    _check_order(path, columns.get('stamp_ns', np.arange(0)))
    any_row = len(columns['step']) > 0
    return Steps(
        int(columns['step'][-1]) if any_row else 0,
        columns.get('stamp_ns'),
        (float(columns['distance'][-1]) if any_row else 0.0) if 'distance' in more else None,
    )


def read_topic(path: Path, topic: str | None) -> Trajectory:
    """Read a topic of a recording: Odometry, or if it is named PoseStamped."""
    try:
        if topic is not None and bags.topics(path).get(topic) == bags.POSE:
            states = list(bags.read_poses(path, topic))
        else:
            states = list(bags.read_odometry(path, topic))
    except RecordingError as error:
        raise InputError(str(error)) from error
    if not states:
        raise InputError(f'{path}: the topic has no messages')
    position = np.array([state.position for state in states])
    attitude = np.array([state.attitude for state in states])
    stamp_ns = np.array([state.stamp_ns for state in states])
    if not (np.isfinite(position).all() and np.isfinite(attitude).all()):
        raise InputError(f'{path}: a pose is not finite')
    columns = dict(zip(POSE, np.column_stack([position, attitude]).T, strict=True))
    return _trajectory(path, columns, POSE, stamp_ns)


def _trajectory(
    path: Path,
    columns: Columns,
    pose: Sequence[str],
    stamp_ns: NDArray[np.int64],
    deviation: Sequence[str] = (),
) -> Trajectory:
    if not len(stamp_ns):
        raise InputError(f'{path}: holds no poses')
    _check_order(path, stamp_ns)
    attitude = np.column_stack([columns[name] for name in pose[3:]])
    norm = np.linalg.norm(attitude, axis=1, keepdims=True)
    if norm.min() < SHORTEST:
        raise InputError(
            f'{path}: the quaternion of pose {int(norm.argmin()) + 1} is no rotation: all but zero'
        )
    position = np.column_stack([columns[name] for name in pose[:3]])
    if np.abs(position).max() > FARTHEST:
        row = int(np.abs(position).max(axis=1).argmax())
        raise InputError(f'{path}: pose {row + 1} is at {position[row].tolist()} m')
    return Trajectory(
        stamp_ns,
        position,
        attitude / norm,
        np.column_stack([columns[name] for name in deviation]) if deviation else None,
    )


def _check_order(path: Path, stamp_ns: NDArray[np.int64]) -> None:
    back = np.flatnonzero(np.diff(stamp_ns) <= 0)
    if len(back):
        row = int(back[0]) + 1
        raise InputError(
            f'{path}: stamps do not increase: {stamp_ns[row]} comes after {stamp_ns[row - 1]} ns '
            f'({len(back)} times in all); compare one run at a time, in order'
        )


def has_rows(path: Path) -> bool:
    """Say whether a table has more than its header."""
    return any(line.strip() for line in list(islice(_lines(path), 2))[1:])


def _header(path: Path) -> list[str]:
    return [cell.strip() for cell in next(_lines(path), '').split(',')]


def _lines(path: Path) -> Iterator[str]:
    try:
        with path.open(encoding='utf-8-sig', errors='backslashreplace') as lines:
            yield from lines
    except OSError as error:
        raise InputError(f'{path}: {error.strerror or error}') from error


def _columns(path: Path, names: Sequence[str], header: bool = True) -> Columns:
    """Return columns by name: those of the header, or exactly these, blanks between."""
    first = _header(path)
    if header:
        for name in names:
            if first.count(name) != 1:
                what = 'no' if name not in first else 'more than one'
                raise InputError(f'{path}, line 1: {what} column {name} among {", ".join(first)}')
    places = [first.index(name) for name in names] if header else range(len(names))
    kinds = [(name, np.int64 if name in WHOLE else np.float64) for name in names]
    lines = _lines(path)
    if header:
        next(lines)
    some = next((line for line in lines if line.strip()), None)
    if some is None:
        return {name: np.zeros(0, kind) for name, kind in kinds}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter('error')
            rows = np.loadtxt(
                chain([some], lines),
                dtype=kinds,
                delimiter=',' if header else None,
                comments=None if header else '#',
                usecols=places,
                ndmin=1,
            )
    except (ValueError, Warning):
        rows = None
    if rows is None or not all(np.isfinite(rows[name]).all() for name in names):
        _refuse(path, names, places, header)
    return {name: np.ascontiguousarray(rows[name]) for name in names}


def _refuse(path: Path, names: Sequence[str], places: Sequence[int], header: bool) -> NoReturn:
    """Raise where the first fault is: read once more, line by line."""
    for number, line in enumerate(_lines(path), 1):
        cells = line.split(',') if header else line.partition('#')[0].split()
        if (header and number == 1) or not line.strip() or (not header and not cells):
            continue
        where = f'{path}, line {number}'
        if len(cells) <= max(places):
            raise InputError(
                f'{where}: {len(cells)} columns, where {", ".join(names)} take at least '
                f'{max(places) + 1}'
            )
        for name, place in zip(names, places, strict=True):
            cell = cells[place].strip()
            whole = name in WHOLE
            try:
                fine = abs(int(cell)) < 2**63 if whole else math.isfinite(float(cell))
            except ValueError:
                fine = False
            if not fine:
                what = 'whole number' if whole else 'finite number'
                raise InputError(f'{where}: {name} is {cell[:40]!r}, no {what}')
    raise InputError(f'{path}: can not be read as columns {", ".join(names)}')
