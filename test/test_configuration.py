"""All parts' settings in one place, and the files that hold them."""

import math

import pytest

from dead_reckoning.configuration import (
    COMMON,
    DRIVER,
    PARTS,
    Configuration,
    is_ros_key,
    read_values,
)
from dead_reckoning.core.errors import SettingsError
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integrator import IntegratorSettings
from dead_reckoning.core.parameters import Derived
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver_settings import DriverSettings

DECLARED = [pytest.param(part, d, id=d.key) for part in PARTS for d in part.parameters()]
WITHOUT_UNIT = {
    'compass.simulated.iron',
    'driver.gait.stance',
    'driver.gyro.scale_error',
    'driver.simulated.cross_axis',
    'driver.simulated.nonlinearity',
    'driver.simulated.sensitivity_error',
    'driver.simulated.supply_error',
    'driver.walk.asymmetry',
    'gravity.rate_scale_deviation',
    'integrator.scale_deviation',
    'navigator.acceleration_variance.share',
    'navigator.angular_rate.share',
    'navigator.aiding_gate',
    'navigator.averaging',
    'navigator.axis_gate',
    'navigator.floor_slope',
    'navigator.gate',
    'navigator.hysteresis',
    'navigator.magnitude.share',
    'navigator.rest_factor',
    'navigator.sampling_noise',
    'navigator.shoe.share',
    'pedometer.length_deviation',
    'pedometer.rhythm.centre',
    'pedometer.rhythm.faint',
    'pedometer.rhythm.gain',
    'pedometer.rhythm.likeness',
    'pedometer.rhythm.share',
    'pedometer.rhythm.strong',
    'pedometer.step_deviation',
}
"""Real numbers that are ratios."""


def scalar(declared):
    return getattr(declared.type, '__args__', (declared.type,))[0]


@pytest.mark.parametrize(('part', 'declared'), DECLARED)
def test_parameter_is_described(part, declared):
    assert len(declared.description) > 10
    assert declared.description == declared.description.strip()
    assert not declared.description.endswith('.')


@pytest.mark.parametrize(('part', 'declared'), DECLARED)
def test_default_passes_its_own_check(part, declared):
    value = getattr(part(), declared.name)
    assert declared.check(value) == value
    if not isinstance(declared.default, Derived):
        assert value == declared.default


@pytest.mark.parametrize(('part', 'declared'), DECLARED)
def test_real_number_has_a_unit(part, declared):
    if scalar(declared) is float and not declared.choices:
        assert bool(declared.unit) is (declared.key not in WITHOUT_UNIT)
    elif scalar(declared) in (bool, str):
        assert not declared.unit


@pytest.mark.parametrize(('part', 'declared'), DECLARED)
def test_nan_and_infinity_pass_no_check(part, declared):
    for value in (math.nan, math.inf, -math.inf):
        with pytest.raises(SettingsError):
            declared.check(value)
        with pytest.raises(SettingsError):
            declared.check([value] * max(1, declared.length))


def test_derived_default_says_what_it_follows_from():
    defaults = [declared.default for part in PARTS for declared in part.parameters()]
    words = [default.words for default in defaults if isinstance(default, Derived)]
    assert words
    assert all(words)


def test_keys_are_unique():
    keys = [declared.key for part in PARTS for declared in part.parameters()]
    assert len(set(keys)) == len(keys)
    assert not any(is_ros_key(key) for key in keys)


def test_all_parts_are_listed():
    assert set(COMMON) | set(DRIVER) <= set(PARTS)
    for name in motions.names():
        assert motions.motion_class(name).Settings in PARTS


def test_defaults_need_no_values():
    configuration = Configuration()
    for part in PARTS:
        assert configuration[part].values() == part().values()


def test_values_reach_their_part():
    configuration = Configuration({'driver.range_g': 2, 'integrator.method': 'euler'})
    assert configuration[DriverSettings].range_g == 2.0
    assert configuration[IntegratorSettings].method == 'euler'
    assert configuration[GravitySettings].attitude == 'rest'


@pytest.mark.parametrize(
    ('values', 'said'),
    [
        (
            {'integrator.methode': 'euler'},
            "integrator.methode: no such parameter; did you mean 'integrator.method'?",
        ),
        ({'xyzzy.q': 1}, 'xyzzy.q: no such parameter; known prefixes: common, compass, driver, '),
        ({'integrator.method': 'rk4'}, "integrator.method: 'rk4' is not allowed; one of "),
        ({'driver.slide.axis': True}, 'driver.slide.axis: True is not allowed; '),
        ({'frames.body': 'odom'}, 'frames.body: '),
        ({'frames.world': ''}, 'frames.world: an empty frame name'),
    ],
)
def test_wrong_key_or_value_is_refused(values, said):
    with pytest.raises(SettingsError) as caught:
        Configuration(values)
    assert str(caught.value).startswith(said)


