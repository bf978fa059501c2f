"""Parameters: what is wrong stops a node in one line, what may change does so at once."""

import itertools
import math
from pathlib import Path

import pytest
from geometry_msgs.msg import AccelWithCovarianceStamped
from messages import Feed, acceleration_message, imu_message
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import DescribeParameters
from ros_harness import NODES, NodeProcess, lossless
from sensor_msgs.msg import Imu

CONFIG = Path(__file__).resolve().parents[2] / 'config'

NUMBER = {
    'accelerometer_driver': ('driver.supply', 'a finite number from 1.8 to 3.6 [V]'),
    'gravity_removal': ('gravity.magnitude', 'a finite number from 9.7 to 9.9 [m/s²]'),
    'integrator': ('integrator.max_gap', 'a finite number from 0.001 to 60 [s]'),
    'pipeline': ('driver.slide.duration', 'a finite number from 0.01 to 1000 [s]'),
}
CHOICE = {
    'accelerometer_driver': ('driver.motion', "'slide'"),
    'gravity_removal': ('gravity.attitude', "'message'"),
    'integrator': ('integrator.method', "'euler'"),
    'pipeline': ('pipeline.source', "'topic'"),
}
MISSPELT = {
    'accelerometer_driver': ('driver.sample_rat', 'driver.sample_rate'),
    'gravity_removal': ('gravity.atitude', 'gravity.attitude'),
    'integrator': ('integrator.window_minimun', 'integrator.window_minimum'),
    'pipeline': ('pipeline.estimator', 'pipeline.estimators'),
}
LIST = {
    'accelerometer_driver': ('driver.zero_g', 'a list of 3 elements, each a finite number'),
    'integrator': ('integrator.axes', "each one of 'x', 'y', 'z'"),
    'pipeline': ('pipeline.estimators', 'a list of one or more elements, none twice, each one of'),
}
WHOLE = {
    'accelerometer_driver': ('driver.samples_per_message', 'an integer from 1 to 65536'),
    'integrator': ('integrator.movement_end_samples', 'an integer from 1 to 1000000'),
    'pipeline': ('driver.samples_per_message', 'an integer from 1 to 65536'),
}
SWITCH = {
    'accelerometer_driver': ('driver.calibrate_on_start', 'true or false'),
    'gravity_removal': ('gravity.measure', 'true or false'),
    'integrator': ('frames.publish_tf', 'true or false'),
    'pipeline': ('gravity.measure', 'true or false'),
}

WRONG = {
    'out of range': (NUMBER, -1.0, '-1.0'),
    'NaN': (NUMBER, math.nan, 'nan'),
    'infinite': (NUMBER, math.inf, 'inf'),
    'a string for a number': (NUMBER, 'three', "'three'"),
    'a boolean for a number': (NUMBER, True, 'True'),
    'a list for a number': (NUMBER, [3.0], '[3.0]'),
    'no such choice': (CHOICE, 'guess', "'guess'"),
    'a number for a string': (CHOICE, 3, '3'),
    'a boolean for a string': (CHOICE, True, "True is not allowed"),
    'an empty list': (LIST, [], '[]'),
    'a list of another kind': (LIST, [True, False, True], '[True, False, True]'),
    'a scalar for a list': (LIST, 'x', "'x'"),
    'a fraction for an integer': (WHOLE, 2.5, '2.5'),
    'an integer out of range': (WHOLE, 0, '0'),
    'a number for a boolean': (SWITCH, 1, '1'),
}  # fmt: skip


@pytest.fixture
def start(module_domain_id, tmp_path):
    """Start a node that shall stop by itself."""
    numbers = itertools.count()

    def start(name, parameters=None, *arguments, file=None):
        folder = tmp_path / f'{next(numbers)}'
        return NodeProcess(name, module_domain_id, folder, parameters, arguments, file=file)

    return start


def complaint_of(node):
    """Return the one line that a node ends with."""
    status = node.wait()
    assert node.stdout == ''
    (line,) = node.stderr.splitlines()
    assert status == 2
    return line


