"""Open a recording for replay: which of its topics is the Imu, and its samples in blocks."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from dead_reckoning.core.blocks import ImuBlock, Listed, Stamped
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.parameters import Parts
from dead_reckoning.core.stages import (
    AIDING_ODOMETRY,
    AIDING_POSE,
    AIDING_TWIST,
    BESIDE,
    COMPASS,
    IMU,
    RAW,
    SET_POSE,
)
from dead_reckoning.sources import bags
from dead_reckoning.sources.csv_recording import CsvRecording

Flow = Iterator[tuple[tuple[str, ...], ImuBlock | Listed | Stamped]]

NONE: Mapping[str, str] = MappingProxyType({})

TYPES = {
    RAW: bags.IMU,
    IMU: bags.IMU,
    COMPASS: bags.IMU,
    AIDING_TWIST: bags.TWIST,
    AIDING_ODOMETRY: bags.ODOMETRY,
    AIDING_POSE: bags.POSE_WITH_COVARIANCE,
    SET_POSE: bags.POSE_WITH_COVARIANCE,
}
"""Message types of the inputs of a chain."""


@dataclass(frozen=True)
class Recording:
    """Samples of a file for the inputs of a chain.

    ``blocks``
        in the order of the recording, each with the names of the inputs that take it; or what is
        wrong with a single message or row.
    ``length``
        how many messages or rows there are.
    ``namespace``
        that of its topics, which ends with a slash; None for a table, which has none.
    """

    blocks: Flow
    length: int
    namespace: str | None = None


def open_recording(
    path: Path,
    inputs: Collection[str],
    parts: Parts,
    imu: str | None,
    rate: float | None,
    remaps: Mapping[str, str] = NONE,
) -> Recording:
    """Open a bag or a CSV table; ``inputs`` are the topics of the chain, ``imu`` that of the bag.

    ``remaps`` are topics of the bag by the inputs that they go to.  Raises `InputError` or
    `RecordingError`, at once or on the way.
    """
    if path.suffix.lower() == '.csv' and not path.is_dir():
        table = CsvRecording(path, parts, rate)
        names = tuple(name for name in inputs if name not in BESIDE)
        return Recording(((names, block) for block in table.blocks()), len(table))
    if path.is_file() and path.suffix not in bags.SUFFIXES:
        raise RecordingError(
            f'{path}: no recording; name a .csv, a .bag of ROS 1, a rosbag2 folder, or the .mcap '
            'or .db3 file in one'
        )
    chosen = choose(path, bags.topics(path), inputs, imu, remaps)
    length = bags.count(path, chosen)
    if not length:
        raise RecordingError(f'{path}: no message on {", ".join(sorted(chosen))}')
    blocks = ((chosen[topic], block) for topic, block in bags.read_blocks(path, chosen))
    return Recording(blocks, length, namespace(chosen))


def choose(
    path: Path,
    types: Mapping[str, str],
    inputs: Collection[str],
    imu: str | None,
    remaps: Mapping[str, str] = NONE,
) -> dict[str, tuple[str, ...]]:
    """Return which topics of a bag go to which inputs of the chain.

    An Imu is the named topic, else the one of the input's own name in any namespace, else the only
    one there is.  What is beside it, compass and aiding, is the named topic, else taken where it
    is found by its name and type.
    """
    imus = sorted(topic for topic, kind in types.items() if kind == bags.IMU)
    listed = ', '.join(f'{name} ({kind})' for name, kind in sorted(types.items())) or 'no topic'

    def require(option: str, topic: str, kind: str) -> None:
        if types.get(topic) != kind:
            what = f'holds {types[topic]}, not {kind}' if topic in types else 'is not in it'
            raise RecordingError(f'{path}: {option}{topic} {what}; there is {listed}')

    if imu is not None:
        require('--imu ', imu, bags.IMU)
    for name, topic in remaps.items():
        if name not in inputs:
            raise RecordingError(f'--remap {name}: no such input; there are {", ".join(inputs)}')
        require(f'--remap {name}:=', topic, TYPES[name])
    if not imus:
        raise RecordingError(f'{path}: no topic holds {bags.IMU}; there is {listed}')
    chosen: dict[str, list[str]] = {}
    for name in inputs:
        if name in BESIDE:
            continue
        named = remaps.get(name, imu)
        fitting = [named] if named else [t for t in imus if _is(t, name)]
        fitting = fitting or [t for t in imus if not _is(t, COMPASS)]
        if len(fitting) != 1:
            raise RecordingError(
                f'{path}: {name} may be any of {", ".join(fitting or imus)}; name one with --imu'
            )
        chosen.setdefault(fitting[0], []).append(name)
    place = namespace(chosen)
    for name in inputs:
        if name not in BESIDE:
            continue
        fitting = [t for t, kind in types.items() if _is(t, name) and kind == TYPES[name]]
        fitting = [t for t in fitting if t not in chosen]
        near = [t for t in fitting if t == f'{place}{name}']
        found = near or (fitting if len(fitting) == 1 else [])
        for topic in [remaps[name]] if name in remaps else found:
            chosen.setdefault(topic, []).append(name)
    return {topic: tuple(names) for topic, names in chosen.items()}


def namespace(topics: Collection[str]) -> str:
    """Return the namespace of the first topic with a name of ours, which ends with a slash."""
    for topic in topics:
        for name in (RAW, IMU):
            if _is(topic, name):
                return topic.removesuffix(name)
    return '/'


def _is(topic: str, name: str) -> bool:
    return topic == name or topic.endswith(f'/{name}')
