"""A slide from A to B along one axis: AN3397's figure 8, an acceleration that flips and ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dead_reckoning.core.parameters import Settings, parameter
from dead_reckoning.sources.motions import NO_STEPS, Array, Kinematics, kinematics
from dead_reckoning.sources.paths import Path


@dataclass(frozen=True, kw_only=True)
class SlideSettings(Settings, prefix='driver.slide'):
    """A slide: rest, from A to B, rest."""

    distance: float = parameter(
        0.5, 'From A to B; negative slides backward', unit='m', minimum=-1000.0, maximum=1000.0
    )
    duration: float = parameter(
        1.0, 'How long the slide takes', unit='s', minimum=0.01, maximum=1000.0
    )
    axis: str = parameter('x', 'Axis of the table along which it goes', choices=('x', 'y', 'z'))
    start: float = parameter(3.0, 'Rest before the slide', unit='s', minimum=0.0, maximum=1000.0)


class Slide:
    """The smoothest way from A to B: the polynomial of least jerk.

    With ``τ = (t − start)/duration``: ``s = distance · (10τ³ − 15τ⁴ + 6τ⁵)``; position, velocity
    and acceleration are continuous (Flash and Hogan 1985,
    doi:10.1523/JNEUROSCI.05-07-01688.1985).
    """

    Settings: ClassVar[type[Settings]] = SlideSettings
    steps = NO_STEPS

    def __init__(self, settings: SlideSettings) -> None:
        self.duration = settings.start + settings.duration
        ends = np.outer([0.0, settings.distance], np.eye(3)['xyz'.index(settings.axis)])
        self._path = Path([settings.start, self.duration], ends)

    def at(self, time: Array) -> Kinematics:
        """Return the truth at ``time``, shape (n,) [s]."""
        return kinematics(*self._path.at(time))


MOTION = Slide
