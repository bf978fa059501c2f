"""How to look at a run: which numbers to set side by side, which pictures to draw."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from dead_reckoning.tools.demo.recording import Recording


@dataclass(frozen=True)
class Row:
    """One line of a table: a quantity, true and estimated."""

    quantity: str
    unit: str
    truth: float
    estimate: float

    @property
    def error(self) -> float:
        """Estimate minus truth."""
        return self.estimate - self.truth


class View(Protocol):
    """Makes a table, pictures and a remark of a recording."""

    def rows(self, recording: Recording) -> list[Row]:
        """Set what was estimated beside the truth."""

    def draw(self, name: str, recording: Recording, folder: Path) -> list[Path]:
        """Draw the pictures of the run ``name`` into a folder; return their paths."""

    def remark(self, recording: Recording) -> str:
        """Say what error and published deviation mean here."""


@dataclass(frozen=True)
class AlongAxis:
    """A motion along one axis of the world: 0 for x."""

    axis: int

    def rows(self, recording: Recording) -> list[Row]:
        """Set displacement and velocity beside the truth."""
        estimate, truth = recording.estimate, recording.truth_at_estimate
        along = self.axis
        across = [axis for axis in range(3) if axis != along]
        peak = int(np.argmax(np.abs(truth.velocity[:, along])))
        return [
            Row('displacement', 'm', truth.position[-1, along], estimate.position[-1, along]),
            Row(
                'off the axis',
                'm',
                float(np.linalg.norm(truth.position[-1, across])),
                float(np.linalg.norm(estimate.position[-1, across])),
            ),
            Row(
                'peak velocity', 'm/s', truth.velocity[peak, along], estimate.velocity[peak, along]
            ),
            Row(
                'velocity at the end',
                'm/s',
                truth.velocity[-1, along],
                estimate.velocity[-1, along],
            ),
        ]

    def draw(self, name: str, recording: Recording, folder: Path) -> list[Path]:
        """Draw acceleration, velocity and position over time."""
        from dead_reckoning.tools.demo import plots

        return [
            plots.save(
                folder / f'{name}-{quantity}.png', lambda axes, d=d: d(axes, recording, self.axis)
            )
            for quantity, d in (
                ('acceleration', plots.acceleration),
                ('velocity', plots.velocity),
                ('position', plots.position),
            )
        ]

    def remark(self, recording: Recording) -> str:
        """Compare the error of the displacement with the published deviation."""
        error = recording.error_at_end[self.axis]
        return deviation_remark(abs(error), recording.estimate.deviation[-1, self.axis])


@dataclass(frozen=True)
class InPlane:
    """A motion in the plane of x and y."""

    def rows(self, recording: Recording) -> list[Row]:
        """Set the end and the length of the way beside the truth."""
        estimate, truth = recording.estimate, recording.truth_at_estimate
        return [
            Row('x at the end', 'm', truth.position[-1, 0], estimate.position[-1, 0]),
            Row('y at the end', 'm', truth.position[-1, 1], estimate.position[-1, 1]),
            Row('length of the way', 'm', truth.length, estimate.length),
            Row('greatest x', 'm', truth.position[:, 0].max(), estimate.position[:, 0].max()),
            Row('greatest y', 'm', truth.position[:, 1].max(), estimate.position[:, 1].max()),
        ]

    def draw(self, name: str, recording: Recording, folder: Path) -> list[Path]:
        """Draw the way in the plane, and its distance from the truth over time."""
        from dead_reckoning.tools.demo import plots

        return [
            plots.save(folder / f'{name}-way.png', lambda axes: plots.way(axes, recording), 4.6),
            plots.save(folder / f'{name}-error.png', lambda axes: plots.error(axes, recording)),
        ]

    def remark(self, recording: Recording) -> str:
        """Compare the error at the end with the published deviation."""
        error = float(np.linalg.norm(recording.error_at_end[:2]))
        return deviation_remark(error, float(np.linalg.norm(recording.estimate.deviation[-1, :2])))


def deviation_remark(error: float, deviation: float) -> str:
    """Say how error and published deviation [m] compare, and why the latter is so large."""
    return (
        f'The end is {1000.0 * error:.1f} mm off; the published deviation is '
        f'{1000.0 * deviation:.0f} mm. It is that wide because nothing here measures the attitude '
        'while the sensor moves: a tilt of 1° alone, which the settings allow for, is 0.171 m/s² '
        'of gravity taken for motion, 8.6 m after 10 s without a stop.'
    )
