"""Calibrate the models of step lengths on walks of known distances, all at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import ClassVar

from dead_reckoning.core import step_lengths
from dead_reckoning.core.step_detectors import Step
from dead_reckoning.core.step_lengths import StepLengthModel


class AllModels:
    """Takes the place of a pedometer's model, and notes what every model makes of each step.

    ``stamps_ns``
        when each step ended [ns].
    ``sizes``
        for each step those of `names`, in their order [m/UNIT].
    """

    K: ClassVar[float] = 1.0
    UNIT: ClassVar[str] = 'm'

    def __init__(self) -> None:
        self.names = step_lengths.names()
        self.stamps_ns: list[int] = []
        self.sizes: list[tuple[float, ...]] = []
        self._models: list[StepLengthModel] = [step_lengths.model(name) for name in self.names]

    def size(self, step: Step, height: float) -> float:
        """Note the step."""
        self.stamps_ns.append(step.stamp_ns)
        self.sizes.append(tuple(model.size(step, height) for model in self._models))
        return 1.0

    def totals(self) -> dict[str, float]:
        """Return the sum of the sizes of all steps for each model."""
        columns = zip(*self.sizes, strict=True) if self.sizes else [()] * len(self.names)
        return dict(zip(self.names, map(sum, columns), strict=True))


@dataclass(frozen=True)
class Fit:
    """What walks say of a model.

    ``k``
        makes all walks together as long as they were [UNIT].
    ``errors``
        of the distance of each walk, as a part of it, with the k of the other walks; of a single
        walk none can be told.
    """

    k: float
    errors: tuple[float, ...]

    @property
    def error(self) -> float:
        """Mean size of the errors; infinite where there are none."""
        return sum(map(abs, self.errors)) / len(self.errors) if self.errors else inf

    @property
    def worst(self) -> float:
        """Largest size of the errors; infinite where there are none."""
        return max(map(abs, self.errors), default=inf)


def fit(distances: Sequence[float], totals: Sequence[float]) -> Fit:
    """Fit the constant of a model to walks: their distances [m] and sums of sizes, all above 0."""
    distance, total = sum(distances), sum(totals)
    others = zip(distances, totals, strict=True) if len(distances) > 1 else ()
    return Fit(
        distance / total, tuple((distance - d) / (total - s) * s / d - 1.0 for d, s in others)
    )
