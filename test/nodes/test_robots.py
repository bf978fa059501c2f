"""Two robots at once, each with all its nodes in a namespace: none sees the other's data."""

import pytest
from geometry_msgs.msg import AccelWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from ros_harness import DEEP, RELIABLE, figures, lossless
from sensor_msgs.msg import Imu
from std_msgs.msg import Bool, Float64, UInt32

NODES = ('gravity_removal', 'integrator', 'pedometer', 'compass_driver', 'accelerometer_driver')
STAMPED = {
    'imu/data_raw': Imu,
    'ground_truth/odom': Odometry,
    'compass/data': Imu,
    'imu/data': Imu,
    'imu/linear_acceleration': AccelWithCovarianceStamped,
    'odom': Odometry,
}
STEPS_TAKEN = 12
DISTANCE = 0.8
MOTIONS = {
    'robot1': {'driver.motion': 'walk', 'driver.walk.steps': STEPS_TAKEN, 'driver.walk.start': 2},
    'robot2': {
        'driver.motion': 'slide',
        'driver.slide.distance': DISTANCE,
        'driver.slide.start': 2.0,
        'driver.slide.duration': 1.5,
    },
}
LATCHED = {
    'stationary': Bool,
    'pedometer/steps': UInt32,
    'pedometer/distance': Float64,
    'pedometer/step_length': Float64,
    'pedometer/cadence': Float64,
}
ALL_OF_IT = QoSProfile(depth=DEEP, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
LISTENERS = 5
"""Of a driver's two topics: gravity removal, pedometer and compass, and this test twice."""


def start(ros, robot):
    parameters = {
        **MOTIONS[robot],
        **lossless(*(f'/{robot}/{topic}' for topic in STAMPED)),
        'frames.world': f'{robot}/odom',
        'frames.body': f'{robot}/base_link',
        'frames.sensor': f'{robot}/imu_link',
        'driver.wait_for_subscribers': LISTENERS,
        'driver.samples_per_message': 128,  # two robots are much for one listener in Python
    }
    for name in NODES:
        ros.start(name, parameters, '-r', f'__ns:=/{robot}')


def record(ros, robot):
    recordings = {t: ros.record(f'{robot}/{t}', kind, RELIABLE) for t, kind in STAMPED.items()}
    for topic, kind in LATCHED.items():
        recordings[topic] = ros.record(f'{robot}/{topic}', kind, ALL_OF_IT)
    recordings['pedometer/odom'] = ros.record(f'{robot}/pedometer/odom', Odometry, RELIABLE)
    return recordings


@pytest.fixture(scope='module')
def robots(module_ros):
    """Both robots have moved; what was recorded of each, by topic."""
    ros = module_ros
    robots = {robot: record(ros, robot) for robot in MOTIONS}
    for robot in MOTIONS:
        start(ros, robot)
    for recordings in robots.values():
        for recording in recordings.values():
            recording.connected()
    for robot, recordings in robots.items():
        truth = recordings['ground_truth/odom']
        truth.wait(1)
        ros.until(lambda truth=truth: seconds(truth) > 10.0, f'the end of the motion of {robot}')
        last = truth.stamps[-1]
        for topic in ('odom', 'imu/data', 'imu/data_raw'):
            ros.until(lambda r=recordings[topic], last=last: r.latest_stamp >= last, topic)
    return robots


def seconds(recording):
    return (recording.stamps[-1] - recording.stamps[0]) * 1e-9


def position(message):
    point = message.pose.pose.position
    return [point.x, point.y, point.z]


def test_each_hears_of_its_own_frames_only(robots):
    for robot, recordings in robots.items():
        for topic in ('imu/data_raw', 'imu/data', 'compass/data'):
            frames = {message.header.frame_id for message in recordings[topic].messages}
            assert frames == {f'{robot}/imu_link'}, topic
        for topic in ('odom', 'ground_truth/odom', 'imu/linear_acceleration'):
            frames = {message.header.frame_id for message in recordings[topic].messages}
            assert frames == {f'{robot}/odom'}, topic
        for topic in ('odom', 'ground_truth/odom'):
            children = {message.child_frame_id for message in recordings[topic].messages}
            assert children == {f'{robot}/base_link'}, topic


def test_each_hears_of_its_own_stamps_only(robots):
    """Each driver has a time of its own; all that follows carries that, and nothing is lost."""
    raw = {robot: set(recordings['imu/data_raw'].stamps) for robot, recordings in robots.items()}
    assert not raw['robot1'] & raw['robot2']
    for robot, recordings in robots.items():
        last = max(raw[robot])  # the test itself may be behind with this, its busiest topic
        for topic in STAMPED:
            heard = [stamp for stamp in recordings[topic].stamps if stamp <= last]
            assert heard
            assert set(heard) <= raw[robot], topic
        first = recordings['odom'].stamps[0]
        end = min(last, recordings['odom'].stamps[-1])
        for topic in ('imu/data_raw', 'odom'):
            stamps = [stamp for stamp in recordings[topic].stamps if first <= stamp <= end]
            assert stamps == sorted(stamp for stamp in raw[robot] if first <= stamp <= end), topic


def test_each_ends_where_it_went(robots):
    slid = robots['robot2']['odom'].messages[-1]
    assert position(slid) == pytest.approx([DISTANCE, 0.0, 0.0], abs=0.05 * DISTANCE)
    walked = position(robots['robot1']['ground_truth/odom'].messages[-1])
    assert walked[0] > 5.0


def test_each_counts_its_own_steps(robots):
    assert robots['robot1']['pedometer/steps'].messages[-1].data == STEPS_TAKEN
    # A push and a brake may pass for two.
    assert robots['robot2']['pedometer/steps'].messages[-1].data <= 2
    for recordings in robots.values():
        counted = recordings['pedometer/steps'].messages[-1].data
        assert len(recordings['pedometer/odom']) == counted


def test_every_topic_of_samples_is_in_one_namespace_with_one_publisher(module_ros, robots):
    node = module_ros.node
    names = {name for name, _ in node.get_topic_names_and_types()}
    for topic in (*STAMPED, *LATCHED, 'pedometer/odom'):
        assert f'/{topic}' not in names
        for robot in robots:
            (publisher,) = node.get_publishers_info_by_topic(f'/{robot}/{topic}')
            assert publisher.node_namespace == f'/{robot}'
            listeners = node.get_subscriptions_info_by_topic(f'/{robot}/{topic}')
            assert {each.node_namespace for each in listeners} <= {f'/{robot}', '/'}


def test_a_service_reaches_one_robot(module_ros, robots):
    stationary = len(robots['robot2']['odom'])
    answer = module_ros.trigger('/robot1/integrator/reset')
    assert answer.success
    robots['robot2']['odom'].wait(stationary + 100)
    assert position(robots['robot2']['odom'].messages[-1])[0] > 0.9 * DISTANCE


def test_diagnostics_name_each_node_and_no_mixture_of_samples(module_ros, robots):
    heard = module_ros.diagnostics()
    for robot in robots:
        for name in NODES:
            status = heard.until(f'{robot}/{name}', lambda _: True, 'its word')
            faults = {'UnpairedError', 'LateSampleError', 'RepeatedStampError', 'RestartError'}
            assert not faults & set(figures(status)), (robot, name)
