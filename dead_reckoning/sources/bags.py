"""Read recorded Imu, Odometry and pose messages: ROS 1 ``.bag`` files and rosbag2 (sqlite3, mcap).

The only module that knows rosbags.  Samples keep the stamps of their headers and come in the order
of the recording, one at a time, so a recording may be larger than memory.  What a message does not
measure is None (REP-145).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from dead_reckoning.core.errors import DeadReckoningError, DependencyError, RecordingError
from dead_reckoning.core.rotation import matrix_from_quaternion, rotate, rotate_covariance
from dead_reckoning.core.samples import (
    NANOSECONDS,
    UNKNOWN,
    UNMEASURED_VARIANCE,
    ZERO,
    ImuSample,
    Matrix,
    NavigationState,
    Quaternion,
    Vector,
)

if TYPE_CHECKING:
    from rosbags.interfaces import Connection
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2

    Reader = Reader1 | Reader2

IMU = 'sensor_msgs/msg/Imu'
ODOMETRY = 'nav_msgs/msg/Odometry'
POSE = 'geometry_msgs/msg/PoseStamped'

SUFFIXES = ('.bag', '.mcap', '.db3')
_ALLOWED = 'name a .bag of ROS 1, a rosbag2 folder, or the .mcap or .db3 file in one'

Sample = TypeVar('Sample')


def topics(path: Path) -> dict[str, str]:
    """Return the topics of a recording and their message types; raises `RecordingError`."""
    with _explained(path), _reader(path) as reader:
        return _types(reader.connections)


def read_imu(path: Path, topic: str | None = None) -> Iterator[ImuSample]:
    """Read the sensor_msgs/Imu messages of a topic, or of the only such topic there is.

    Raises `RecordingError` at once where the file or the topic is at fault, and on the way where a
    message is.
    """
    return _read(path, topic, IMU, _imu_sample)


def read_odometry(path: Path, topic: str | None = None) -> Iterator[NavigationState]:
    """Read the nav_msgs/Odometry messages of a topic, or of the only such topic there is.

    The twist is turned into the world.  Raises `RecordingError` as `read_imu` does.
    """
    return _read(path, topic, ODOMETRY, _state)


def read_poses(path: Path, topic: str | None = None) -> Iterator[NavigationState]:
    """Read the geometry_msgs/PoseStamped messages of a topic, or of the only such topic there is.

    Of the states only stamp, position and attitude are known.  Raises `RecordingError` as
    `read_imu` does.
    """
    return _read(path, topic, POSE, _posed)


def _read(
    path: Path, topic: str | None, message_type: str, convert: Callable[[Any], Sample]
) -> Iterator[Sample]:
    with _explained(path):
        reader = _reader(path)
        reader.open()
        try:
            topic = _choose(path, _types(reader.connections), topic, message_type)
            deserialize = _deserializer(path, reader, topic, message_type)
        except BaseException:
            reader.close()
            raise

    def samples(reader: Reader) -> Iterator[Sample]:
        with _explained(path), closing(reader):
            chosen = [c for c in reader.connections if c.topic == topic]
            for _, _, data in reader.messages(chosen):
                yield convert(deserialize(data))

    return samples(reader)


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """Turn what goes wrong with a file into a `RecordingError` that names it."""
    try:
        yield
    except DeadReckoningError:
        raise
    except Exception as error:  # rosbags lets through whatever its parsers trip over
        raise RecordingError(
            f'{path}: {_reason(error)}; if the recording broke off, {_repair(path)}'
        ) from error


def _reason(error: Exception) -> str:
    said = ' '.join(str(part) for part in error.args) or type(error).__name__
    return said.rstrip('.')


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
        raise DependencyError(
            f'{path}: rosbags, which reads recordings, is not installed: pip install rosbags'
        ) from error
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


def _types(connections: Iterable[Connection]) -> dict[str, str]:
    return {c.topic: c.msgtype for c in connections}


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


def _deserializer(
    path: Path, reader: Reader, topic: str, message_type: str
) -> Callable[[bytes], Any]:
    """Return what turns the bytes of a topic into messages of a standard type.

    The definitions of these types never changed, so those in the recording need not be parsed;
    a checksum that differs shows a type that only has the name.
    """
    from rosbags.typesys import Stores, get_typestore

    if _is_ros1(path):
        store = get_typestore(Stores.ROS1_NOETIC)
        checksum, deserialize = store.generate_msgdef(message_type)[1], store.deserialize_ros1
    else:
        store = get_typestore(Stores.ROS2_JAZZY)
        checksum, deserialize = store.hash_rihs01(message_type), store.deserialize_cdr
    for connection in reader.connections:
        if connection.topic == topic and connection.digest not in (checksum, '', '*'):
            raise RecordingError(
                f'{path}: {topic} holds a {message_type} other than the standard one '
                f'(checksum {connection.digest}, not {checksum})'
            )
    return lambda data: deserialize(data, message_type)


def _imu_sample(message: Any) -> ImuSample:
    orientation = _quaternion(message.orientation)
    orientation_covariance = _matrix(message.orientation_covariance)
    # Four zeros are no rotation: what a driver leaves that never fills the field.
    oriented = orientation_covariance[0] >= 0.0 and orientation != (0.0, 0.0, 0.0, 0.0)
    rate_covariance = _matrix(message.angular_velocity_covariance)
    turning = rate_covariance[0] >= 0.0
    return ImuSample(
        _stamp_ns(message.header),
        message.header.frame_id,
        _vector(message.linear_acceleration),
        _matrix(message.linear_acceleration_covariance),
        _vector(message.angular_velocity) if turning else None,
        rate_covariance if turning else UNKNOWN,
        orientation if oriented else None,
        orientation_covariance if oriented else UNKNOWN,
    )


def _state(message: Any) -> NavigationState:
    pose, twist = message.pose.pose, message.twist.twist
    attitude = _quaternion(pose.orientation)
    rot_wb = matrix_from_quaternion(attitude)
    pose_covariance = message.pose.covariance.reshape(6, 6)
    twist_covariance = message.twist.covariance.reshape(6, 6)
    turning = twist_covariance[3, 3] < UNMEASURED_VARIANCE
    return NavigationState(
        _stamp_ns(message.header),
        _vector(pose.position),
        rotate(rot_wb, _vector(twist.linear)),
        attitude,
        _matrix(pose_covariance[:3, :3]),
        rotate_covariance(rot_wb, _matrix(twist_covariance[:3, :3])),
        _matrix(pose_covariance[3:, 3:]),
        _vector(twist.angular) if turning else None,
        _matrix(twist_covariance[3:, 3:]) if turning else UNKNOWN,
    )


def _posed(message: Any) -> NavigationState:
    return NavigationState(
        _stamp_ns(message.header),
        _vector(message.pose.position),
        ZERO,
        _quaternion(message.pose.orientation),
    )


def _stamp_ns(header: Any) -> int:
    return int(header.stamp.sec) * NANOSECONDS + int(header.stamp.nanosec)


def _vector(message: Any) -> Vector:
    return (message.x, message.y, message.z)


def _quaternion(message: Any) -> Quaternion:
    return (message.x, message.y, message.z, message.w)


def _matrix(array: Any) -> Matrix:
    numbers: Matrix = tuple(array.ravel().tolist())
    return numbers
