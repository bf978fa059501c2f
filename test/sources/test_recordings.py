"""Which topics of a bag go to which inputs of the chain."""

from pathlib import Path

import pytest

from dead_reckoning.core.errors import RecordingError
from dead_reckoning.core.stages import (
    AIDING_ODOMETRY,
    AIDING_POSE,
    AIDING_TWIST,
    COMPASS,
    IMU,
    RAW,
    SET_POSE,
)
from dead_reckoning.sources.recordings import choose, namespace

PATH = Path('walk.bag')
KIND = 'sensor_msgs/msg/Imu'


def chosen(topics, inputs, imu=None):
    types = dict.fromkeys(topics, KIND) | {'/odom': 'nav_msgs/msg/Odometry'}
    return choose(PATH, types, inputs, imu)


@pytest.mark.parametrize(
    ('topics', 'inputs', 'imu', 'expected'),
    [
        (['/imu/data_raw', '/imu/data'], [RAW], None, {'/imu/data_raw': (RAW,)}),
        (['/imu/data_raw', '/imu/data'], [IMU], None, {'/imu/data': (IMU,)}),
        (['/robot/imu/data_raw', '/other'], [RAW], None, {'/robot/imu/data_raw': (RAW,)}),
        (['/phone'], [RAW], None, {'/phone': (RAW,)}),
        (['/phone'], [IMU, RAW], None, {'/phone': (IMU, RAW)}),
        (
            ['/imu/data', '/imu/data_raw'],
            [IMU, RAW],
            None,
            {'/imu/data': (IMU,), '/imu/data_raw': (RAW,)},
        ),
        (['/imu/data_raw', '/phone'], [RAW], '/phone', {'/phone': (RAW,)}),
        (['/phone', '/compass/data'], [RAW], None, {'/phone': (RAW,)}),
        (
            ['/phone', '/compass/data'],
            [RAW, COMPASS],
            None,
            {'/phone': (RAW,), '/compass/data': (COMPASS,)},
        ),
        (
            ['/a/imu/data_raw', '/a/compass/data', '/b/compass/data'],
            [RAW, COMPASS],
            None,
            {'/a/imu/data_raw': (RAW,), '/a/compass/data': (COMPASS,)},
        ),
        (
            ['/a/imu/data_raw', '/b/compass/data', '/c/compass/data'],
            [RAW, COMPASS],
            None,
            {'/a/imu/data_raw': (RAW,)},
        ),
    ],
)
def test_topics_are_found(topics, inputs, imu, expected):
    assert chosen(topics, inputs, imu) == expected


@pytest.mark.parametrize(
    ('topics', 'imu', 'words'),
    [
        (['/a', '/b'], None, 'imu/data_raw may be any of /a, /b; name one with --imu'),
        (
            ['/a/imu/data_raw', '/b/imu/data_raw'],
            None,
            'may be any of /a/imu/data_raw, /b/imu/data_raw; name one',
        ),
        ([], None, r'no topic holds sensor_msgs/msg/Imu; there is /odom \(nav_msgs/msg/Odometry'),
        (['/a'], '/b', r'--imu /b is not in it; there is /a \(sensor_msgs/msg/Imu\), /odom'),
        (['/a'], '/odom', '--imu /odom holds nav_msgs/msg/Odometry, not sensor_msgs/msg/Imu'),
    ],
)
def test_what_can_not_be_chosen_is_named(topics, imu, words):
    with pytest.raises(RecordingError, match=words):
        chosen(topics, [RAW], imu)


def test_the_namespace_is_that_of_the_imu():
    assert namespace(['/robot1/imu/data_raw']) == '/robot1/'
    assert namespace(['/imu/data']) == '/'
    assert namespace(['/phone']) == '/'


TWIST = 'geometry_msgs/msg/TwistWithCovarianceStamped'
ODOMETRY = 'nav_msgs/msg/Odometry'
POSE = 'geometry_msgs/msg/PoseWithCovarianceStamped'
ALL = (RAW, COMPASS, AIDING_TWIST, AIDING_ODOMETRY, AIDING_POSE, SET_POSE)


@pytest.mark.parametrize(
    ('types', 'remaps', 'expected'),
    [
        (
            {'/aiding/twist': TWIST, '/aiding/odom': ODOMETRY, '/aiding/pose': POSE},
            {},
            {
                '/aiding/twist': (AIDING_TWIST,),
                '/aiding/odom': (AIDING_ODOMETRY,),
                '/aiding/pose': (AIDING_POSE,),
            },
        ),
        ({'/set_pose': POSE}, {}, {'/set_pose': (SET_POSE,)}),
        ({'/aiding/odom': TWIST, '/odom': ODOMETRY, '/wheels/odom': ODOMETRY}, {}, {}),
        (
            {'/aiding/odom': ODOMETRY, '/wheels/odom': ODOMETRY, '/gps': POSE, '/north': KIND},
            {
                AIDING_ODOMETRY: '/wheels/odom',
                AIDING_POSE: '/gps',
                SET_POSE: '/gps',
                COMPASS: '/north',
                RAW: '/imu/data_raw',
            },
            {
                '/north': (COMPASS,),
                '/wheels/odom': (AIDING_ODOMETRY,),
                '/gps': (AIDING_POSE, SET_POSE),
            },
        ),
    ],
)
def test_aiding_is_found_by_name_and_type_or_as_it_is_named(types, remaps, expected):
    types = {'/imu/data_raw': KIND, '/imu/other': KIND} | types
    found = choose(PATH, types, ALL, None, remaps)
    assert found == {'/imu/data_raw': (RAW,)} | expected


@pytest.mark.parametrize(
    ('remaps', 'words'),
    [
        ({'odom': '/wheels'}, '--remap odom: no such input; there are imu/data_raw, compass/data'),
        ({AIDING_TWIST: '/gps'}, '--remap aiding/twist:=/gps is not in it; there is /imu'),
        ({AIDING_TWIST: '/wheels'}, f'/wheels holds {ODOMETRY}, not {TWIST}; there is /imu'),
    ],
)
def test_what_can_not_be_remapped_is_named(remaps, words):
    types = {'/imu': KIND, '/wheels': ODOMETRY}
    with pytest.raises(RecordingError, match=words):
        choose(PATH, types, ALL, None, remaps)
