"""What one replay works on, as its outputs see it."""

from __future__ import annotations

from dataclasses import dataclass

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.sources.recordings import Recording
from dead_reckoning.tools.replay.summary import Summary


@dataclass(frozen=True)
class Task:
    """A recording on its way through a chain; ``summary`` grows meanwhile."""

    name: str
    configuration: Configuration
    pipeline: Pipeline
    recording: Recording
    summary: Summary
