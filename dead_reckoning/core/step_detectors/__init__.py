"""Find the steps of a walk in the magnitude of a specific force: one module per method.

A module of this package offers ``DETECTOR``, a class that obeys `StepDetector`; the parameter
``pedometer.method`` chooses one by the name of its module.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, Protocol

from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.step_window import StepWindow


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One step, from landing to landing, as a detector found it.

    ``stamp_ns``
        when it ended [ns].
    ``duration``
        time since the step before it [s].
    ``samples``
        magnitudes of the specific force that belong to it [m/s²], in order.
    ``interval``
        time between these [s].

    The first step of a walk has no step before it; it comes together with the second, and is held
    to be as long.
    """

    stamp_ns: int
    duration: float
    samples: tuple[float, ...]
    interval: float


class StepDetector(Protocol):
    """Find steps in magnitudes that come at a rate of the detector's own choice.

    Built from its own settings, whose prefix is ``pedometer.`` and the name of the module, and
    from the window of time that the user sets for all of them.
    """

    Settings: ClassVar[type[Settings]]
    RATE: ClassVar[int]
    """Samples per second it wants [Hz]."""
    KERNELS: ClassVar[tuple[tuple[Callable[..., Any], tuple[Any, ...]], ...]]
    """The kernels that it calls, each with arguments for which it can be compiled; where there are
    any, the resampler before it calls one too."""

    walking: bool
    """Whether a walk goes on."""

    def __init__(self, settings: Any, window: StepWindow) -> None:
        """Build it from its settings and the window."""

    def configure(self, settings: Any) -> None:
        """Take over changed settings without touching the walk."""

    def reset(self) -> None:
        """Forget the walk and all samples."""

    def update(self, stamp_ns: int, magnitude: float) -> list[Step]:
        """Take the next magnitude [m/s²]; return the steps it proves, in order of time."""

    def finish(self) -> list[Step]:
        """Return the steps that are sure but wait, as no magnitude follows; forget the walk."""


def names() -> tuple[str, ...]:
    """List the methods there are."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def detector_class(name: str) -> Any:
    """Return the class of a method by its name."""
    return import_module(f'{__name__}.{name}').DETECTOR
