"""What was written to a bag comes back, from every format; what is no bag is an error."""

import contextlib
import subprocess
import sys
from dataclasses import astuple
from pathlib import Path

import numpy as np
import pytest
from rosbags.interfaces import QosDurability
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import Reader as Reader2
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from dead_reckoning import wire
from dead_reckoning.core.blocks import ImuBlock, Stamped
from dead_reckoning.core.errors import DependencyError, RecordingError, WireError
from dead_reckoning.core.samples import UNKNOWN, ImuSample, PoseSample, VelocitySample
from dead_reckoning.sources import bags
from dead_reckoning.sources.bags import BagWriter, read_blocks, read_imu, read_odometry, topics

IMU = 'sensor_msgs/msg/Imu'
ODOMETRY = 'nav_msgs/msg/Odometry'
POSE_WITH_COVARIANCE = 'geometry_msgs/msg/PoseWithCovarianceStamped'
TWIST = 'geometry_msgs/msg/TwistWithCovarianceStamped'
FORMATS = ('ros1', 'sqlite3', 'mcap')
FILES = {'ros1': 'walk.bag', 'sqlite3': 'walk/walk.db3', 'mcap': 'walk/walk.mcap'}
UNSAID = np.zeros(9)
NOT_MEASURED = np.array([-1.0] + [0.0] * 8)


class Messages:
    """Messages of one version of ROS, built by name."""

    def __init__(self, store):
        self.store = store
        self.ros1 = 'seq' in store.types['std_msgs/msg/Header'].__annotations__

    def make(self, kind, *arguments):
        return self.store.types[kind](*arguments)

    def header(self, stamp_ns, frame_id):
        stamp = self.make('builtin_interfaces/msg/Time', *divmod(stamp_ns, 10**9))
        first = (0,) if self.ros1 else ()
        return self.make('std_msgs/msg/Header', *first, stamp, frame_id)

    def vector(self, numbers):
        return self.make('geometry_msgs/msg/Vector3', *numbers)

    def quaternion(self, numbers):
        return self.make('geometry_msgs/msg/Quaternion', *numbers)

    def imu(
        self,
        stamp_ns,
        force=(0.0, 0.0, 9.8),
        rate=(0.1, 0.2, 0.3),
        orientation=(0.0, 0.0, 0.0, 1.0),
        covariances=(UNSAID,) * 3,
    ):
        return self.make(
            IMU,
            self.header(stamp_ns, 'imu_link'),
            self.quaternion(orientation),
            covariances[0],
            self.vector(rate),
            covariances[1],
            self.vector(force),
            covariances[2],
        )

    def odometry(self, stamp_ns, position, orientation, velocity, rate, pose, twist):
        point = self.make('geometry_msgs/msg/Point', *position)
        at = self.make('geometry_msgs/msg/Pose', point, self.quaternion(orientation))
        speed = self.make('geometry_msgs/msg/Twist', self.vector(velocity), self.vector(rate))
        return self.make(
            ODOMETRY,
            self.header(stamp_ns, 'odom'),
            'base_link',
            self.make('geometry_msgs/msg/PoseWithCovariance', at, pose.ravel()),
            self.make('geometry_msgs/msg/TwistWithCovariance', speed, twist.ravel()),
        )

    def twist(self, stamp_ns, velocity, covariance):
        speed = self.make('geometry_msgs/msg/Twist', self.vector(velocity), self.vector((9,) * 3))
        return self.make(
            TWIST,
            self.header(stamp_ns, 'wheel'),
            self.make('geometry_msgs/msg/TwistWithCovariance', speed, covariance.ravel()),
        )

    def pose(self, stamp_ns, position, orientation, covariance):
        point = self.make('geometry_msgs/msg/Point', *position)
        at = self.make('geometry_msgs/msg/Pose', point, self.quaternion(orientation))
        return self.make(
            POSE_WITH_COVARIANCE,
            self.header(stamp_ns, 'odom'),
            self.make('geometry_msgs/msg/PoseWithCovariance', at, covariance.ravel()),
        )


