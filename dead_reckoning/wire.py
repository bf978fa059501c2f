"""Read and write the few messages of the hot path as bytes: samples and states in and out.

A serialized message starts with four bytes that name the encoding, here little-endian CDR
(``00 01 00 00``), followed by the fields, each aligned to its size counted from there: a header
(int32, uint32, string), then runs of doubles.  So a message is one `struct` layout per length of
its frame ids.  What is not little-endian CDR raises `EncodingError`: nodes and bags bring it there
first, with the serialization they have.

Encoders write byte for byte what ``rclpy.serialization.serialize_message`` writes, but for the
padding, which rclpy leaves as it finds the memory and which is zero here.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from struct import Struct, error

from dead_reckoning.core.errors import EncodingError, WireError
from dead_reckoning.core.path import Path, Pose
from dead_reckoning.core.rotation import (
    matrix_from_quaternion,
    product,
    rotate,
    rotate_back,
    rotate_covariance,
    transposed,
)
from dead_reckoning.core.samples import (
    IDENTITY_QUATERNION,
    NANOSECONDS,
    NOT_MEASURED,
    UNKNOWN,
    UNMEASURED_VARIANCE,
    ZERO,
    ImuSample,
    LinearAcceleration,
    Matrix,
    NavigationState,
    PoseSample,
    VelocitySample,
)

LITTLE_ENDIAN = b'\x00\x01\x00\x00'

_STAMP = Struct('<iII')  # sec, nanosec, length of the frame id with its zero byte
_STAMP_AT = 4
_TEXT_AT = 16
_IMU = Struct('<37d')
_ACCELERATION = Struct('<42d')
_ODOMETRY = Struct('<85d')
_POSE = Struct('<7d')
_POSE_WITH_COVARIANCE = Struct('<43d')
_TWIST_WITH_COVARIANCE = Struct('<42d')
_UINT32 = Struct('<I')
_FLOAT64 = Struct('<d')
_NO_ANGLES = (0.0,) * 3


@lru_cache(maxsize=256)
def layout(doubles: int, *texts: str) -> tuple[Struct, bytes]:
    """Return the layout of a stamped message with its texts, and the texts as they stand in it."""
    body = bytearray(8)  # the stamp
    for text in texts:
        body += b'\0' * (-len(body) % 4)
        coded = text.encode() + b'\0'
        body += len(coded).to_bytes(4, 'little') + coded
    body += b'\0' * (-len(body) % 8)
    middle = bytes(body[8:])
    return Struct(f'<4siI{len(middle)}s{doubles}d'), middle


def require_little_endian(data: bytes) -> None:
    """Raise `EncodingError` for bytes that do not begin as little-endian CDR does."""
    if data[:2] != LITTLE_ENDIAN[:2]:
        raise EncodingError(f'{len(data)} bytes are no little-endian CDR')


def _no_message(data: bytes, kind: str, problem: Exception) -> WireError:
    return WireError(f'{len(data)} bytes are no {kind}: {problem}')


def _read(
    data: bytes, kind: str, layout: Struct, texts: int
) -> tuple[int, str, tuple[float, ...]]:
    """Return stamp [ns], first text and all doubles of a message."""
    require_little_endian(data)
    try:
        seconds, nanoseconds, length = _STAMP.unpack_from(data, _STAMP_AT)
        frame_id = data[_TEXT_AT : _TEXT_AT + length].partition(b'\0')[0].decode()
        at = 12 + length
        for _ in range(texts - 1):
            at += -at % 4
            at += 4 + int.from_bytes(data[4 + at : 8 + at], 'little')
        doubles = layout.unpack_from(data, 4 + at + -at % 8)
    except (error, UnicodeDecodeError) as problem:
        raise _no_message(data, kind, problem) from problem
    if nanoseconds >= NANOSECONDS:
        raise WireError(
            f'the stamp of a {kind} has {nanoseconds} ns beside its seconds, '
            'more than a second: check the driver'
        )
    return seconds * NANOSECONDS + nanoseconds, frame_id, doubles


def decode_imu(data: bytes) -> ImuSample:
    """Read a sensor_msgs/Imu; raises `WireError`.

    Orientation and angular velocity are None where their covariance starts with −1 (REP-145), the
    orientation also where all four numbers are zero.
    """
    stamp_ns, frame_id, d = _read(data, 'Imu', _IMU, 1)
    orientation = d[0:4]
    oriented = d[4] >= 0.0 and orientation != (0.0, 0.0, 0.0, 0.0)
    turning = d[16] >= 0.0
    return ImuSample(
        stamp_ns,
        frame_id,
        d[25:28],  # type: ignore[arg-type]
        d[28:37],  # type: ignore[arg-type]
        d[13:16] if turning else None,  # type: ignore[arg-type]
        d[16:25] if turning else UNKNOWN,  # type: ignore[arg-type]
        orientation if oriented else None,  # type: ignore[arg-type]
        d[4:13] if oriented else UNKNOWN,  # type: ignore[arg-type]
    )


def encode_imu(imu: ImuSample) -> bytes:
    """Write a sensor_msgs/Imu; what is None gets covariance[0] = −1."""
    packed, middle = layout(37, imu.frame_id)
    oriented, turning = imu.orientation is not None, imu.angular_velocity is not None
    return packed.pack(
        LITTLE_ENDIAN,
        *divmod(imu.stamp_ns, NANOSECONDS),
        middle,
        *(IDENTITY_QUATERNION if imu.orientation is None else imu.orientation),
        *(imu.orientation_covariance if oriented else NOT_MEASURED),
        *(ZERO if imu.angular_velocity is None else imu.angular_velocity),
        *(imu.angular_velocity_covariance if turning else NOT_MEASURED),
        *imu.specific_force,
        *imu.specific_force_covariance,
    )


def decode_acceleration(data: bytes) -> LinearAcceleration:
    """Read a geometry_msgs/AccelWithCovarianceStamped, its linear part; raises `WireError`."""
    stamp_ns, frame_id, d = _read(data, 'AccelWithCovarianceStamped', _ACCELERATION, 1)
    return LinearAcceleration(stamp_ns, frame_id, d[0:3], d[6:9] + d[12:15] + d[18:21])  # type: ignore[arg-type]


def encode_acceleration(sample: LinearAcceleration) -> bytes:
    """Write a geometry_msgs/AccelWithCovarianceStamped; its angular part is not measured."""
    packed, middle = layout(42, sample.frame_id)
    return packed.pack(
        LITTLE_ENDIAN,
        *divmod(sample.stamp_ns, NANOSECONDS),
        middle,
        *sample.acceleration,
        *_NO_ANGLES,
        *_blocks(sample.covariance, NOT_MEASURED),
    )


def decode_odometry(data: bytes) -> NavigationState:
    """Read a nav_msgs/Odometry, its twist turned into the world; raises `WireError`."""
    stamp_ns, _, d = _read(data, 'Odometry', _ODOMETRY, 2)
    attitude = d[3:7]
    rot_wb = matrix_from_quaternion(attitude)  # type: ignore[arg-type]
    pose, twist = d[7:43], d[49:85]
    measured = twist[21] < UNMEASURED_VARIANCE
    return NavigationState(
        stamp_ns,
        d[0:3],  # type: ignore[arg-type]
        rotate(rot_wb, d[43:46]),  # type: ignore[arg-type]
        attitude,  # type: ignore[arg-type]
        _first(pose),
        rotate_covariance(rot_wb, _first(twist)),
        _second(pose),
        d[46:49] if measured else None,  # type: ignore[arg-type]
        _second(twist) if measured else UNKNOWN,
        pose_cross_covariance=_cross(pose),
        twist_cross_covariance=product(rot_wb, _cross(twist)),
    )


def decode_pose(data: bytes) -> NavigationState:
    """Read a geometry_msgs/PoseStamped, of which no more is known; raises `WireError`."""
    stamp_ns, _, d = _read(data, 'PoseStamped', _POSE, 1)
    return NavigationState(stamp_ns, d[:3], ZERO, d[3:])  # type: ignore[arg-type]


def decode_twist(data: bytes) -> VelocitySample:
    """Read a geometry_msgs/TwistWithCovarianceStamped, its linear part; raises `WireError`."""
    kind = 'TwistWithCovarianceStamped'
    stamp_ns, frame_id, d = _read(data, kind, _TWIST_WITH_COVARIANCE, 1)
    return VelocitySample(stamp_ns, frame_id, d[:3], _first(d[6:]))  # type: ignore[arg-type]


def decode_odometry_twist(data: bytes) -> VelocitySample:
    """Read the linear twist of a nav_msgs/Odometry, in its child frame; raises `WireError`."""
    stamp_ns, _, d = _read(data, 'Odometry', _ODOMETRY, 2)
    at = _TEXT_AT + int.from_bytes(data[_TEXT_AT - 4 : _TEXT_AT], 'little')
    at += 4 + -at % 4
    child = data[at : at + int.from_bytes(data[at - 4 : at], 'little')].partition(b'\0')[0]
    try:
        frame_id = child.decode()
    except UnicodeDecodeError as problem:
        raise _no_message(data, 'Odometry', problem) from problem
    return VelocitySample(stamp_ns, frame_id, d[43:46], _first(d[49:]))  # type: ignore[arg-type]


def decode_pose_with_covariance(data: bytes) -> PoseSample:
    """Read a geometry_msgs/PoseWithCovarianceStamped; raises `WireError`."""
    kind = 'PoseWithCovarianceStamped'
    stamp_ns, frame_id, d = _read(data, kind, _POSE_WITH_COVARIANCE, 1)
    covariance = d[7:]
    return PoseSample(stamp_ns, frame_id, d[:3], _first(covariance), d[3:7], _second(covariance))  # type: ignore[arg-type]


def odometry_encoder(frame_id: str, child_frame_id: str) -> Callable[[NavigationState], bytes]:
    """Return a function that writes states as nav_msgs/Odometry between these two frames.

    The twist, its covariance too, is in the child frame.
    """
    packed, middle = layout(85, frame_id, child_frame_id)
    huge = UNMEASURED_VARIANCE
    unmeasured: Matrix = (huge, 0.0, 0.0, 0.0, huge, 0.0, 0.0, 0.0, huge)

    def encode(state: NavigationState) -> bytes:
        rot_wb = matrix_from_quaternion(state.attitude)
        rot_bw = transposed(rot_wb)
        turning = state.angular_velocity is not None
        of_twist = state.twist_cross_covariance
        if of_twist != UNKNOWN:
            of_twist = product(rot_bw, of_twist)
        return packed.pack(
            LITTLE_ENDIAN,
            *divmod(state.stamp_ns, NANOSECONDS),
            middle,
            *state.position,
            *state.attitude,
            *_blocks(
                state.position_covariance, state.attitude_covariance, state.pose_cross_covariance
            ),
            *rotate_back(rot_wb, state.velocity),
            *(ZERO if state.angular_velocity is None else state.angular_velocity),
            *_blocks(
                rotate_covariance(rot_bw, state.velocity_covariance),
                state.angular_velocity_covariance if turning else unmeasured,
                of_twist,
            ),
        )

    return encode


def path_encoder(frame_id: str) -> Callable[[Path], bytes]:
    """Return a function that writes paths as nav_msgs/Path, each pose in the same frame."""
    text = frame_id.encode() + b'\0'
    before = text + b'\0' * (-len(text) % 4)
    begin = 12 + len(before) + 4  # of the first pose; the others begin at multiples of 8
    first, later = (
        Struct(f'<iII{len(text) + (-at - 12 - len(text)) % 8}s7d') for at in (begin, 0)
    )

    def stamped(layout: Struct, pose: Pose) -> bytes:
        stamp_ns, position, attitude = pose
        return layout.pack(*divmod(stamp_ns, NANOSECONDS), len(text), text, *position, *attitude)

    def encode(path: Path) -> bytes:
        stamp = divmod(path.stamp_ns, NANOSECONDS)
        return b''.join(
            [
                LITTLE_ENDIAN,
                _STAMP.pack(*stamp, len(text)),
                before,
                _UINT32.pack(len(path.poses)),
                *[stamped(first, pose) for pose in path.poses[:1]],
                *[stamped(later, pose) for pose in path.poses[1:]],
            ]
        )

    return encode


def encode_bool(value: bool) -> bytes:
    """Write a std_msgs/Bool."""
    return LITTLE_ENDIAN + (b'\1\0\0\0' if value else b'\0\0\0\0')


def encode_uint32(value: int) -> bytes:
    """Write a std_msgs/UInt32."""
    return LITTLE_ENDIAN + _UINT32.pack(value)


def decode_uint32(data: bytes) -> int:
    """Read a std_msgs/UInt32; raises `WireError`."""
    return int(_read_one(data, 'UInt32', _UINT32))


def encode_float64(value: float) -> bytes:
    """Write a std_msgs/Float64."""
    return LITTLE_ENDIAN + _FLOAT64.pack(value)


def decode_float64(data: bytes) -> float:
    """Read a std_msgs/Float64; raises `WireError`."""
    return float(_read_one(data, 'Float64', _FLOAT64))


def _read_one(data: bytes, kind: str, layout: Struct) -> float:
    require_little_endian(data)
    try:
        return layout.unpack_from(data, 4)[0]  # type: ignore[no-any-return]
    except error as problem:
        raise _no_message(data, kind, problem) from problem


def _blocks(first: Matrix, second: Matrix, cross: Matrix = UNKNOWN) -> tuple[float, ...]:
    """Put two covariances, and that of both, shapes (3, 3), into one, shape (6, 6)."""
    c = cross
    return (
        *first[0:3], *c[0:3], *first[3:6], *c[3:6], *first[6:9], *c[6:9],
        *c[0:9:3], *second[0:3], *c[1:9:3], *second[3:6], *c[2:9:3], *second[6:9],
    )  # fmt: skip


def _first(covariance: tuple[float, ...]) -> Matrix:
    return covariance[0:3] + covariance[6:9] + covariance[12:15]  # type: ignore[return-value]


def _cross(covariance: tuple[float, ...]) -> Matrix:
    return covariance[3:6] + covariance[9:12] + covariance[15:18]  # type: ignore[return-value]


def _second(covariance: tuple[float, ...]) -> Matrix:
    return covariance[21:24] + covariance[27:30] + covariance[33:36]  # type: ignore[return-value]