# Files ----------------------------------------------------------------------------------------


@pytest.fixture
def file_of(tmp_path):
    def write(text):
        path = tmp_path / 'settings.yaml'
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def test_file_is_read_nested_or_flat(file_of):
    path = file_of(
        """\
/**:
  ros__parameters:
    driver:
      range_g: 2.0
      slide: {distance: 1, axis: 'y'}
    integrator.method: euler
    integrator.axes: [x, 'y']
"""
    )
    assert read_values(path) == {
        'driver.range_g': 2.0,
        'driver.slide.distance': 1,
        'driver.slide.axis': 'y',
        'integrator.method': 'euler',
        'integrator.axes': ['x', 'y'],
    }
    configuration = Configuration.load(path)
    assert configuration[DriverSettings].range_g == 2.0
    assert configuration[IntegratorSettings].axes == ('x', 'y')


def test_keys_of_ros_pass(file_of):
    path = file_of(
        """\
/**:
  ros__parameters:
    use_sim_time: true
    start_type_description_service: false
    qos_overrides:
      /imu/data: {subscription: {depth: 5}}
    driver.range_g: 4.0
"""
    )
    assert read_values(path) == {'driver.range_g': 4.0}


@pytest.mark.parametrize(
    ('text', 'value'),
    [('1', 1), ('1.5', 1.5), ('1e-3', 1e-3), ('2E1', 20.0), ('-1e-3', -1e-3), ('1.0e-3', 1e-3)],
)
def test_numbers_are_read_as_rcl_reads_them(file_of, text, value):
    values = read_values(file_of(f'/**: {{ros__parameters: {{driver.noise: {text}}}}}'))
    assert values == {'driver.noise': value}
    assert type(values['driver.noise']) is type(value)


@pytest.mark.parametrize(
    ('text', 'value'),
    [('y', True), ('Y', True), ('n', False), ('N', False), ('on', True), ('no', False)],
)
def test_booleans_are_read_as_rcl_reads_them(file_of, text, value):
    path = file_of(f'/**: {{ros__parameters: {{frames.publish_tf: {text}}}}}')
    assert read_values(path) == {'frames.publish_tf': value}


@pytest.mark.parametrize('text', ['y', 'Y', 'n', 'yes', 'on'])
def test_unquoted_y_is_a_boolean_as_in_rcl_and_the_hint_says_so(file_of, text):
    path = file_of(f'/**: {{ros__parameters: {{driver.slide.axis: {text}}}}}')
    with pytest.raises(SettingsError, match="quote it, as 'y'"):
        Configuration.load(path)


@pytest.mark.parametrize('text', ["'y'", '"y"', 'x', "'1e-3'", 'yx', 'n1'])
def test_quoted_and_longer_words_are_strings(file_of, text):
    values = read_values(file_of(f'/**: {{ros__parameters: {{frames.world: {text}}}}}'))
    assert values == {'frames.world': text.strip('\'"')}


@pytest.mark.parametrize(
    'text',
    [
        '',
        'driver: {range_g: 2.0}',
        '/**: {}',
        '/**:',
        '/**: {ros__parameters: }',
        '/**: {ros__parameters: [1, 2]}',
        '/**: text',
        '[1, 2]',
        'text',
    ],
)
def test_file_without_the_section_is_refused(file_of, text):
    with pytest.raises(SettingsError, match=r"no section '/\*\*: ros__parameters:'"):
        read_values(file_of(text))


@pytest.mark.parametrize('text', ['{', '/**: [', 'a: b: c', '\t', b'\xff\xfe\x00\x01', b'\x00'])
def test_what_is_no_yaml_is_refused_with_its_path(file_of, text):
    path = file_of(text)
    with pytest.raises(SettingsError) as caught:
        read_values(path)
    assert str(caught.value).startswith(str(path))


def test_missing_file_is_refused_with_its_path(tmp_path):
    with pytest.raises(SettingsError, match=r'nothing\.yaml: No such file or directory'):
        read_values(tmp_path / 'nothing.yaml')


def test_folder_is_refused(tmp_path):
    with pytest.raises(SettingsError, match='Is a directory'):
        read_values(tmp_path)