@pytest.mark.parametrize('wrong', WRONG)
def test_a_wrong_value_stops_a_node(start, wrong):
    keys, value, shown = WRONG[wrong]
    started = {name: start(name, {key: value}) for name, (key, _) in keys.items()}
    for name, node in started.items():
        key, allowed = keys[name]
        line = complaint_of(node)
        assert f'{key}: ' in line
        assert shown in line
        assert allowed in line


def test_a_misspelt_key_stops_a_node_with_a_suggestion(start):
    started = {name: start(name, {key: 1}) for name, (key, _) in MISSPELT.items()}
    for name, node in started.items():
        key, meant = MISSPELT[name]
        line = complaint_of(node)
        assert f'{key}: ' in line
        assert f"did you mean '{meant}'?" in line


def test_an_unknown_prefix_stops_a_node(start):
    for node in [start(name, {'filter.cutoff': 30.0}) for name in NODES]:
        line = complaint_of(node)
        assert 'filter.cutoff: no such parameter' in line
        for prefix in ('common', 'driver', 'frames', 'gravity', 'integrator', 'pipeline'):
            assert prefix in line


def test_a_misspelt_key_of_another_node_stops_a_node_too(start):
    line = complaint_of(start('integrator', {'driver.range': 1.5}))
    assert "did you mean 'driver.range_g'?" in line


def test_values_that_contradict_each_other_stop_a_node(start):
    window = {'integrator.window_minimum': 0.0, 'integrator.window_maximum': 0.0}
    line = complaint_of(start('integrator', window))
    assert 'integrator.window_maximum: 0.0 leaves the movement-end check nothing' in line
    assert 'integrator.movement_end' in line


def test_an_empty_frame_stops_a_node(start):
    line = complaint_of(start('gravity_removal', {'frames.world': ''}))
    assert 'frames.world: an empty frame name' in line


WRONG_FOR_ROS = [
    ('use_sim_time', 3, "expecting type 'BOOL'"),
    ('start_type_description_service', 'no', "expecting type 'BOOL'"),
    ('qos_overrides./odom.publisher.reliability', 'sure', "one of 'system_default', 'reliable'"),
    ('qos_overrides./odom.publisher.history', 5, "'keep_last', 'keep_all'"),
    ('qos_overrides./imu/data.subscription.depth', -1, 'an integer from 0 to'),
    ('qos_overrides./imu/data.subscription.depth', 1.5, 'an integer from 0 to'),
]


def test_a_wrong_value_of_a_key_of_ros_stops_a_node(start):
    started = [start('integrator', {key: value}) for key, value, _ in WRONG_FOR_ROS]
    for node, (key, value, allowed) in zip(started, WRONG_FOR_ROS, strict=True):
        line = complaint_of(node)
        assert key in line
        assert str(value) in line
        assert allowed in line


def test_an_unquoted_y_in_a_list_stops_a_node_with_the_remedy(start, tmp_path):
    file = tmp_path / 'yes.yaml'
    file.write_text('/**:\n  ros__parameters:\n    integrator.axes: [x, y]\n')
    for node in [start(name, file=file) for name in NODES]:
        line = complaint_of(node)
        assert str(file) in line
        assert 'line_num 3' in line
        assert "quote it, as 'y'" in line


def test_an_unquoted_y_alone_stops_a_node_with_the_remedy(start):
    line = complaint_of(start('integrator', None, '-p', 'integrator.axes:=[y]'))
    assert 'integrator.axes: [True] is not allowed' in line
    assert "quote it, as 'y'" in line


def test_a_missing_parameter_file_stops_a_node(start, tmp_path):
    for node in [start(name, file=tmp_path / 'nowhere.yaml') for name in NODES]:
        line = complaint_of(node)
        assert 'nowhere.yaml' in line
        assert 'Error opening YAML file' in line


BROKEN = {
    'unfinished': 'integrator: [',
    'sectionless': 'integrator:\n  max_gap: 1.0\n',
    'empty': '/**:\n  ros__parameters:\n    integrator.max_gap:\n',
    'mixed': '/**:\n  ros__parameters:\n    integrator.axes: [1, 2.0]\n',
    'tabbed': '\t\n',
}