def write(folder, kind, recorded):
    """Write ``topic → (type, messages)`` as one of the formats; return the path of the bag.

    ``messages`` gets the `Messages` to build them with; each is recorded a second after the other,
    whatever its stamp.
    """
    if kind == 'ros1':
        path = folder / 'walk.bag'
        store = get_typestore(Stores.ROS1_NOETIC)
        writer, serialize = Writer1(path), store.serialize_ros1
    else:
        path = folder / 'walk'
        store = get_typestore(Stores.ROS2_JAZZY)
        writer = Writer2(path, version=9, storage_plugin=StoragePlugin[kind.upper()])
        serialize = store.serialize_cdr
    with writer:
        for topic, (message_type, messages) in recorded.items():
            connection = writer.add_connection(topic, message_type, typestore=store)
            for second, message in enumerate(messages(Messages(store))):
                writer.write(connection, second * 10**9, serialize(message, message_type))
    return path


def stamps(*numbers):
    """Return a function for `write` that gives an Imu for each of some stamps."""
    return lambda messages: [messages.imu(stamp_ns) for stamp_ns in numbers]


@pytest.fixture(params=FORMATS)
def kind(request):
    return request.param


def test_an_imu_comes_back_as_it_was_written(tmp_path, kind):
    generator = np.random.default_rng(1)
    force, rate = generator.normal(size=(2, 3))
    orientation = generator.normal(size=4)
    covariances = generator.uniform(0.1, 1.0, size=(3, 9))
    values = (12_345_678_901, force, rate, orientation, covariances)
    path = write(tmp_path, kind, {'/imu/data': (IMU, lambda m: [m.imu(*values)])})
    (sample,) = read_imu(path)
    assert astuple(sample) == (
        12_345_678_901,
        'imu_link',
        tuple(force),
        tuple(covariances[2]),
        tuple(rate),
        tuple(covariances[1]),
        tuple(orientation),
        tuple(covariances[0]),
    )
    plain = (*sample.specific_force, *sample.orientation, *sample.specific_force_covariance)
    assert {type(number) for number in plain} == {float}
    assert type(sample.stamp_ns) is int


def test_what_is_not_measured_is_none(tmp_path, kind):
    covariances = (NOT_MEASURED, NOT_MEASURED, UNSAID)
    path = write(tmp_path, kind, {'/imu': (IMU, lambda m: [m.imu(1, covariances=covariances)])})
    (sample,) = read_imu(path)
    assert sample.orientation is None
    assert sample.angular_velocity is None
    assert sample.orientation_covariance == sample.angular_velocity_covariance == UNKNOWN


def test_four_zeros_are_no_orientation(tmp_path, kind):
    zeros = (0.0, 0.0, 0.0, 0.0)
    path = write(tmp_path, kind, {'/imu': (IMU, lambda m: [m.imu(1, orientation=zeros)])})
    (sample,) = read_imu(path)
    assert sample.orientation is None


def test_an_acceleration_that_is_not_measured_keeps_its_mark(tmp_path, kind):
    covariances = (UNSAID, UNSAID, NOT_MEASURED)
    path = write(tmp_path, kind, {'/imu': (IMU, lambda m: [m.imu(1, covariances=covariances)])})
    (sample,) = read_imu(path)
    assert sample.specific_force_covariance[0] == -1.0


def test_stamps_and_order_are_those_of_the_recording(tmp_path, kind):
    recorded = (5_000_000_000, 3, 3, 4_294_967_296, 7)
    path = write(tmp_path, kind, {'/imu': (IMU, stamps(*recorded))})
    assert [sample.stamp_ns for sample in read_imu(path)] == list(recorded)


