"""The wire: byte for byte what rclpy writes, and of what it reads the right value or WireError."""

import math
import struct

import pytest
from geometry_msgs.msg import (
    AccelWithCovarianceStamped,
    PoseWithCovarianceStamped,
    TwistWithCovarianceStamped,
)
from hypothesis import example, given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry, Path
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import Imu
from std_msgs.msg import Bool, Float64, UInt32

from dead_reckoning import wire
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.errors import WireError
from dead_reckoning.core.path import Path as Way
from dead_reckoning.core.rotation import matrix_from_quaternion, rotate_back
from dead_reckoning.core.samples import UNKNOWN, ImuSample, LinearAcceleration, NavigationState
from dead_reckoning.core.stages import (
    ACCELERATION,
    AIDING_ODOMETRY,
    AIDING_POSE,
    AIDING_TWIST,
    IMU,
    ODOMETRY,
)
from dead_reckoning.nodes.topics import decoder
from dead_reckoning.topics import topics

SPOKEN = topics(FrameSettings())
decode_imu, decode_acceleration, decode_odometry = (
    decoder(SPOKEN[name]) for name in (IMU, ACCELERATION, ODOMETRY)
)
decode_twist, decode_wheels, decode_pose = (
    decoder(SPOKEN[name]) for name in (AIDING_TWIST, AIDING_ODOMETRY, AIDING_POSE)
)
"""What nodes read with: `wire`, and rclpy for what is no little-endian CDR."""

LENGTHS = range(81)
NANOSECONDS = 1_000_000_000
HUGE = wire.UNMEASURED_VARIANCE

numbers = st.floats()  # NaN and infinities too
stamps = st.integers(-(2**31) * NANOSECONDS, 2**31 * NANOSECONDS - 1)
texts = st.text(
    st.characters(exclude_characters='\0', exclude_categories=('Cs',)), min_size=0, max_size=40
)


def tuples(count, elements=numbers):
    return st.tuples(*[elements] * count)


variances = st.floats(0.0, 1e300)
covariances = st.tuples(variances, *[numbers] * 8)
quaternions = (
    tuples(4, st.floats(-1.0, 1.0))
    .filter(lambda q: math.hypot(*q) > 0.1)
    .map(lambda q: tuple(component / math.hypot(*q) for component in q))
)
vectors = tuples(3, st.floats(-1e3, 1e3))


@st.composite
def symmetric(draw):
    a, b, c, d, e, f = draw(tuples(6, st.floats(-1e3, 1e3)))
    return (a, b, c, b, d, e, c, e, f)


imus = st.builds(
    ImuSample,
    stamps,
    texts,
    tuples(3),
    tuples(9),
    st.none() | tuples(3),
    covariances,
    st.none() | tuples(4).filter(any),
    covariances,
)
accelerations = st.builds(LinearAcceleration, stamps, texts, tuples(3), tuples(9))
states = st.builds(
    NavigationState,
    stamps,
    vectors,
    vectors,
    quaternions,
    tuples(9),
    symmetric(),
    tuples(9),
    st.none() | tuples(3),
    tuples(9, st.floats(-1e5, 1e5)),
    pose_cross_covariance=tuples(9),
    twist_cross_covariance=st.just(UNKNOWN) | tuples(9, st.floats(-1e3, 1e3)),
)


def header(message, stamp_ns, frame_id):
    sec, nanosec = divmod(stamp_ns, NANOSECONDS)
    message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
    message.header.frame_id = frame_id
    return message


def fill(message, names, values):
    for name, value in zip(names, values, strict=True):
        setattr(message, name, value)


def diagonal_blocks(first, second, cross=UNKNOWN):
    matrix = [0.0] * 36
    for row in range(3):
        matrix[6 * row : 6 * row + 3] = first[3 * row : 3 * row + 3]
        matrix[21 + 6 * row : 24 + 6 * row] = second[3 * row : 3 * row + 3]
        matrix[6 * row + 3 : 6 * row + 6] = cross[3 * row : 3 * row + 3]
        matrix[18 + 6 * row : 21 + 6 * row] = cross[row::3]
    return matrix


