"""Build what finds rest, from the settings."""

from __future__ import annotations

from collections.abc import Sequence

from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigation.vote import Vote
from dead_reckoning.core.parameters import Settings
from dead_reckoning.core.stationarity import StationarityDetector, Watch, detector_class


def detector_of(
    settings: NavigatorSettings, of_detectors: Sequence[Settings], gravity: float, rate: float
) -> StationarityDetector | Vote:
    """Return the detector, or several that vote, for ``rate`` samples a second [Hz].

    ``of_detectors`` are their settings, in order; where there are none, the defaults.
    """
    half = max(1, round(0.5 * settings.window * rate - 0.01))
    total = int(settings.look_ahead * rate + 1e-6)
    ahead = min(half, total)
    watch = Watch(
        2 * half - ahead,
        ahead,
        max(1, min(round(settings.minimum * rate), total - ahead + 1)),
        settings.hysteresis,
        round(settings.memory * rate),
        settings.rest_factor,
        gravity,
    )
    classes = [detector_class(name) for name in settings.detector]
    given = of_detectors or [kind.Settings() for kind in classes]
    made: list[StationarityDetector] = [
        kind(own, watch) for kind, own in zip(classes, given, strict=True)
    ]
    return made[0] if len(made) == 1 else Vote(made, settings.votes or len(made))