def test_a_broken_parameter_file_stops_a_node(start, tmp_path):
    started = {}
    for name, text in BROKEN.items():
        file = tmp_path / f'{name}.yaml'
        file.write_text(text)
        started[file] = start('integrator', file=file)
    for file, node in started.items():
        line = complaint_of(node)
        assert str(file) in line
        assert 'at line' in line or 'line_num' in line or 'near line' in line


def test_a_wrong_argument_stops_a_node(start):
    arguments = [('--bogus',), ('-p', 'nonsense'), ('-r', 'odom'), ('--log-level', 'loud')]
    started = [start('integrator', None, *argument) for argument in arguments]
    for node, argument in zip(started, arguments, strict=True):
        assert argument[-1] in complaint_of(node)


@pytest.mark.parametrize('file', sorted(CONFIG.glob('*.yaml')), ids=lambda file: file.stem)
def test_all_nodes_take_one_committed_file(ros, file):
    for name in NODES:
        ros.start(name, None, '--params-file', str(file))
    for name in NODES:
        assert ros.get(name, 'frames.world') == ['odom']


def test_what_is_meant_is_taken(ros):
    """Integers where doubles are meant, keys of other parts, and ROS's own keys."""
    ros.start(
        'accelerometer_driver',
        {
            'driver.supply': 3,
            'driver.zero_g': [1, 2, 1],
            'driver.sample_rate': 100,
            'integrator.method': 'euler',
            'gravity.attitude': 'message',
            'pipeline.source': 'topic',
            'use_sim_time': False,
            'start_type_description_service': False,
            'qos_overrides./odom.publisher.depth': 7,
            'qos_overrides./imu/data_raw.publisher.depth': 7,
        },
    )
    taken = ros.get(
        'accelerometer_driver',
        'driver.supply',
        'driver.zero_g',
        'driver.sensitivity',
        'qos_overrides./imu/data_raw.publisher.depth',
    )
    supply, zero_g, sensitivity, depth = taken
    assert (type(supply), supply) == (float, 3.0)
    assert list(zero_g) == [1.0, 2.0, 1.0]
    assert list(sensitivity) == pytest.approx([0.8 * 3.0 / 3.3] * 3), 'it follows from the supply'
    assert depth == 7


@pytest.fixture(scope='module')
def integrator(module_ros):
    """One integrator for all tests of changes."""
    return module_ros.start('integrator', lossless('/imu/linear_acceleration', '/imu/data'))


@pytest.fixture
def defaults(integrator, module_ros):
    """Put the mutable parameters back before a test."""
    result = module_ros.set_at_once(
        'integrator',
        integrator__window_minimum=-0.05,
        integrator__window_maximum=0.05,
        integrator__movement_end='all',
        integrator__movement_end_samples=25,
    )
    assert result.successful
    return module_ros


def test_descriptors_say_what_the_declaration_says(defaults):
    names = ['integrator.max_gap', 'integrator.movement_end_samples', 'integrator.method']
    request = DescribeParameters.Request(names=names)
    answer = defaults.call(DescribeParameters, 'integrator/describe_parameters', request)
    gap, samples, method = answer.descriptors
    assert gap.type == ParameterType.PARAMETER_DOUBLE
    assert gap.read_only
    assert gap.description.endswith('[s]')
    (reach,) = gap.floating_point_range
    assert (reach.from_value, reach.to_value) == (0.001, 60.0)
    assert samples.type == ParameterType.PARAMETER_INTEGER
    assert not samples.read_only
    (reach,) = samples.integer_range
    assert (reach.from_value, reach.to_value, reach.step) == (1, 1_000_000, 1)
    assert method.type == ParameterType.PARAMETER_STRING
    assert method.additional_constraints == "one of 'trapezoid', 'euler', 'kalman'"


def test_an_integer_is_taken_for_a_double_while_running(defaults):
    (result,) = defaults.set('integrator', integrator__window_maximum=1)
    assert result.successful, result.reason
    (value,) = defaults.get('integrator', 'integrator.window_maximum')
    assert (type(value), value) == (float, 1.0)