def imu_message(imu):
    message = header(Imu(), imu.stamp_ns, imu.frame_id)
    fill(message.orientation, 'xyzw', imu.orientation or (0.0, 0.0, 0.0, 1.0))
    message.orientation_covariance = imu.orientation_covariance
    if imu.orientation is None:
        message.orientation_covariance = [-1.0] + [0.0] * 8
    message.angular_velocity_covariance = imu.angular_velocity_covariance
    if imu.angular_velocity is None:
        message.angular_velocity_covariance = [-1.0] + [0.0] * 8
    else:
        fill(message.angular_velocity, 'xyz', imu.angular_velocity)
    fill(message.linear_acceleration, 'xyz', imu.specific_force)
    message.linear_acceleration_covariance = imu.specific_force_covariance
    return message


def acceleration_message(sample):
    message = header(AccelWithCovarianceStamped(), sample.stamp_ns, sample.frame_id)
    fill(message.accel.accel.linear, 'xyz', sample.acceleration)
    message.accel.covariance = diagonal_blocks(sample.covariance, [-1.0] + [0.0] * 8)
    return message


def odometry_message(state, frame_id, child_frame_id):
    message = header(Odometry(child_frame_id=child_frame_id), state.stamp_ns, frame_id)
    rot_wb = matrix_from_quaternion(state.attitude)
    fill(message.pose.pose.position, 'xyz', state.position)
    fill(message.pose.pose.orientation, 'xyzw', state.attitude)
    message.pose.covariance = diagonal_blocks(
        state.position_covariance, state.attitude_covariance, state.pose_cross_covariance
    )
    fill(message.twist.twist.linear, 'xyz', rotate_back(rot_wb, state.velocity))
    angular = state.angular_velocity_covariance
    if state.angular_velocity is None:
        angular = [HUGE, 0.0, 0.0, 0.0, HUGE, 0.0, 0.0, 0.0, HUGE]
    else:
        fill(message.twist.twist.angular, 'xyz', state.angular_velocity)
    # How the covariance is turned is the business of core; here it is only laid out.
    written = deserialize_message(wire.odometry_encoder('', '')(state), Odometry)
    linear, cross = (
        [
            written.twist.covariance[6 * row + column + at]
            for row in range(3)
            for column in range(3)
        ]
        for at in (0, 3)
    )
    message.twist.covariance = diagonal_blocks(linear, angular, cross)
    return message


def serialized(message):
    """Return what rclpy writes, with zeros for the padding, which it leaves uninitialized."""
    data = bytearray(serialize_message(message))
    at = 12  # past encapsulation and stamp
    for _ in range(2 if isinstance(message, Odometry) else 1):
        padding = -at % 4
        data[at : at + padding] = bytes(padding)
        at += padding
        at += 4 + int.from_bytes(data[at : at + 4], 'little')
    padding = -(at - 4) % 8
    data[at : at + padding] = bytes(padding)
    return bytes(data)


def same(first, second):
    """Say whether two values are equal, NaN counting as itself and −0 not as 0."""
    return repr(first) == repr(second)


@given(imus)
@example(ImuSample(-1, '', (math.nan,) * 3))
@example(ImuSample(-(2**31) * NANOSECONDS, '', (math.inf, -math.inf, -0.0)))
@example(ImuSample(2**31 * NANOSECONDS - 1, '', (5e-324, 1.7976931348623157e308, 0.0)))
def test_imu_is_written_as_rclpy_does_and_read_back(imu):
    data = wire.encode_imu(imu)
    assert data == serialized(imu_message(imu))
    read = decode_imu(data)
    assert same(read.stamp_ns, imu.stamp_ns)
    assert same(read.frame_id, imu.frame_id)
    assert same(read.specific_force, imu.specific_force)
    assert same(read.specific_force_covariance, imu.specific_force_covariance)
    assert same(read.angular_velocity, imu.angular_velocity)
    assert same(read.orientation, imu.orientation)
    if imu.angular_velocity is not None:
        assert same(read.angular_velocity_covariance, imu.angular_velocity_covariance)
    if imu.orientation is not None:
        assert same(read.orientation_covariance, imu.orientation_covariance)


@given(accelerations)
def test_acceleration_is_written_as_rclpy_does_and_read_back(sample):
    data = wire.encode_acceleration(sample)
    assert data == serialized(acceleration_message(sample))
    assert same(decode_acceleration(data), sample)


