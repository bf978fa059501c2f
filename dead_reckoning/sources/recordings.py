"""Open a recording for replay: which of its topics is the Imu, and its samples in blocks."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from dead_reckoning.core.blocks import ImuBlock, Stamped
from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.parameters import Parts
from dead_reckoning.core.stages import BESIDE, COMPASS, IMU, RAW
from dead_reckoning.sources import bags
from dead_reckoning.sources.csv_recording import CsvRecording

Flow = Iterator[tuple[tuple[str, ...], ImuBlock | Stamped]]


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
    path: Path, inputs: Collection[str], parts: Parts, imu: str | None, rate: float | None
) -> Recording:
    """Open a bag or a CSV table; ``inputs`` are the topics of the chain, ``imu`` that of the bag.

    Raises `InputError` or `RecordingError`, at once or on the way.
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
    chosen = choose(path, bags.topics(path), inputs, imu)
    length = bags.count(path, chosen)
    if not length:
        raise RecordingError(f'{path}: no message on {", ".join(sorted(chosen))}')
    blocks = ((chosen[topic], block) for topic, block in bags.read_blocks(path, chosen))
    return Recording(blocks, length, namespace(chosen))


def choose(
    path: Path, types: Mapping[str, str], inputs: Collection[str], imu: str | None
) -> dict[str, tuple[str, ...]]:
    """Return which topics of a bag go to which inputs of the chain.

    An Imu is the named topic, else the one of the input's own name in any namespace, else the only
    one there is.  The compass is taken where it is found by its name.
    """
    imus = sorted(topic for topic, kind in types.items() if kind == bags.IMU)
    listed = ', '.join(f'{name} ({kind})' for name, kind in sorted(types.items())) or 'no topic'
    if imu is not None and imu not in imus:
        what = f'holds {types[imu]}, not {bags.IMU}' if imu in types else 'is not in it'
        raise RecordingError(f'{path}: --imu {imu} {what}; there is {listed}')
    if not imus:
        raise RecordingError(f'{path}: no topic holds {bags.IMU}; there is {listed}')
    chosen: dict[str, list[str]] = {}
    for name in inputs:
        if name in BESIDE:
            continue
        fitting = [imu] if imu else [t for t in imus if _is(t, name)]
        fitting = fitting or [t for t in imus if not _is(t, COMPASS)]
        if len(fitting) != 1:
            raise RecordingError(
                f'{path}: {name} may be any of {", ".join(fitting or imus)}; name one with --imu'
            )
        chosen.setdefault(fitting[0], []).append(name)
    if COMPASS in inputs:
        compasses = [t for t in imus if _is(t, COMPASS) and t not in chosen]
        near = [t for t in compasses if t == f'{namespace(chosen)}{COMPASS}']
        for topic in near or (compasses if len(compasses) == 1 else []):
            chosen[topic] = [COMPASS]
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