@pytest.mark.parametrize(
    ('key', 'value'),
    [
        ('integrator.window_maximum', -1.0),
        ('integrator.window_maximum', math.nan),
        ('integrator.window_maximum', math.inf),
        ('integrator.movement_end', 'never'),
        ('integrator.movement_end_samples', 0),
        ('integrator.max_gap', 1.0),  # read-only
        ('integrator.axes', ['x']),  # read-only
    ],
)
def test_a_wrong_change_is_refused_with_the_key(defaults, key, value):
    before = defaults.get('integrator', key)
    (result,) = defaults.set('integrator', **{key: value})
    assert not result.successful
    assert key in result.reason
    assert defaults.get('integrator', key) == before


@pytest.mark.parametrize('value', ['wide', True, None, [0.1]])
def test_a_change_of_the_wrong_type_is_refused(defaults, value):
    (result,) = defaults.set('integrator', integrator__window_maximum=value)
    assert not result.successful
    assert result.reason
    assert defaults.get('integrator', 'integrator.window_maximum') == [0.05]


@pytest.mark.parametrize(
    'changes',
    [
        {'integrator__window_minimum': -0.2, 'integrator__window_maximum': -0.1},
        {'integrator__window_maximum': -0.1, 'integrator__window_minimum': -0.2},
        {'integrator__window_minimum': 0.0, 'integrator__window_maximum': 0.0},
        {'integrator__movement_end_samples': 3, 'integrator__movement_end': 'never'},
        {'integrator__movement_end_samples': 3, 'integrator__max_gap': 1.0},
    ],
)
def test_changes_come_all_or_none(defaults, changes):
    keys = [name.replace('__', '.') for name in changes]
    before = defaults.get('integrator', *keys)
    result = defaults.set_at_once('integrator', **changes)
    assert not result.successful
    assert any(key in result.reason for key in keys)
    assert defaults.get('integrator', *keys) == before


def test_changes_made_together_are_checked_together(defaults):
    result = defaults.set_at_once(
        'integrator',
        integrator__window_minimum=0.0,
        integrator__window_maximum=0,
        integrator__movement_end='off',
    )
    assert result.successful, result.reason
    # Now the check may not come back unless the window opens in the same set.
    (refused,) = defaults.set('integrator', integrator__movement_end='all')
    assert not refused.successful
    assert 'integrator.window_maximum' in refused.reason


def test_a_change_shows_on_the_output(defaults):
    ros = defaults
    attitude = ros.publisher('imu/data', Imu)
    acceleration = ros.publisher('imu/linear_acceleration', AccelWithCovarianceStamped)

    def publish(stamp_ns, push):
        attitude.publish(imu_message(stamp_ns, (0.0, 0.0, 9.8), (0.0, 0.0, 0.0, 1.0)))
        acceleration.publish(acceleration_message(stamp_ns, (push, 0.0, 0.0)))

    odom = ros.record('odom', Odometry).connected()
    feed = Feed(ros, publish)

    def speed():
        return odom.messages[-1].twist.twist.linear.x

    feed.send_until(lambda: len(odom) > 30, 'odom', 0.04)
    assert speed() == 0.0, 'within the window'
    result = ros.set_at_once(
        'integrator', integrator__window_minimum=-0.01, integrator__window_maximum=0.01
    )
    assert result.successful, result.reason
    feed.send_until(lambda: speed() > 0.01, 'motion', 0.04)
    assert ros.set('integrator', integrator__movement_end_samples=2)[0].successful
    moving = len(odom)
    feed.send_until(lambda: len(odom) > moving and speed() == 0.0, 'rest', 0.0)
    result = ros.set_at_once('integrator', integrator__movement_end='off')
    assert result.successful, result.reason
    feed.send_until(lambda: speed() > 0.01, 'motion again', 0.04)
    moving = len(odom)
    feed.send_until(lambda: len(odom) > moving + 30, 'odom', 0.0)
    assert speed() > 0.01, 'the movement-end check is off'
