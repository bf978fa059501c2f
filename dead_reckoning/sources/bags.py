"""Read Imu, Odometry, twists and poses, ROS 1 ``.bag`` or rosbag2 (sqlite3, mcap); write mcap.

The only module that knows rosbags.  Samples keep the stamps of their headers and come in the order
of the recording, one or a block at a time, so a recording may be larger than memory.  What a
message does not measure is None (REP-145).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from functools import cache
from itertools import groupby, islice
from operator import itemgetter, methodcaller
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from dead_reckoning import wire
from dead_reckoning.block_wire import decode_imus
from dead_reckoning.core.blocks import ImuBlock, Listed, Stamped
from dead_reckoning.core.errors import (
    DeadReckoningError,
    DependencyError,
    RecordingError,
    WireError,
)
from dead_reckoning.core.samples import ImuSample, NavigationState

if TYPE_CHECKING:
    from rosbags.interfaces import Connection
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2

    Reader = Reader1 | Reader2

IMU = 'sensor_msgs/msg/Imu'
ODOMETRY = 'nav_msgs/msg/Odometry'
POSE = 'geometry_msgs/msg/PoseStamped'
POSE_WITH_COVARIANCE = 'geometry_msgs/msg/PoseWithCovarianceStamped'
TWIST = 'geometry_msgs/msg/TwistWithCovarianceStamped'

CHECKSUMS = {
    IMU: (
        'RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b',
        '6a62c6daae103f4ff57a132d6f95cec2',
    ),
    ODOMETRY: (
        'RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0',
        'cd5e73d190d741a2f92e81eda573aca7',
    ),
    POSE: (
        'RIHS01_10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8',
        'd3812c3cbc69362b77dc0b19b345f8f5',
    ),
    POSE_WITH_COVARIANCE: (
        'RIHS01_26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e',
        '953b798c0f514ff060a53a3498ce6246',
    ),
    TWIST: (
        'RIHS01_77b67434531e6529b7a0091357b186b6ebdb17fd9ffd3e0c7ce9d3fb11a44563',
        '8927a1a12fb2607ceea095b2dc440a96',
    ),
}
"""Those of the standard types, of ROS 2 and of ROS 1.