@given(states, texts, texts)
def test_odometry_is_written_as_rclpy_does_and_read_back(state, frame_id, child_frame_id):
    data = wire.odometry_encoder(frame_id, child_frame_id)(state)
    assert data == serialized(odometry_message(state, frame_id, child_frame_id))
    read = decode_odometry(data)
    assert same(read.stamp_ns, state.stamp_ns)
    assert same(read.position, state.position)
    assert same(read.attitude, state.attitude)
    assert same(read.position_covariance, state.position_covariance)
    assert same(read.attitude_covariance, state.attitude_covariance)
    assert same(read.pose_cross_covariance, state.pose_cross_covariance)
    assert read.twist_cross_covariance == pytest.approx(
        state.twist_cross_covariance, rel=1e-12, abs=1e-9
    )
    assert same(read.angular_velocity, state.angular_velocity)
    if state.angular_velocity is not None:
        assert same(read.angular_velocity_covariance, state.angular_velocity_covariance)
    assert read.velocity == pytest.approx(state.velocity, rel=1e-12, abs=1e-9)
    assert read.velocity_covariance == pytest.approx(
        state.velocity_covariance, rel=1e-12, abs=1e-9
    )


@pytest.mark.parametrize('value', [True, False])
def test_bool_is_written_as_rclpy_does(value):
    data = wire.encode_bool(value)
    expected = serialize_message(Bool(data=value))
    assert len(data) == len(expected)
    assert data[:5] == expected[:5]  # the rest is padding
    assert deserialize_message(data, Bool).data is value


@given(value=st.integers(0, 2**32 - 1))
def test_uint32_is_written_as_rclpy_does(value):
    assert wire.encode_uint32(value) == serialize_message(UInt32(data=value))


@given(value=st.floats(allow_nan=False))
def test_float64_is_written_as_rclpy_does(value):
    assert wire.encode_float64(value) == serialize_message(Float64(data=value))


@pytest.mark.parametrize('letter', ['f', 'é', '界', '🛰'])
def test_a_frame_id_of_any_length_fits(letter):
    for length in LENGTHS:
        frame_id = letter * length
        imu = ImuSample(1, frame_id, (0.5, 1.5, 2.5))
        assert wire.encode_imu(imu) == serialized(imu_message(imu)), length
        assert decode_imu(wire.encode_imu(imu)).frame_id == frame_id
        sample = LinearAcceleration(1, frame_id, (0.5, 1.5, 2.5))
        data = wire.encode_acceleration(sample)
        assert data == serialized(acceleration_message(sample)), length
        assert decode_acceleration(data).frame_id == frame_id
        state = NavigationState(1, (0.5, 1.5, 2.5), (3.5, 4.5, 5.5))
        for other in range(8):  # the second id moves by every remainder that alignment knows
            for ids in ((frame_id, 'c' * other), ('c' * other, frame_id)):
                data = wire.odometry_encoder(*ids)(state)
                assert data == serialized(odometry_message(state, *ids)), ids
                assert decode_odometry(data).velocity == state.velocity


def block(matrix, begin):
    """Return a block of a covariance, shape (6, 6), row by row."""
    return tuple(matrix[6 * (begin + i) + begin + j] for i in range(3) for j in range(3))


@given(stamps, texts, tuples(6), tuples(36))
def test_a_twist_is_read_as_rclpy_does(stamp_ns, frame_id, doubles, matrix):
    message = header(TwistWithCovarianceStamped(), stamp_ns, frame_id)
    fill(message.twist.twist.linear, 'xyz', doubles[:3])
    fill(message.twist.twist.angular, 'xyz', doubles[3:])
    message.twist.covariance = matrix
    read = decode_twist(serialize_message(message))
    assert (read.stamp_ns, read.frame_id) == (stamp_ns, frame_id)
    assert same(read.velocity, doubles[:3])
    assert same(read.covariance, block(matrix, 0))


@given(states, texts, texts)
def test_the_twist_of_odometry_is_that_of_the_child_frame(state, frame_id, child_frame_id):
    message = odometry_message(state, frame_id, child_frame_id)
    read = decode_wheels(serialize_message(message))
    assert (read.stamp_ns, read.frame_id) == (state.stamp_ns, child_frame_id)
    linear = message.twist.twist.linear
    assert same(read.velocity, (linear.x, linear.y, linear.z))
    assert same(read.covariance, block(message.twist.covariance.tolist(), 0))