def test_an_odometry_comes_back_with_its_twist_in_the_world(tmp_path, kind):
    quarter = (0.0, 0.0, 0.5**0.5, 0.5**0.5)  # body x is world y
    pose = np.diag([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    twist = np.diag([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    moving = ((1.0, 2.0, 3.0), quarter, (2.0, 0.0, 0.0), (0.0, 0.0, 1.0), pose, twist)
    path = write(tmp_path, kind, {'/odom': (ODOMETRY, lambda m: [m.odometry(9, *moving)])})
    (state,) = read_odometry(path)
    assert state.stamp_ns == 9
    assert state.position == (1.0, 2.0, 3.0)
    assert state.velocity == pytest.approx((0.0, 2.0, 0.0))
    assert state.attitude == quarter
    assert state.position_covariance == (1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0)
    assert state.attitude_covariance == (4.0, 0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 6.0)
    expected = (0.2, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.3)
    assert state.velocity_covariance == pytest.approx(expected)
    assert state.angular_velocity == (0.0, 0.0, 1.0)
    assert state.angular_velocity_covariance == (0.4, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.6)


def test_a_rate_of_huge_variance_is_not_measured(tmp_path, kind):
    huge = np.diag([0.1] * 3 + [1e6] * 3)
    at_rest = ((0.0,) * 3, (0.0, 0.0, 0.0, 1.0), (0.0,) * 3, (0.0,) * 3)
    path = write(
        tmp_path, kind, {'/odom': (ODOMETRY, lambda m: [m.odometry(1, *at_rest, huge, huge)])}
    )
    (state,) = read_odometry(path)
    assert state.angular_velocity is None
    assert state.angular_velocity_covariance == UNKNOWN


def test_blocks_hold_what_is_read_one_by_one(tmp_path, kind, monkeypatch):
    monkeypatch.setattr(bags, 'BLOCK', 8)
    generator = np.random.default_rng(2)

    def imus(messages):
        return [messages.imu(k, *generator.normal(size=(2, 3))) for k in range(1, 21)]

    path = write(tmp_path, kind, {'/a': (IMU, imus), '/b': (IMU, imus)})
    found = list(read_blocks(path, ['/a']))
    assert {topic for topic, _ in found} == {'/a'}
    assert [len(block) for _, block in found] == [8, 8, 4]
    samples = [block.sample(k) for _, block in found for k in range(len(block))]
    for sample, expected in zip(samples, read_imu(path, '/a'), strict=True):
        assert astuple(sample) == astuple(expected)


def test_topics_come_in_the_order_of_the_recording(tmp_path, kind):
    path = write(tmp_path, kind, {'/a': (IMU, stamps(1, 3, 5)), '/b': (IMU, stamps(2, 4, 6))})
    found = [(topic, block.stamp_ns.tolist()) for topic, block in read_blocks(path, ['/b', '/a'])]
    order = [(topic, stamp) for topic, stamps in found for stamp in stamps]
    assert sorted(order, key=lambda one: (one[1] + 1) // 2) == order
    assert [one for one in order if one[0] == '/a'] == [('/a', 1), ('/a', 3), ('/a', 5)]


def test_what_aids_a_navigator_comes_one_by_one(tmp_path, kind):
    covariance = np.arange(36.0).reshape(6, 6)
    first = tuple(covariance[:3, :3].ravel())
    second = tuple(covariance[3:, 3:].ravel())
    velocity, quarter = (1.0, 2.0, 3.0), (0.0, 0.0, 0.6, 0.8)
    path = write(
        tmp_path,
        kind,
        {
            '/imu': (IMU, stamps(1, 2)),
            '/twist': (TWIST, lambda m: [m.twist(3, velocity, covariance)]),
            '/odom': (
                ODOMETRY,
                lambda m: [
                    m.odometry(4, (9,) * 3, quarter, velocity, (9,) * 3, -covariance, covariance)
                ],
            ),
            '/pose': (
                POSE_WITH_COVARIANCE,
                lambda m: [m.pose(5, velocity, quarter, covariance)] * 2,
            ),
        },
    )
    found = {}
    for topic, block in read_blocks(path, ['/imu', '/twist', '/odom', '/pose']):
        assert len(block.stamp_ns) == len(block)
        found.setdefault(topic, []).extend(block.sample(k) for k in range(len(block)))
    pose = PoseSample(5, 'odom', velocity, first, quarter, second)
    assert [sample.stamp_ns for sample in found['/imu']] == [1, 2]
    for topic, expected in (
        ('/twist', [VelocitySample(3, 'wheel', velocity, first)]),
        ('/odom', [VelocitySample(4, 'base_link', velocity, first)]),
        ('/pose', [pose, pose]),
    ):
        assert list(map(astuple, found[topic])) == list(map(astuple, expected))


def test_how_many_messages_there_are(tmp_path, kind):
    path = write(tmp_path, kind, {'/a': (IMU, stamps(1, 3, 5)), '/b': (IMU, stamps(2))})
    assert bags.count(path, ['/a']) == 3
    assert bags.count(path, ['/a', '/b']) == 4


def test_big_endian_messages_are_read_and_others_are_errors(tmp_path):
    store = get_typestore(Stores.ROS2_JAZZY)
    message = Messages(store).imu(7)
    whole = bytes(store.serialize_cdr(message, IMU))
    turned = bytes(store.serialize_cdr(message, IMU, little_endian=False))
    assert turned[:2] != whole[:2]
    path = tmp_path / 'mixed'
    with Writer2(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection('/imu', IMU, typestore=store)
        for time_ns, data in enumerate((whole, turned, whole[:50], b'', b'garbage', whole), 1):
            writer.write(connection, time_ns, data)
    found = [made for _, made in read_blocks(path, ['/imu'])]
    assert [len(made) for made in found if isinstance(made, ImuBlock)] == [2, 1]
    errors = [made for made in found if isinstance(made, Stamped)]
    assert [error.stamp_ns for error in errors] == [3, 4, 5]
    assert all(isinstance(error.value, WireError) for error in errors)
    with pytest.raises(RecordingError, match='mixed'):
        list(read_imu(path))


@pytest.mark.parametrize('read', [read_imu, lambda path: read_blocks(path, ['/imu'])])
def test_damage_that_hides_messages_is_said(tmp_path, read):
    path = write(tmp_path, 'mcap', {'/imu': (IMU, stamps(*range(1, 500)))})
    file = tmp_path / FILES['mcap']
    whole = file.read_bytes()
    middle = len(whole) // 2
    file.write_bytes(whole[:middle] + b'\x10' * 4000 + whole[middle + 4000 :])
    with pytest.raises(RecordingError, match=r'walk: only \d+ of 499 messages can be read'):
        list(read(path))


def test_what_was_written_is_a_recording(tmp_path):
    path = tmp_path / 'written'
    writer = BagWriter(path, {'/imu': (IMU, False), '/rest': ('std_msgs/msg/Bool', True)})
    for stamp_ns in (5, -3, 8):
        sample = ImuSample(stamp_ns, 'imu', (1.0, 2.0, 3.0))
        writer.write('/imu', stamp_ns, wire.encode_imu(sample))
    writer.write('/rest', 6, wire.encode_bool(True))
    writer.close()
    assert topics(path) == {'/imu': IMU, '/rest': 'std_msgs/msg/Bool'}
    assert {sample.stamp_ns for sample in read_imu(path)} == {5, -3, 8}
    with Reader2(path) as reader:
        assert sorted(time_ns for _, time_ns, _ in reader.messages()) == [0, 5, 6, 8]
        profiles = {c.topic: c.ext.offered_qos_profiles[0] for c in reader.connections}
    assert profiles['/imu'].durability == QosDurability.VOLATILE
    assert profiles['/rest'].durability == QosDurability.TRANSIENT_LOCAL


def test_topics_and_their_types(tmp_path, kind):
    path = write(tmp_path, kind, {'/a': (IMU, stamps(1)), '/b': (ODOMETRY, lambda _: [])})
    assert topics(path) == {'/a': IMU, '/b': ODOMETRY}


def test_a_topic_without_messages_gives_none(tmp_path, kind):
    path = write(tmp_path, kind, {'/a': (IMU, stamps()), '/b': (IMU, stamps(1))})
    assert list(read_imu(path, '/a')) == []


def test_the_named_topic_is_read(tmp_path, kind):
    path = write(tmp_path, kind, {'/a': (IMU, stamps(1, 2)), '/b': (IMU, stamps(3, 4, 5))})
    assert [sample.stamp_ns for sample in read_imu(path, '/b')] == [3, 4, 5]


@pytest.mark.parametrize('kind', ['sqlite3', 'mcap'])
def test_a_file_of_a_rosbag2_folder_will_do(tmp_path, kind):
    write(tmp_path, kind, {'/imu': (IMU, stamps(1, 2))})
    assert len(list(read_imu(tmp_path / FILES[kind]))) == 2


def test_a_recording_is_read_as_it_is_asked_for(tmp_path, kind):
    path = write(tmp_path, kind, {'/imu': (IMU, stamps(*range(1, 2000)))})
    samples = read_imu(path)
    assert next(samples).stamp_ns == 1
    samples.close()
    with pytest.raises(StopIteration):
        next(samples)


def test_of_several_topics_one_must_be_named(tmp_path, kind):
    path = write(tmp_path, kind, {'/a': (IMU, stamps(1)), '/b': (IMU, stamps(1))})
    with pytest.raises(RecordingError, match=r'2 topics hold sensor_msgs/msg/Imu: /a, /b'):
        read_imu(path)


def test_an_unknown_topic_names_those_there_are(tmp_path, kind):
    path = write(tmp_path, kind, {'/a': (IMU, stamps(1)), '/b': (ODOMETRY, lambda _: [])})
    known = r'/a \(sensor_msgs/msg/Imu\), /b \(nav_msgs/msg/Odometry\)'
    with pytest.raises(RecordingError, match=f'no topic /imu; there is {known}'):
        read_imu(path, '/imu')


def test_a_topic_of_another_type_is_refused(tmp_path, kind):
    path = write(tmp_path, kind, {'/a': (IMU, stamps(1))})
    with pytest.raises(RecordingError, match=r'/a holds sensor_msgs/msg/Imu where nav_msgs'):
        read_odometry(path, '/a')
    with pytest.raises(RecordingError, match=r'no topic holds nav_msgs/msg/Odometry; there is /a'):
        read_odometry(path)


def test_a_recording_of_nothing_is_said_to_be_one(tmp_path, kind):
    path = write(tmp_path, kind, {})
    with pytest.raises(RecordingError, match='no topic holds sensor_msgs/msg/Imu'):
        read_imu(path)


@pytest.mark.parametrize('message_type', bags.CHECKSUMS)
def test_checksums_are_those_of_the_standard_types(message_type):
    ros2, ros1 = (get_typestore(store) for store in (Stores.ROS2_JAZZY, Stores.ROS1_NOETIC))
    standard = ros2.hash_rihs01(message_type), ros1.generate_msgdef(message_type)[1]
    assert bags.CHECKSUMS[message_type] == standard


def test_a_type_that_only_has_the_name_is_refused(tmp_path):
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg('float64 x\n', IMU))
    path = tmp_path / 'other.bag'
    with Writer1(path) as writer:
        connection = writer.add_connection('/imu', IMU, typestore=store)
        writer.write(connection, 1, store.serialize_ros1(store.types[IMU](1.0), IMU))
    with pytest.raises(RecordingError, match='other than the standard one'):
        read_imu(path)


@pytest.mark.parametrize('name', ['walk.bag', 'walk', 'walk.mcap'])
def test_a_missing_recording_is_named(tmp_path, name):
    with pytest.raises(RecordingError, match=f'{name}: no such file or folder'):
        read_imu(tmp_path / name)


def test_a_folder_that_is_no_recording_is_refused(tmp_path):
    with pytest.raises(RecordingError, match=r'without metadata\.yaml'):
        read_imu(tmp_path)


@pytest.mark.parametrize('name', ['walk.bag', 'walk.mcap', 'walk.db3', 'walk.csv'])
@pytest.mark.parametrize('content', [b'', b'ax,ay,az\n0,0,9.8\n'])
def test_a_file_that_is_no_recording_is_refused(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=name):
        read_imu(path)


def test_a_folder_that_lacks_its_file_is_refused(tmp_path):
    path = write(tmp_path, 'mcap', {'/imu': (IMU, stamps(1))})
    (tmp_path / FILES['mcap']).unlink()
    with pytest.raises(RecordingError, match='missing'):
        read_imu(path)


def test_broken_metadata_is_refused(tmp_path):
    path = write(tmp_path, 'mcap', {'/imu': (IMU, stamps(1))})
    (path / 'metadata.yaml').write_text('rosbag2_bagfile_information: 3')
    with pytest.raises(RecordingError, match='metadata'):
        read_imu(path)


def test_a_truncated_recording_is_refused(tmp_path, kind):
    path = write(tmp_path, kind, {'/imu': (IMU, stamps(*range(1, 200)))})
    file = tmp_path / FILES[kind]
    whole = file.read_bytes()
    for part in (0.05, 0.3, 0.6, 0.95):
        file.write_bytes(whole[: int(part * len(whole))])
        with pytest.raises(RecordingError, match='reindex'):
            list(read_imu(path))


def test_damage_is_a_recording_error_or_none(tmp_path, kind):
    path = write(tmp_path, kind, {'/imu': (IMU, stamps(*range(1, 50)))})
    file = tmp_path / FILES[kind]
    whole = file.read_bytes()
    generator = np.random.default_rng(3)
    for _ in range(60):
        damaged = bytearray(whole)
        for at in generator.integers(len(whole), size=20):
            damaged[at] = generator.integers(256)
        file.write_bytes(damaged)
        with contextlib.suppress(RecordingError):
            assert len(list(read_imu(path))) < 50


def test_without_rosbags_the_error_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'rosbags.rosbag1', None)
    with pytest.raises(DependencyError, match='pip install rosbags'):
        read_imu(tmp_path)


def test_importing_needs_no_rosbags():
    code = 'import sys, dead_reckoning.sources.bags; sys.exit("rosbags" in sys.modules)'
    root = Path(__file__).parents[2]
    assert subprocess.run([sys.executable, '-c', code], cwd=root, check=False).returncode == 0