Their definitions never changed, so those in a recording need not be parsed; another checksum shows
a type that only has the name.
"""

BLOCK = 4096
"""Most messages of a block: enough that a block costs nothing, and few for the cache."""


SHOWN = 300
"""How many characters are shown of what a parser says; some show all that they tripped over."""

SUFFIXES = ('.bag', '.mcap', '.db3')
_ALLOWED = 'name a .bag of ROS 1, a rosbag2 folder, or the .mcap or .db3 file in one'

Sample = TypeVar('Sample')
Part: TypeAlias = ImuBlock | Listed | Stamped
Converter: TypeAlias = Callable[[str, Sequence[bytes]], Sequence[bytes]]

AIDING: dict[str, Callable[[bytes], Any]] = {
    ODOMETRY: wire.decode_odometry_twist,
    POSE_WITH_COVARIANCE: wire.decode_pose_with_covariance,
    TWIST: wire.decode_twist,
}
"""What reads a message that may aid a navigator, by its type."""


def topics(path: Path) -> dict[str, str]:
    """Return the topics of a recording and their message types; raises `RecordingError`."""
    with _explained(path), _reader(path) as reader:
        return {c.topic: c.msgtype for c in reader.connections}


def count(path: Path, topics: Collection[str]) -> int:
    """Return how many messages some topics have; raises `RecordingError`."""
    with _explained(path), _reader(path) as reader:
        return sum(c.msgcount for c in reader.connections if c.topic in topics)


def read_imu(path: Path, topic: str | None = None) -> Iterator[ImuSample]:
    """Read the sensor_msgs/Imu messages of a topic, or of the only such topic there is.

    Raises `RecordingError` at once where the file or the topic is at fault, and on the way where a
    message is.
    """
    return _read(path, topic, IMU, wire.decode_imu)


def read_odometry(path: Path, topic: str | None = None) -> Iterator[NavigationState]:
    """Read the nav_msgs/Odometry messages of a topic, or of the only such topic there is.

    The twist is turned into the world.  Raises `RecordingError` as `read_imu` does.
    """
    return _read(path, topic, ODOMETRY, wire.decode_odometry)


def read_poses(path: Path, topic: str | None = None) -> Iterator[NavigationState]:
    """Read the geometry_msgs/PoseStamped messages of a topic, or of the only such topic there is.

    Of the states only stamp, position and attitude are known.  Raises `RecordingError` as
    `read_imu` does.
    """
    return _read(path, topic, POSE, wire.decode_pose)


def read_messages(path: Path, topics: Collection[str]) -> Iterator[tuple[str, int, bytes]]:
    """Read the messages of some topics as little-endian CDR, in the order of the recording.

    Each comes with its topic and when it was recorded [ns].  Raises `RecordingError` as
    `read_imu` does.
    """
    reader, connections, convert = _open(path, topics)

    def messages() -> Iterator[tuple[str, int, bytes]]:
        with _explained(path), closing(reader):
            count = 0
            for connection, time_ns, data in reader.messages(connections):
                (cdr,) = convert(connection.msgtype, (data,))
                yield connection.topic, time_ns, cdr
                count += 1
            _check_all(connections, count)

    return messages()


def read_blocks(path: Path, topics: Collection[str]) -> Iterator[tuple[str, Part]]:
    """Read the messages of some topics in blocks, each with its topic.

    They are sensor_msgs/Imu, or what may aid a navigator, of whose Odometry the twist is taken.  A
    block ends where another topic or another frame_id follows.  A message that can't be read is a
    `WireError`, stamped with when it was recorded.  Raises `RecordingError` as `read_imu` does.
    """
    reader, connections, convert = _open(path, topics)

    def blocks() -> Iterator[tuple[str, Part]]:
        with _explained(path), closing(reader):
            recorded, count = reader.messages(connections), 0
            while several := list(islice(recorded, BLOCK)):
                count += len(several)
                for connection, group in groupby(several, itemgetter(0)):
                    _, times, messages = zip(*group, strict=True)
                    kind = connection.msgtype
                    cdr = convert(kind, messages)
                    decoded = decode_imus(cdr) if kind == IMU else _decode(kind, cdr)
                    for index, made in decoded:
                        if isinstance(made, WireError):
                            yield connection.topic, Stamped(times[index], made)
                        else:
                            yield connection.topic, made
            _check_all(connections, count)

    return blocks()


def _decode(kind: str, messages: Sequence[bytes]) -> Iterator[tuple[int, Listed | WireError]]:
    """Yield messages, each with its number, as a sample or why it is none."""
    for index, data in enumerate(messages):
        try:
            yield index, Listed((AIDING[kind](data),))
        except WireError as error:
            yield index, error


def _read(
    path: Path, topic: str | None, message_type: str, decode: Callable[[bytes], Sample]
) -> Iterator[Sample]:
    topic = _choose(path, topics(path), topic, message_type)
    reader, connections, convert = _open(path, [topic])

    def samples() -> Iterator[Sample]:
        with _explained(path), closing(reader):
            count = 0
            for _, _, data in reader.messages(connections):
                yield decode(*convert(message_type, (data,)))
                count += 1
            _check_all(connections, count)

    return samples()


def _open(path: Path, chosen: Collection[str]) -> tuple[Reader, list[Connection], Converter]:
    """Open a recording; return it, some topics of it, and what makes little-endian CDR of them."""
    with _explained(path):
        reader = _reader(path)
        reader.open()
        try:
            connections = [c for c in reader.connections if c.topic in chosen]
            return reader, connections, _converter(path, connections)
        except BaseException:
            reader.close()
            raise


def _check_all(connections: Sequence[Connection], count: int) -> None:
    """Raise where fewer messages came than there are: rosbags passes over what is damaged."""
    expected = sum(connection.msgcount for connection in connections)
    if count < expected:
        raise ValueError(f'only {count} of {expected} messages can be read')


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """Turn what goes wrong with a file into a `RecordingError` that names it."""
    try:
        yield
    except WireError as error:
        raise RecordingError(f'{path}: {error}') from error
    except DeadReckoningError:
        raise
    except Exception as error:  # rosbags lets through whatever its parsers trip over
        raise RecordingError(
            f'{path}: {_reason(error)}; if the recording broke off, {_repair(path)}'
        ) from error


def _reason(error: Exception) -> str:
    """Return what an error says as the part of a line."""
    said = ' '.join(str(part) for part in error.args) or type(error).__name__
    said = ' '.join(said.split())
    return (said if len(said) <= SHOWN else f'{said[:SHOWN]}…').rstrip('.')


def _repair(path: Path) -> str:
    if _is_ros1(path):
        return '`rosbag reindex` may repair it'
    return '`ros2 bag reindex` or `mcap recover` may repair it'


def _is_ros1(path: Path) -> bool:
    return path.suffix == '.bag' and not path.is_dir()


def _reader(path: Path) -> Reader:
    try:
        from rosbags.rosbag1 import Reader as Reader1
        from rosbags.rosbag2 import Reader as Reader2
    except ImportError as error:
        raise _not_installed(path) from error
    if not path.exists():
        raise RecordingError(f'{path}: no such file or folder; {_ALLOWED}')
    if path.is_file() and path.suffix not in SUFFIXES:
        raise RecordingError(f'{path}: no recording; {_ALLOWED}')
    if path.is_dir() and not (path / 'metadata.yaml').exists():
        raise RecordingError(
            f'{path}: a folder without metadata.yaml is no rosbag2 recording; if the recording '
            'broke off, `ros2 bag reindex` writes one'
        )
    return Reader1(path) if _is_ros1(path) else Reader2(path)


def _not_installed(path: Path) -> DependencyError:
    return DependencyError(
        f'{path}: rosbags, which knows recordings, is not installed: pip install rosbags'
    )


def _choose(path: Path, types: dict[str, str], topic: str | None, wanted: str) -> str:
    """Return the topic to read, or raise `RecordingError` naming those there are."""
    listed = ', '.join(f'{name} ({kind})' for name, kind in sorted(types.items())) or 'no topic'
    fitting = sorted(name for name, kind in types.items() if kind == wanted)
    if topic is None:
        if len(fitting) == 1:
            return fitting[0]
        if fitting:
            raise RecordingError(
                f'{path}: {len(fitting)} topics hold {wanted}: {", ".join(fitting)}; name one'
            )
        raise RecordingError(f'{path}: no topic holds {wanted}; there is {listed}')
    if topic not in types:
        raise RecordingError(f'{path}: no topic {topic}; there is {listed}')
    if types[topic] != wanted:
        raise RecordingError(
            f'{path}: {topic} holds {types[topic]} where {wanted} is needed; there is {listed}'
        )
    return topic


def _converter(path: Path, connections: Sequence[Connection]) -> Converter:
    """Return what turns recorded bytes of a standard type into little-endian CDR."""
    ros1 = _is_ros1(path)
    for connection in connections:
        rihs01, md5 = CHECKSUMS[connection.msgtype]
        checksum = md5 if ros1 else rihs01
        if connection.digest not in (checksum, '', '*'):
            raise RecordingError(
                f'{path}: {connection.topic} holds a {connection.msgtype} other than the standard '
                f'one (checksum {connection.digest}, not {checksum})'
            )

    def convert_one(message_type: str, data: bytes) -> bytes:
        store = _typestore()
        try:
            if ros1:
                return bytes(store.ros1_to_cdr(data, message_type))
            message = store.deserialize_cdr(data, message_type)
            return bytes(store.serialize_cdr(message, message_type))
        except Exception:  # rosbags lets through whatever its parsers trip over
            return data  # which no decoder takes for a message

    is_fit = methodcaller('startswith', wire.LITTLE_ENDIAN[:2])

    def convert(message_type: str, messages: Sequence[bytes]) -> Sequence[bytes]:
        if ros1:
            return [convert_one(message_type, data) for data in messages]
        if all(map(is_fit, messages)):
            return messages
        return [data if is_fit(data) else convert_one(message_type, data) for data in messages]

    return convert


@cache
def _typestore() -> Any:
    """Return the messages of Jazzy, which take a tenth of a second; few recordings need them."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS2_JAZZY)