@given(stamps, texts, tuples(7), tuples(36))
def test_a_pose_is_read_as_rclpy_does(stamp_ns, frame_id, doubles, matrix):
    message = header(PoseWithCovarianceStamped(), stamp_ns, frame_id)
    fill(message.pose.pose.position, 'xyz', doubles[:3])
    fill(message.pose.pose.orientation, 'xyzw', doubles[3:])
    message.pose.covariance = matrix
    read = decode_pose(serialize_message(message))
    assert (read.stamp_ns, read.frame_id) == (stamp_ns, frame_id)
    assert same(read.position, doubles[:3])
    assert same(read.attitude, doubles[3:])
    assert same(read.position_covariance, block(matrix, 0))
    assert same(read.attitude_covariance, block(matrix, 3))


poses = st.lists(st.tuples(stamps, tuples(3), tuples(4)), min_size=1, max_size=5)


@given(texts, poses)
def test_a_path_is_read_by_rclpy(frame_id, poses):
    data = wire.path_encoder(frame_id)(Way(tuple(poses)))
    message = deserialize_message(data, Path)
    assert len(data) == len(serialize_message(message))
    for stamped, (stamp_ns, position, attitude) in zip(message.poses, poses, strict=True):
        stamp = stamped.header.stamp
        assert stamp.sec * NANOSECONDS + stamp.nanosec == stamp_ns
        assert stamped.header.frame_id == message.header.frame_id == frame_id
        at, turned = stamped.pose.position, stamped.pose.orientation
        assert same((at.x, at.y, at.z), position)
        assert same((turned.x, turned.y, turned.z, turned.w), attitude)
    stamp = message.header.stamp
    assert stamp.sec * NANOSECONDS + stamp.nanosec == poses[-1][0]


def typed_imus():
    """Messages as others send them, which need not be what this package would write."""

    def build(stamp_ns, frame_id, doubles):
        message = header(Imu(), stamp_ns, frame_id)
        fill(message.orientation, 'xyzw', doubles[0:4])
        message.orientation_covariance = doubles[4:13]
        fill(message.angular_velocity, 'xyz', doubles[13:16])
        message.angular_velocity_covariance = doubles[16:25]
        fill(message.linear_acceleration, 'xyz', doubles[25:28])
        message.linear_acceleration_covariance = doubles[28:37]
        return message

    return st.builds(build, stamps, texts, tuples(37))


def check_imu(read, message):
    """Compare a sample with the message as rclpy reads it."""
    orientation = tuple(getattr(message.orientation, name) for name in 'xyzw')
    turning = tuple(getattr(message.angular_velocity, name) for name in 'xyz')
    force = tuple(getattr(message.linear_acceleration, name) for name in 'xyz')
    stamp = message.header.stamp
    assert read.stamp_ns == stamp.sec * NANOSECONDS + stamp.nanosec
    assert read.frame_id == message.header.frame_id
    assert same(read.specific_force, force)
    assert same(
        read.specific_force_covariance, tuple(message.linear_acceleration_covariance.tolist())
    )
    oriented = message.orientation_covariance[0] >= 0.0 and any(orientation)
    assert same(read.orientation, orientation if oriented else None)
    measured = message.angular_velocity_covariance[0] >= 0.0
    assert same(read.angular_velocity, turning if measured else None)


@given(typed_imus())
def test_imu_is_read_as_rclpy_does(message):
    check_imu(decode_imu(serialize_message(message)), message)


def big_endian(stamp_ns, texts, doubles):
    """Lay a message out by hand: encapsulation 00 00, everything most significant byte first."""
    body = struct.pack('>iI', *divmod(stamp_ns, NANOSECONDS))
    for text in texts:
        body += bytes(-len(body) % 4)
        coded = text.encode() + b'\0'
        body += struct.pack('>I', len(coded)) + coded
    body += bytes(-len(body) % 8)
    return b'\0\0\0\0' + body + struct.pack(f'>{len(doubles)}d', *doubles)


@given(stamps, texts, tuples(37))
def test_big_endian_imu_is_read(stamp_ns, frame_id, doubles):
    data = big_endian(stamp_ns, [frame_id], doubles)
    check_imu(decode_imu(data), deserialize_message(data, Imu))
    assert decode_imu(data).stamp_ns == stamp_ns
    assert same(decode_imu(data).specific_force, doubles[25:28])


