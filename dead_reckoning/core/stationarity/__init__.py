"""Find out when the body rests: one module per detector.

A module of this package offers ``DETECTOR``, a class that obeys `StationarityDetector`; the
parameter ``navigator.detector`` chooses one by the name of its module.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.parameters import Settings

STATISTIC, THRESHOLD, STATIONARY = range(3)
"""Columns of what a detector says of a sample; the last is 1 at rest, else 0."""


class Watch(NamedTuple):
    """How a detector looks, in samples, and what it has to know of the sensor.

    ``behind``, ``ahead``   samples of its window before and after the one it judges.
    ``minimum``       samples of the shortest rest.
    ``hysteresis``    so many times the threshold ends a rest.
    ``memory``        samples over which the threshold follows the swings.
    ``factor``        so many times what a known rest showed is rest still.
    ``gravity``       magnitude of the specific force at rest [m/s²].
    """

    behind: int
    ahead: int
    minimum: int
    hysteresis: float
    memory: int
    factor: float
    gravity: float

    @property
    def delay(self) -> int:
        """Samples by which a verdict comes late."""
        return self.ahead + self.minimum - 1


class StationarityDetector(Protocol):
    """Judge samples one by one or many at once, with the same result.

    Built from its own settings, whose prefix is ``navigator.`` and the name of the module, and
    from what all detectors have in common.
    """

    Settings: ClassVar[type[Settings]]

    delay: int
    """Samples by which a verdict comes late."""

    def __init__(self, settings: Any, watch: Watch) -> None:
        """Build it from its settings and what all have in common."""

    def reset(self) -> None:
        """Forget all samples."""

    def learn(self, rest: NDArray[np.float64]) -> None:
        """Find out the noise from samples at rest, shape (n, ≥ 7), as `take` has them.

        The samples that were taken so far are not forgotten.
        """

    def take(self, samples: NDArray[np.float64], verdicts: NDArray[np.float64]) -> None:
        """Judge samples, shape (n, ≥ 7): time step, specific force [m/s²], rate [rad/s].

        ``verdicts``, shape (n, 3), gets in row k statistic, threshold and verdict of the sample
        ``delay`` before; NaN where there is none.
        """


def names() -> tuple[str, ...]:
    """List the detectors there are."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def detector_class(name: str) -> Any:
    """Return the class of a detector by its name."""
    return import_module(f'{__name__}.{name}').DETECTOR
