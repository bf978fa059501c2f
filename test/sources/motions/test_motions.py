"""Laws that every motion keeps: its truth is exact, smooth, and rests at both ends."""

import numpy as np
import pytest

from dead_reckoning.sources import motions
from dead_reckoning.sources.motions import kinematics

STEP = 1e-5

VARIANTS = {
    'gait': [
        {'strides': 3, 'turn': 0.3, 'rise': 0.2},
        {'strides': 3, 'stride_time': 0.7, 'stride_length': 2.4, 'stance': 0.2, 'pitch': 1.4},
    ],
    'lift': [{'height': -3.0}, {'height': 0.1}, {'height': 0.0}],
    'slide': [{'distance': -2.0, 'axis': 'z'}],
    'square': [{'pause': 0.0}],
    'turntable': [{'angle': -2.0, 'rate': 3.0}, {'angle': 0.1}, {'radius': 0.0}],
    'vehicle': [{'stops': 1, 'loops': 1}],
    'walk': [
        {'cadence': 3.3, 'step_length': 1.2, 'heading': 2.0},
        {'cadence': 0.8, 'steps': 7},
        {'steps': 1},
    ],
}
"""Of each motion, what is worth a look beside its defaults."""

CASES = [
    pytest.param((name, settings), id=f'{name} {settings}' if settings else name)
    for name in motions.names()
    for settings in [{}, *VARIANTS.get(name, [])]
]


@pytest.fixture(params=CASES)
def body(request):
    name, settings = request.param
    kind = motions.motion_class(name)
    return kind(kind.Settings(**settings))


def times(body, count=4003):
    """Cover the motion and the rests before and after it."""
    return np.linspace(-0.5, body.duration + 1.0, count)


def slope(body, time, part):
    before, after = (getattr(body.at(time + side * STEP), part) for side in (-1.0, 1.0))
    return (after - before) / (2.0 * STEP)


def test_velocity_is_the_derivative_of_position(body):
    time = times(body)
    np.testing.assert_allclose(body.at(time).velocity, slope(body, time, 'position'), atol=1e-5)


def test_acceleration_is_the_derivative_of_velocity(body):
    time = times(body)
    found = body.at(time).acceleration
    expected = slope(body, time, 'velocity')
    np.testing.assert_allclose(found, expected, atol=2e-5 * max(1.0, np.abs(found).max()))


def test_angular_velocity_is_how_the_rotation_changes(body):
    """``rot(t)ᵀ · d rot/dt`` is the cross product with the rate, in the body's frame."""
    time = times(body)
    truth = body.at(time)
    change = np.einsum('nji,njk->nik', truth.rotation, slope(body, time, 'rotation'))
    x, y, z = change[:, 2, 1], change[:, 0, 2], change[:, 1, 0]
    np.testing.assert_allclose(truth.angular_velocity, np.column_stack([x, y, z]), atol=1e-6)
    np.testing.assert_allclose(change, -np.swapaxes(change, 1, 2), atol=1e-6)


def test_rotation_is_one(body):
    rotation = body.at(times(body)).rotation
    unity = np.einsum('nij,nkj->nik', rotation, rotation)
    np.testing.assert_allclose(unity, np.broadcast_to(np.eye(3), unity.shape), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(rotation), 1.0)


@pytest.mark.parametrize('part', ['acceleration', 'angular_velocity', 'rotation'])
def test_nothing_jumps(body, part):
    """Over a fourth of the time the largest change is about a fourth."""
    changes = []
    for rate in (2000.0, 8000.0):
        time = np.arange(0.0, min(body.duration + 0.5, 10.0), 1.0 / rate)
        changes.append(np.abs(np.diff(getattr(body.at(time), part), axis=0)).max())
    assert changes[1] <= 0.3 * changes[0] + 1e-12


def test_it_starts_and_ends_at_rest(body):
    for time in ([-1e6, -1.0, 0.0], body.duration + np.array([0.0, 1e-9, 0.001, 1.0, 1e6])):
        truth = body.at(np.array(time))
        for part in (truth.velocity, truth.acceleration, truth.angular_velocity):
            np.testing.assert_allclose(part, 0.0, atol=1e-9)
        for part in (truth.position, truth.rotation):
            np.testing.assert_allclose(part, np.broadcast_to(part[0], part.shape), atol=1e-13)
    assert not body.at(np.array([body.duration + 1e-6])).velocity.any(), 'to the last bit'


def test_it_begins_at_the_origin_facing_ahead_or_as_set(body):
    start = body.at(np.array([0.0]))
    np.testing.assert_array_equal(start.position, 0.0)
    np.testing.assert_array_equal(start.euler[:, :2], 0.0)


def test_each_moment_stands_alone(body):
    time = times(body, 50)
    together = body.at(time)
    for part in ('position', 'velocity', 'acceleration', 'rotation', 'angular_velocity'):
        alone = [getattr(body.at(time[k : k + 1]), part)[0] for k in range(50)]
        np.testing.assert_array_equal(getattr(together, part), alone)


def test_shapes(body):
    for count in (0, 1, 7):
        truth = body.at(np.linspace(0.0, 5.0, count))
        for part in ('position', 'velocity', 'acceleration', 'angular_velocity', 'euler'):
            assert getattr(truth, part).shape == (count, 3)
        assert truth.rotation.shape == (count, 3, 3)


def test_steps_come_in_order_within_the_motion(body):
    steps = body.steps
    assert len(steps.times) == len(steps.lengths)
    assert (np.diff(steps.times) > 0.0).all()
    assert ((steps.times > 0.0) & (steps.times < body.duration)).all()
    assert (steps.lengths >= 0.0).all()


@pytest.mark.parametrize('name', motions.names())
def test_settings_carry_the_name(name):
    assert motions.motion_class(name).Settings.prefix == f'driver.{name}'


def test_rotation_is_roll_then_pitch_then_yaw_about_fixed_axes():
    nothing = np.zeros((3, 3))
    euler = np.array([[0.3, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.3]])
    rotation = kinematics(nothing, nothing, nothing, euler).rotation
    c, s = np.cos(0.3), np.sin(0.3)
    np.testing.assert_allclose(rotation[0] @ [0.0, 1.0, 0.0], [0.0, c, s])
    np.testing.assert_allclose(rotation[1] @ [1.0, 0.0, 0.0], [c, 0.0, -s])
    np.testing.assert_allclose(rotation[2] @ [1.0, 0.0, 0.0], [c, s, 0.0])
    together = kinematics(nothing, nothing, nothing, np.array([[0.1, 0.2, 0.3]] * 3)).rotation[0]
    one_by_one = kinematics(nothing, nothing, nothing, np.diag([0.1, 0.2, 0.3])).rotation
    np.testing.assert_allclose(together, one_by_one[2] @ one_by_one[1] @ one_by_one[0])
