"""The cases that the demo shows: what moves, with which settings, and what is worth a look."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from dead_reckoning.tools.demo.recording import Recording


@dataclass(frozen=True)
class Case:
    """One run of the demo; ``parameters`` go to every node, full keys."""

    name: str
    title: str
    words: str
    parameters: Mapping[str, Any]
    duration: float
    """How long to record [s]."""
    axis: int
    """Axis of the motion, 0 for x."""


@dataclass(frozen=True)
class Row:
    """One line of the table: a quantity, true and estimated, and what the error means."""

    quantity: str
    unit: str
    truth: float
    estimate: float

    @property
    def error(self) -> float:
        """Estimate minus truth."""
        return self.estimate - self.truth


SLIDE = Case(
    name='slide',
    title='Slide of 0.5 m',
    words='A ±1.5 g MMA7260QT behind a 12-bit ADC rests, slides from A to B, and rests again: '
    "AN3397's figure 8. Offset, scale error, noise and quantisation are on; the driver "
    'calibrates at rest, gravity is removed, the trapezoid integrates twice, and the '
    'movement-end check returns the velocity to zero.',
    parameters={
        'driver.motion': 'slide',
        'driver.slide.distance': 0.5,
        'driver.slide.duration': 1.0,
        'driver.slide.start': 4.0,
        'driver.wait_for_subscribers': 1,
    },
    duration=6.5,
    axis=0,
)

CASES = (SLIDE,)


def compare(case: Case, recording: Recording) -> list[Row]:
    """Set what was estimated beside the truth."""
    estimate, truth = recording.estimate, recording.truth_at_estimate
    along = case.axis
    across = [axis for axis in range(3) if axis != along]
    peak = int(np.argmax(np.abs(truth.velocity[:, along])))
    return [
        Row('displacement', 'm', truth.position[-1, along], estimate.position[-1, along]),
        Row(
            'sideways and up',
            'm',
            float(np.linalg.norm(truth.position[-1, across])),
            float(np.linalg.norm(estimate.position[-1, across])),
        ),
        Row('peak velocity', 'm/s', truth.velocity[peak, along], estimate.velocity[peak, along]),
        Row('velocity at the end', 'm/s', truth.velocity[-1, along], estimate.velocity[-1, along]),
    ]
