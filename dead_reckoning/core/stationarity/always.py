"""No detector: the velocity is always known to ``navigator.stance_velocity``."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import ClassVar

from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.stationarity import Watch


@dataclass(frozen=True, kw_only=True)
class AlwaysSettings(Settings, prefix='navigator.always'):
    """It has none."""


class Always:
    """Hold every sample for rest: a body in a hand never gets fast, so its velocity is bounded.

    With a `stance_velocity` and a `correlation` that say how fast it gets and for how long, that
    bound levels the attitude as a low-pass of the specific force in the world would, with the gain
    of the filter.
    """

    Settings: ClassVar[type[Settings]] = AlwaysSettings
    delay = 0

    def __init__(self, settings: AlwaysSettings, watch: Watch) -> None:
        """Take nothing from either."""

    def reset(self) -> None:
        """Have nothing to forget."""

    def take(self, samples: Array, verdicts: Array) -> None:
        """Judge samples, as `StationarityDetector` has it."""
        verdicts[:] = (0.0, inf, 1.0)


DETECTOR = Always
