"""How to look at a run: which numbers to set side by side, which pictures to draw."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np

from dead_reckoning.core.stages import ACCELERATION, DISTANCE, ODOMETRY, STEP_ODOMETRY, STEPS
from dead_reckoning.sources.motions import Steps
from dead_reckoning.tools.demo.recording import Array, Recording, Track


@dataclass(frozen=True)
class Row:
    """One line of a table: a quantity, true and estimated."""

    quantity: str
    unit: str
    truth: float
    estimate: float
    digits: int = 4

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """The line as text: name, truth, estimate, and estimate minus truth."""
        digits = self.digits
        # Zero is added, as it takes the sign off a zero.
        truth, estimate, error = (
            round(value, digits) + 0.0
            for value in (self.truth, self.estimate, self.estimate - self.truth)
        )
        name = f'{self.quantity} [{self.unit}]' if self.unit else self.quantity
        return name, f'{truth:.{digits}f}', f'{estimate:.{digits}f}', f'{error:+.{digits}f}'


class View(Protocol):
    """Makes a table, pictures and a remark of a recording."""

    @property
    def topics(self) -> tuple[str, ...]:
        """What has to be recorded, beside the truth."""

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
    topics: ClassVar[tuple[str, ...]] = (ODOMETRY, ACCELERATION)

    def rows(self, recording: Recording) -> list[Row]:
        """Set displacement and velocity beside the truth."""
        estimate = recording.track(ODOMETRY)
        truth = recording.truth.at(estimate.time)
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
        error, deviation = at_end(recording, ODOMETRY)
        return _of_attitude(abs(error[self.axis]), deviation[self.axis])


@dataclass(frozen=True)
class InPlane:
    """A motion in the plane of x and y."""

    digits: int = 4
    topics: ClassVar[tuple[str, ...]] = (ODOMETRY,)

    def rows(self, recording: Recording) -> list[Row]:
        """Set the end and the length of the way beside the truth."""
        estimate = recording.track(ODOMETRY)
        truth = recording.truth.at(estimate.time)
        return [
            *_end_of(truth, estimate, self.digits),
            Row('length of the way', 'm', truth.length, estimate.length, self.digits),
            *(
                Row(
                    f'greatest {axis}',
                    'm',
                    truth.position[:, k].max(),
                    estimate.position[:, k].max(),
                    self.digits,
                )
                for k, axis in enumerate('xy')
            ),
        ]

    def draw(self, name: str, recording: Recording, folder: Path) -> list[Path]:
        """Draw the way in the plane, and its distance from the truth over time."""
        from dead_reckoning.tools.demo import plots

        truth, estimate = recording.truth, recording.track(ODOMETRY)
        error = plots.save(
            folder / f'{name}-error.png', lambda axes: plots.error(axes, truth, estimate)
        )
        return [_draw_way(name, recording, ODOMETRY, folder), error]

    def remark(self, recording: Recording) -> str:
        """Compare the error at the end with the published deviation."""
        error, deviation = (float(np.linalg.norm(v[:2])) for v in at_end(recording, ODOMETRY))
        return _of_attitude(error, deviation)


@dataclass(frozen=True)
class AlongHeading(InPlane):
    """A motion in the plane, its distance integrated along the heading of a compass."""

    def remark(self, recording: Recording) -> str:
        """Compare the error at the end with the published deviation."""
        error, deviation = (float(np.linalg.norm(v[:2])) for v in at_end(recording, ODOMETRY))
        return (
            f'The end is {error:.2f} m off; the published deviation is {deviation:.2f} m. Each '
            'stop returns the velocity to zero, and the compass keeps the heading from drifting; '
            'what is left is its own error, and what tilt and sensitivity add between two stops.'
        )


@dataclass(frozen=True, eq=False)
class OnFoot:
    """A walk, whose true ``steps`` the motion knows."""

    steps: Steps
    topics: ClassVar[tuple[str, ...]] = (STEPS, DISTANCE, STEP_ODOMETRY)

    def rows(self, recording: Recording) -> list[Row]:
        """Set steps, distance and end beside the truth."""
        counted = recording.series[STEPS].values[-1, 0]
        distance = recording.series[DISTANCE].values[-1, 0]
        lengths = self.steps.lengths
        return [
            Row('steps', '', len(lengths), counted, digits=0),
            Row('distance', 'm', lengths.sum(), distance, digits=2),
            Row('length of a step', 'm', lengths.mean(), distance / max(counted, 1.0), digits=3),
            *_end_of(recording.truth, recording.track(STEP_ODOMETRY), digits=2),
        ]

    def draw(self, name: str, recording: Recording, folder: Path) -> list[Path]:
        """Draw steps over time, and the way in the plane."""
        from dead_reckoning.tools.demo import plots

        counted = recording.series[STEPS]
        picture = plots.save(
            folder / f'{name}-steps.png', lambda axes: plots.steps(axes, self.steps.times, counted)
        )
        return [picture, _draw_way(name, recording, STEP_ODOMETRY, folder)]

    def remark(self, recording: Recording) -> str:
        """Compare the error at the end with the published deviation."""
        walked = recording.track(STEP_ODOMETRY)
        error = walked.position[-1, :2] - recording.truth.position[-1, :2]
        deviation = walked.deviation[-1, :2]
        return (
            f'The end is {np.linalg.norm(error):.2f} m off; the published deviation is '
            f'{np.linalg.norm(deviation):.2f} m, most of it the 6 % by which the length of the '
            'steps is uncertain before `~/calibrate` has measured them over a known distance.'
        )


def at_end(recording: Recording, topic: str) -> tuple[Array, Array]:
    """Return how far off an Odometry ends, and its deviation there, shapes (3,) [m]."""
    estimate = recording.track(topic)
    truth = recording.truth.at(estimate.time)
    return estimate.position[-1] - truth.position[-1], estimate.deviation[-1]


def _end_of(truth: Track, estimate: Track, digits: int = 4) -> list[Row]:
    return [
        Row(f'{axis} at the end', 'm', truth.position[-1, k], estimate.position[-1, k], digits)
        for k, axis in enumerate('xy')
    ]


def _draw_way(name: str, recording: Recording, topic: str, folder: Path) -> Path:
    from dead_reckoning.tools.demo import plots

    truth, estimate = recording.truth, recording.track(topic)
    return plots.save(
        folder / f'{name}-way.png', lambda axes: plots.way(axes, truth, estimate), 4.6
    )


def _of_attitude(error: float, deviation: float) -> str:
    """Say how error and published deviation [m] compare, and why the latter is so large."""
    return (
        f'The end is {1000.0 * error:.1f} mm off; the published deviation is '
        f'{1000.0 * deviation:.0f} mm. It is that wide because nothing here measures the attitude '
        'while the sensor moves: a tilt of 1° alone, which the settings allow for, is 0.171 m/s² '
        'of gravity taken for motion, 8.6 m after 10 s without a stop.'
    )
