"""What is played of a recording: its Imu, and what aids a navigator."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.samples import NANOSECONDS
from dead_reckoning.core.stages import IMU
from dead_reckoning.sources.bags import read_messages

MARGIN = 1.0
"""Time [s] at both ends of the Imu in which nothing aids.

At first the navigator aligns, and a state has to come after all that aids it.
"""


def played(path: Path, topics: Mapping[str, str]) -> list[tuple[int, str, bytes]]:
    """Return when messages were recorded [ns], their names and bytes; ``topics`` by these names.

    Raises `RecordingError`.
    """
    names = {topic: name for name, topic in topics.items()}
    messages = [
        (time_ns, names[topic], data)
        for topic, time_ns, data in read_messages(path, list(topics.values()))
    ]
    times = [time_ns for time_ns, name, _ in messages if name == IMU]
    if not times:
        raise RecordingError(f'{path}: {topics[IMU]} holds no message')
    begin, end = times[0] + MARGIN * NANOSECONDS, times[-1] - MARGIN * NANOSECONDS
    return [one for one in messages if one[1] == IMU or begin < one[0] < end]
