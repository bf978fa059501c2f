"""Judge how long a step is by the force in it: one module per model.

A module of this package offers ``MODEL``, an object that obeys `StepLengthModel`; the parameter
``pedometer.length_model`` chooses one by the name of its module.  Every model is its constant k
times what it makes of the step, so one calibration fits all.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module
from typing import Any, ClassVar, Protocol

from dead_reckoning.core.step_detectors import Step


class StepLengthModel(Protocol):
    """Length of a step [m] = k · `size`."""

    K: ClassVar[float]
    """Constant k before any calibration [UNIT]."""
    UNIT: ClassVar[str]
    """Unit of k."""

    def size(self, step: Step, height: float) -> float:
        """Return what the length is proportional to, finite and not negative [m/UNIT].

        ``height`` is that of the pedestrian [m].
        """


def names() -> tuple[str, ...]:
    """List the models there are."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(__path__)))


def model(name: str) -> Any:
    """Return a model by its name."""
    return import_module(f'{__name__}.{name}').MODEL
