"""Tables of states as text, for logs while running and for replays: one layout for both."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import nan, sqrt
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.chain import Stage
from dead_reckoning.core.errors import DeadReckoningError
from dead_reckoning.core.rotation import yaw_from_quaternion
from dead_reckoning.core.samples import LinearAcceleration, NavigationState
from dead_reckoning.core.stages import ACCELERATION, ODOMETRY

ODOMETRY_COLUMNS = (
    'stamp_ns', 'px', 'py', 'pz', 'qx', 'qy', 'qz', 'qw', 'vx', 'vy', 'vz', 'sx', 'sy', 'sz',
    'stationary',
)  # fmt: skip
"""World frame; m, m/s; s is the standard deviation of the position; stationary is 0 or 1."""

LOG_COLUMNS = (*ODOMETRY_COLUMNS, 'ax', 'ay', 'az', 'heading')
"""The same, with the linear acceleration [m/s², world] and the heading [rad, ENU].  Where
no acceleration has the stamp of the state, as with an inertial navigator, it is nan."""


class LogError(DeadReckoningError):
    """A log can't be written."""


def odometry_row(state: NavigationState) -> tuple[float, ...]:
    """Return a state as a row of `ODOMETRY_COLUMNS`."""
    covariance = state.position_covariance
    return (
        state.stamp_ns,
        *state.position,
        *state.attitude,
        *state.velocity,
        *(sqrt(max(0.0, covariance[k])) for k in (0, 4, 8)),
        int(state.stationary),
    )


def odometry_columns(block: StateBlock) -> list[list[str]]:
    """Return states as columns of text, those of `ODOMETRY_COLUMNS`."""
    deviation = np.sqrt(np.maximum(0.0, block.position_covariance[:, [0, 4, 8]]))
    numbers = (block.position, block.attitude, block.velocity, deviation)
    return [
        list(map(str, block.stamp_ns.tolist())),
        *(digits(column) for part in numbers for column in part.T),
        ['1' if flag else '0' for flag in block.stationary.tolist()],
    ]


def digits(values: NDArray[np.float64]) -> list[str]:
    """Return each value in as many digits as it takes to read the same double back.

    What repeats is written once: digits take most of the time, and much rests.
    """
    bits: NDArray[Any] = np.ascontiguousarray(values).view(np.int64)
    new = np.flatnonzero(np.append(True, bits[1:] != bits[:-1])[: len(bits)])
    written = list(map(repr, values[new].tolist()))
    if len(new) == len(bits):
        return written
    repeated = np.array(written, dtype=object).repeat(np.diff(new, append=len(bits)))
    return list(repeated)


def lines(columns: Iterable[Sequence[str]], separator: str = ',') -> str:
    """Return columns of text as lines."""
    text = '\n'.join(map(separator.join, zip(*columns, strict=True)))
    return f'{text}\n' if text else ''


class OdometryLog:
    """Write a row of `LOG_COLUMNS` for each state, as it comes.

    Rows are written whole and reach the file line by line, so a log that is cut off ends with a
    complete row.
    """

    def __init__(self, path: Path) -> None:
        """Open ``path`` anew; raises `LogError` where that is not possible."""
        try:
            self._file: TextIO = path.open('w', encoding='utf-8', buffering=1)
        except OSError as error:
            raise LogError(
                f'pipeline.log_csv: {str(path)!r} can not be written ({error.strerror}); name a '
                'file in a folder that exists'
            ) from error
        self._acceleration: LinearAcceleration | None = None
        self._write(LOG_COLUMNS)

    def stage(self) -> Stage:
        """Return what the log takes from a chain: it gives nothing back."""
        return {ACCELERATION: self._remember, ODOMETRY: self._log}

    def _remember(self, acceleration: LinearAcceleration) -> tuple[()]:
        self._acceleration = acceleration
        return ()

    def _log(self, state: NavigationState) -> tuple[()]:
        acceleration, last = (nan, nan, nan), self._acceleration
        if last is not None and last.stamp_ns == state.stamp_ns:
            acceleration = last.acceleration
        self._write((*odometry_row(state), *acceleration, yaw_from_quaternion(state.attitude)))
        return ()

    def _write(self, row: tuple[object, ...]) -> None:
        self._file.write(','.join(map(str, row)) + '\n')

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def stop_after(duration: float, stop: Callable[[], None]) -> Stage:
    """Return a stage that calls ``stop`` once states cover ``duration`` [s], by their stamps.

    Stamps that go back begin anew.
    """
    first_ns: int | None = None

    def look(state: NavigationState) -> tuple[()]:
        nonlocal first_ns
        if first_ns is None or state.stamp_ns < first_ns:
            first_ns = state.stamp_ns
        if state.stamp_ns - first_ns >= duration * 1e9:
            stop()
        return ()

    return {ODOMETRY: look}