@given(stamps, texts, tuples(42))
def test_big_endian_acceleration_is_read(stamp_ns, frame_id, doubles):
    read = decode_acceleration(big_endian(stamp_ns, [frame_id], doubles))
    assert (read.stamp_ns, read.frame_id) == (stamp_ns, frame_id)
    assert same(read.acceleration, doubles[0:3])
    assert same(read.covariance, doubles[6:9] + doubles[12:15] + doubles[18:21])


@given(stamps, texts, texts, tuples(85, st.floats(-1e3, 1e3)))
def test_big_endian_odometry_is_read(stamp_ns, frame_id, child_frame_id, doubles):
    identity = (*doubles[:3], 0.0, 0.0, 0.0, 1.0, *doubles[7:])
    read = decode_odometry(big_endian(stamp_ns, [frame_id, child_frame_id], identity))
    assert read.stamp_ns == stamp_ns
    assert same(read.position, doubles[0:3])
    assert read.velocity == doubles[43:46]
    assert same(read.position_covariance, doubles[7:10] + doubles[13:16] + doubles[19:22])


DECODERS = [
    (decode_imu, Imu, wire.encode_imu(ImuSample(5, 'imu_link', (1.0, 2.0, 3.0)))),
    (
        decode_acceleration,
        AccelWithCovarianceStamped,
        wire.encode_acceleration(LinearAcceleration(5, 'odom', (1.0, 2.0, 3.0))),
    ),
    (
        decode_odometry,
        Odometry,
        wire.odometry_encoder('odom', 'base_link')(NavigationState(5, (1.0,) * 3, (2.0,) * 3)),
    ),
    (
        decode_wheels,
        Odometry,
        wire.odometry_encoder('odom', 'base_link')(NavigationState(5, (1.0,) * 3, (2.0,) * 3)),
    ),
    (
        decode_twist,
        TwistWithCovarianceStamped,
        bytes(serialize_message(header(TwistWithCovarianceStamped(), 5, 'odom'))),
    ),
    (
        decode_pose,
        PoseWithCovarianceStamped,
        bytes(serialize_message(header(PoseWithCovarianceStamped(), 5, 'odom'))),
    ),
]


def read_or_refuse(decode, message_type, data):
    """Decode; what is read must have the stamp and the frame that rclpy finds, if it finds any."""
    try:
        read = decode(data)
    except WireError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017
        return None
    try:
        message = deserialize_message(data, message_type)
    except Exception:
        return read
    stamp = message.header.stamp
    assert read.stamp_ns == stamp.sec * NANOSECONDS + stamp.nanosec
    if hasattr(read, 'frame_id'):
        frame_id = getattr(message, 'child_frame_id', message.header.frame_id)
        assert read.frame_id == frame_id
    return read


@pytest.mark.parametrize(('decode', 'message_type', 'whole'), DECODERS)
def test_a_message_cut_short_is_refused_at_every_byte(decode, message_type, whole):
    assert decode(whole) is not None
    for length in range(len(whole)):
        with pytest.raises(WireError):
            decode(whole[:length])


@pytest.mark.parametrize(('decode', 'message_type', 'whole'), DECODERS)
@given(data=st.binary(max_size=900))
@example(data=b'')
@example(data=b'\0')
@example(data=b'\0\1')
@example(data=b'\0\1\0\0')
@example(data=b'\0\1\0\0' + b'\xff' * 900)
@example(data=b'\0\0\0\0' + b'\xff' * 900)
@example(data=b'\0\0\0\0' + bytes(900))
def test_garbage_is_read_or_refused(decode, message_type, whole, data):
    read_or_refuse(decode, message_type, data)
    read_or_refuse(decode, message_type, whole[:4] + data)


@pytest.mark.parametrize(('decode', 'message_type', 'whole'), DECODERS)
@given(at=st.integers(0, 60), byte=st.integers(0, 255), rest=st.binary(max_size=20))
def test_a_damaged_message_is_read_or_refused(decode, message_type, whole, at, byte, rest):
    read_or_refuse(decode, message_type, whole[:at] + bytes([byte]) + whole[at + 1 :] + rest)