class BagWriter:
    """Write serialized messages as a rosbag2 recording in mcap: a folder, which must not exist."""

    def __init__(self, path: Path, topics: Mapping[str, tuple[str, bool]]) -> None:
        """``topics``: message type, and whether it is latched, by full name.

        Raises `DependencyError` where rosbags is not installed.
        """
        try:
            from rosbags.interfaces import (
                Qos,
                QosDurability,
                QosHistory,
                QosLiveliness,
                QosReliability,
                QosTime,
            )
            from rosbags.rosbag2 import StoragePlugin, Writer
        except ImportError as error:
            raise _not_installed(path) from error
        store = _typestore()
        self._writer = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        never = QosTime(*divmod(2**63 - 1, 10**9))

        def qos(latched: bool) -> Qos:
            return Qos(
                QosHistory.KEEP_LAST,
                1 if latched else 100,
                QosReliability.RELIABLE,
                QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
                never,
                never,
                QosLiveliness.AUTOMATIC,
                never,
                False,
            )

        self._connections = {
            topic: self._writer.add_connection(
                topic, message_type, typestore=store, offered_qos_profiles=[qos(latched)]
            )
            for topic, (message_type, latched) in topics.items()
        }

    def write(self, topic: str, stamp_ns: int, message: bytes) -> None:
        """Write a message that was recorded at a stamp [ns]; before 1970 counts as then."""
        self._writer.write(self._connections[topic], max(0, stamp_ns), message)

    def close(self) -> None:
        """Complete the recording."""
        self._writer.close()

    def abort(self) -> None:
        """Close the file as it is: no recording."""
        if self._writer.storage is not None:
            self._writer.storage.abort()
