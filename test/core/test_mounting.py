"""How a sensor sits on its body: samples turned, states carried, motions simulated and found."""

import math
from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.chain import FAULT, Chain
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import (
    MissingAccelerationError,
    MissingMountingError,
    MountingError,
    NotLevelledError,
    SettingsError,
)
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.mounting import Mounting, carried, mountings_of
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import (
    matrix_from_quaternion,
    quaternion_from_euler,
    quaternion_from_matrix,
)
from dead_reckoning.core.samples import (
    IDENTITY_QUATERNION,
    NOT_MEASURED,
    UNKNOWN,
    ImuSample,
    NavigationState,
)
from dead_reckoning.core.stages import (
    ACCELERATION,
    IMU,
    ODOMETRY,
    RAW,
    gravity_stage,
    integrator_stage,
    pairing_stage,
)
from dead_reckoning.sources import motions
from dead_reckoning.sources.driver import front_end, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings

START_NS = 1_700_000_000_000_000_000
RIGHT = math.pi / 2.0
MOUNTINGS = {
    'upside down, about x': (math.pi, 0.0, 0.0),
    'upside down, about y': (0.0, math.pi, 0.0),
    'on its right side': (RIGHT, 0.0, 0.0),
    'on its nose': (0.0, RIGHT, 0.0),
    'on its tail': (0.0, -RIGHT, 0.0),
    'facing left': (0.0, 0.0, RIGHT),
    'facing back': (0.0, 0.0, math.pi),
    'on its side, facing back': (RIGHT, 0.0, math.pi),
    'anyhow': (0.3, -1.1, 2.5),
}
WHAT_IT_READS = {
    'upside down, about x': (1.0, -2.0, -3.0),
    'upside down, about y': (-1.0, 2.0, -3.0),
    'on its right side': (1.0, 3.0, -2.0),
    'on its nose': (-3.0, 2.0, 1.0),
    'on its tail': (3.0, 2.0, -1.0),
    'facing left': (2.0, -1.0, 3.0),
    'facing back': (-1.0, -2.0, 3.0),
}
"""A vector (1, 2, 3) of the body: each axis of the sensor written down by hand."""
SPHERE = (1e-4, 0.0, 0.0, 0.0, 1e-4, 0.0, 0.0, 0.0, 1e-4)


@pytest.fixture(params=MOUNTINGS, name='turn')
def each_mounting(request):
    return MOUNTINGS[request.param]


def matrix(turn):
    """Return what takes the sensor into the body, shape (3, 3)."""
    return np.reshape(matrix_from_quaternion(quaternion_from_euler(*turn)), (3, 3))


def seen_by_sensor(sample, turn):
    """Return a sample of the body as a sensor that sits so would measure it, by numpy alone."""
    rot_bs = matrix(turn)
    orientation = sample.orientation
    if orientation is not None:
        rot_wb = np.reshape(matrix_from_quaternion(orientation), (3, 3))
        orientation = quaternion_from_matrix(tuple((rot_wb @ rot_bs).ravel().tolist()))
    rate = sample.angular_velocity
    return ImuSample(
        sample.stamp_ns,
        sample.frame_id,
        tuple((rot_bs.T @ sample.specific_force).tolist()),
        sample.specific_force_covariance,
        None if rate is None else tuple((rot_bs.T @ rate).tolist()),
        sample.angular_velocity_covariance,
        orientation,
        sample.orientation_covariance,
    )


def simulated(seconds, values):
    """Return samples of the simulated sensor, and the truth at each."""
    configuration = Configuration(values)
    source = simulated_sensor(configuration, START_NS)
    count = round(seconds * configuration[DriverSettings].sample_rate)
    samples = front_end(configuration).add(source.read(count))
    return samples, [source.truth(sample.stamp_ns) for sample in samples]


def run(samples, values, name=RAW):
    """Run the whole chain; return states by stamp, and faults."""
    chain = Pipeline(Configuration(values)).chain
    flow = [output for sample in samples for output in chain.push(name, sample)]
    states = {state.stamp_ns: state for name, state in flow if name == ODOMETRY}
    return states, [fault for name, fault in flow if name == FAULT]


# One sample -----------------------------------------------------------------------------------


@pytest.mark.parametrize('name', WHAT_IT_READS)
def test_axes_are_where_the_name_says(name):
    mounting = Mounting(quaternion_from_euler(*MOUNTINGS[name]))
    for part in ('specific_force', 'angular_velocity'):
        parts = {'specific_force': (0.0, 0.0, 1.0), part: WHAT_IT_READS[name]}
        turned = mounting.to_body(ImuSample(1, 'imu_link', **parts))
        assert getattr(turned, part) == pytest.approx((1.0, 2.0, 3.0))


def test_orientation_becomes_that_of_the_body(turn):
    """A body that is level and faces east carries a sensor whose orientation is its mounting."""
    q_bs = quaternion_from_euler(*turn)
    sample = ImuSample(1, 'imu_link', (0.0, 0.0, 1.0), orientation=q_bs)
    assert Mounting(q_bs).to_body(sample).orientation == pytest.approx(IDENTITY_QUATERNION)


def test_there_and_back_changes_nothing(turn):
    mounting = Mounting(quaternion_from_euler(*turn))
    covariance = (3e-4, 1e-4, 0.0, 1e-4, 2e-4, -1e-4, 0.0, -1e-4, 5e-4)
    sample = ImuSample(
        5, 'imu_link', (1.0, 2.0, 3.0), covariance, (0.1, 0.2, 0.3), covariance,
        (0.5, 0.1, -0.5, 0.7), covariance,
    )  # fmt: skip
    back = mounting.to_sensor(mounting.to_body(sample))
    for field in ImuSample.__slots__:
        if field != 'frame_id':
            assert getattr(back, field) == pytest.approx(getattr(sample, field), abs=1e-12)
    assert back.frame_id == 'imu_link'


def test_covariance_turns_with_its_axes():
    long_x = (9.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    mounting = Mounting(quaternion_from_euler(0.0, 0.0, RIGHT))
    sample = ImuSample(1, 'imu_link', (0.0,) * 3, long_x, (0.0,) * 3, long_x)
    turned = mounting.to_body(sample)
    long_y = (1.0, 0.0, 0.0, 0.0, 9.0, 0.0, 0.0, 0.0, 1.0)
    assert turned.specific_force_covariance == pytest.approx(long_y)
    assert turned.angular_velocity_covariance == pytest.approx(long_y)


def test_what_is_not_known_or_not_measured_stays_so(turn):
    mounting = Mounting(quaternion_from_euler(*turn))
    turned = mounting.to_body(ImuSample(1, 'imu_link', (0.0, 0.0, 1.0), NOT_MEASURED))
    assert turned.specific_force_covariance == NOT_MEASURED
    assert turned.angular_velocity is None
    assert turned.angular_velocity_covariance == UNKNOWN
    assert turned.orientation is None
    removal = GravityRemoval(GravitySettings(), CommonSettings(), FrameSettings())
    with pytest.raises(MissingAccelerationError):
        removal.update(turned)


def test_identity_costs_nothing():
    sample = ImuSample(1, 'imu_link', (0.0, 0.0, 1.0), orientation=(0.0, 0.0, 0.6, 0.8))
    mounting = mountings_of(FrameSettings())('imu_link')
    assert mounting.to_body(sample) is sample
    assert mounting.to_sensor(sample) is sample


def test_parameters_hold_for_every_frame_id():
    frames = FrameSettings(mounting_rotation=(0.1, 0.2, 0.3), mounting_translation=(1.0, 2.0, 3.0))
    for frame_id in ('imu_link', 'base_link', ''):
        mounting = mountings_of(frames)(frame_id)
        assert mounting.rotation == quaternion_from_euler(0.1, 0.2, 0.3)
        assert mounting.translation == (1.0, 2.0, 3.0)


def test_a_chain_without_a_node_refuses_tf_with_the_remedy():
    with pytest.raises(SettingsError, match=r"frames\.mounting: 'tf' needs a node .*'parameters'"):
        Pipeline(Configuration({'frames.mounting': 'tf'}))


# Simulate, mount, recover ---------------------------------------------------------------------

SLIDE = {'driver.motion': 'slide', 'driver.slide.start': 1.5, 'driver.slide.duration': 1.0}


@pytest.fixture(scope='module')
def slide():
    samples, truth = simulated(4.0, SLIDE)
    return samples, truth[-1], run(samples, SLIDE)[0]


def test_slide_is_the_same_however_the_sensor_sits(slide, turn):
    samples, truth, straight = slide
    values = {**SLIDE, 'frames.mounting_rotation': turn}
    states, faults = run([seen_by_sensor(sample, turn) for sample in samples], values)
    assert {type(fault) for fault in faults} == {NotLevelledError}
    last = states[max(states)]
    assert last.position == pytest.approx(truth.position, abs=0.025)
    for stamp_ns, state in straight.items():
        other = states[stamp_ns]
        assert other.position == pytest.approx(state.position, abs=1e-9)
        assert other.velocity == pytest.approx(state.velocity, abs=1e-9)
        assert other.attitude == pytest.approx(state.attitude, abs=1e-9)
        assert other.position_covariance == pytest.approx(state.position_covariance, abs=1e-9)
        assert other.stationary == state.stationary


def test_unsaid_an_upside_down_sensor_is_warned_of(slide):
    samples = [seen_by_sensor(sample, (math.pi, 0.0, 0.0)) for sample in slide[0]]
    assert any(isinstance(fault, MountingError) for fault in run(samples, SLIDE)[1])


def test_orientation_of_messages_is_that_of_the_sensor(slide, turn):
    """REP-145: with attitude `message` the orientation is that of the frame of the message."""
    level = [
        ImuSample(s.stamp_ns, s.frame_id, s.specific_force, SPHERE, None, UNKNOWN, q, SPHERE)
        for s in slide[0]
        for q in [quaternion_from_euler(0.0, 0.0, 0.5)]
    ]
    values = {**SLIDE, 'gravity.attitude': 'message', 'frames.mounting_rotation': turn}
    straight, _ = run(level, {**values, 'frames.mounting_rotation': (0.0, 0.0, 0.0)}, IMU)
    states, faults = run([seen_by_sensor(sample, turn) for sample in level], values, IMU)
    assert not faults
    for stamp_ns, state in straight.items():
        assert states[stamp_ns].position == pytest.approx(state.position, abs=1e-9)
        assert np.abs(np.dot(states[stamp_ns].attitude, state.attitude)) == pytest.approx(1.0)


@pytest.mark.parametrize('attitude', ['rest', 'estimate'])
def test_imu_data_is_in_the_frame_of_the_sensor(turn, attitude):
    """What gravity removal hands on is what came in, with the orientation of the sensor."""
    values = {
        'gravity.attitude': attitude,
        'frames.mounting_rotation': turn,
        'frames.mounting_translation': (0.3, 0.2, 0.1),
    }
    chain = Pipeline(Configuration(values)).chain
    level = ImuSample(0, 'imu_link', (0.0, 0.0, GRAVITY), SPHERE, (0.0,) * 3, SPHERE)
    flow = []
    for k in range(100):
        sample = seen_by_sensor(level, turn)
        sample = ImuSample(START_NS + k * 10**7, 'imu_link', *fields(sample)[2:])
        flow = chain.push(RAW, sample)
    made = dict(flow)
    assert made[IMU].frame_id == 'imu_link'
    assert made[IMU].specific_force == pytest.approx(sample.specific_force)
    rot_ws = np.reshape(matrix_from_quaternion(made[IMU].orientation), (3, 3))
    assert rot_ws == pytest.approx(matrix(turn), abs=1e-6)
    assert made[ACCELERATION].acceleration == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert made[ODOMETRY].attitude == pytest.approx(IDENTITY_QUATERNION, abs=1e-6)
    assert made[ODOMETRY].position == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


def fields(sample):
    return [getattr(sample, name) for name in ImuSample.__slots__]


def test_two_nodes_give_what_one_chain_gives(slide):
    """Between the nodes, topics are in the frame of the sensor; the numbers are the same bits."""
    turn = MOUNTINGS['anyhow']
    values = {
        **SLIDE,
        'frames.mounting_rotation': turn,
        'frames.mounting_translation': (0.2, -0.1, 0.3),
    }
    parts = Configuration(values)
    common, frames = parts[CommonSettings], parts[FrameSettings]
    first = Chain(
        [
            gravity_stage(
                GravityRemoval(parts[GravitySettings], common, frames), mountings_of(frames)
            )
        ]
    )
    second = Chain(
        [
            pairing_stage(),
            integrator_stage(Integrator(parts[IntegratorSettings], common), mountings_of(frames)),
        ]
    )
    samples = [seen_by_sensor(sample, turn) for sample in slide[0]]
    whole, _ = run(samples, values)
    split = {}
    for sample in samples:
        for name, value in first.push(RAW, sample):
            if name in (IMU, ACCELERATION):
                for output, state in second.push(name, value):
                    if output == ODOMETRY:
                        split[state.stamp_ns] = state
    assert split.keys() == whole.keys()
    for stamp_ns, state in whole.items():
        assert [getattr(state, n) for n in state.__slots__] == [
            getattr(split[stamp_ns], n) for n in state.__slots__
        ]


def test_sample_before_its_mounting_is_known_costs_that_sample():
    known = {}

    def mountings(frame_id):
        if frame_id not in known:
            raise MissingMountingError(frame_id)
        return known[frame_id]

    chain = Pipeline(Configuration({'gravity.attitude': 'message'}), mountings=mountings).chain

    def push(k):
        return dict(
            chain.push(
                IMU,
                ImuSample(
                    START_NS + k * 10**7,
                    'imu_link',
                    (0.0, 0.0, GRAVITY),
                    SPHERE,
                    orientation=IDENTITY_QUATERNION,
                    orientation_covariance=SPHERE,
                ),
            )
        )

    for k in range(5):
        flow = push(k)
        assert isinstance(flow.pop(FAULT), MissingMountingError)
        assert not flow
    known['imu_link'] = Mounting(translation=(1.0, 0.0, 0.0))
    assert push(5)[ODOMETRY].position == (0.0, 0.0, 0.0)


# Lever arm ------------------------------------------------------------------------------------

RADIUS = 0.3
TURNTABLE = {
    'driver.motion': 'turntable',
    'driver.turntable.radius': RADIUS,
    'driver.turntable.start': 1.5,
    'driver.range_g': 2.0,
    'driver.gyro.enabled': True,
    'gravity.attitude': 'estimate',
    # The axis of the table, where base_link is, lies to the left of the sensor.
    'frames.mounting_translation': (0.0, -RADIUS, 0.0),
}


def exact(motion_name, rate, seconds, with_rate=True, **settings):
    """Return exact samples of a motion, attitude included, and its kinematics."""
    motion_class = motions.motion_class(motion_name)
    motion = motion_class(motion_class.Settings(**settings))
    time = np.arange(round(seconds * rate)) / rate
    truth = motion.at(time)
    lifted = truth.acceleration + np.array([0.0, 0.0, GRAVITY])
    forces = np.einsum('nji,nj->ni', truth.rotation, lifted)
    samples = [
        ImuSample(
            START_NS + round(t * 1e9),
            'imu_link',
            tuple(force),
            SPHERE,
            tuple(turn) if with_rate else None,
            SPHERE if with_rate else UNKNOWN,
            quaternion_from_matrix(tuple(rotation.ravel().tolist())),
            SPHERE,
        )
        for t, force, turn, rotation in zip(
            time, forces.tolist(), truth.angular_velocity.tolist(), truth.rotation, strict=True
        )
    ]
    return samples, truth


EXACT = {
    'gravity.attitude': 'message',
    'gravity.measure': False,
    'integrator.movement_end': 'off',
    'integrator.window_minimum': 0.0,
    'integrator.window_maximum': 0.0,
    'frames.mounting_translation': (0.0, -RADIUS, 0.0),
}


def test_base_link_stays_put_on_the_axis_of_a_turning_table():
    samples, truth = exact('turntable', 500.0, 7.5, radius=RADIUS, start=0.5)
    assert np.ptp(truth.position, axis=0)[:2] == pytest.approx(2.0 * RADIUS, abs=1e-3)
    states, _ = run(samples, EXACT, IMU)
    assert len(states) == len(samples)
    fastest = np.linalg.norm(truth.velocity, axis=1).max()
    assert fastest > 0.4
    for state in states.values():
        assert state.position == pytest.approx((0.0, 0.0, 0.0), abs=1e-3 * RADIUS)
        assert state.velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-3 * fastest)


def test_mounted_anyhow_on_the_table_it_stays_put_too(turn):
    samples, _ = exact('turntable', 200.0, 7.5, radius=RADIUS, start=0.5)
    values = {**EXACT, 'frames.mounting_rotation': turn}
    states, _ = run([seen_by_sensor(sample, turn) for sample in samples], values, IMU)
    for state in states.values():
        assert state.position == pytest.approx((0.0, 0.0, 0.0), abs=5e-3 * RADIUS)


def test_without_a_gyro_position_is_right_and_velocity_uncertain():
    samples, truth = exact('turntable', 500.0, 7.5, with_rate=False, radius=RADIUS, start=0.5)
    states, _ = run(samples, EXACT, IMU)
    turn_deviation = CommonSettings().turn_deviation
    for state, velocity in zip(states.values(), truth.velocity, strict=True):
        assert state.position == pytest.approx((0.0, 0.0, 0.0), abs=1e-3 * RADIUS)
        assert state.velocity == pytest.approx(tuple(velocity), abs=1e-3)
        assert state.angular_velocity is None
        rot_wb = np.reshape(matrix_from_quaternion(state.attitude), (3, 3))
        covariance = rot_wb.T @ np.reshape(state.velocity_covariance, (3, 3)) @ rot_wb
        assert covariance[0, 0] > (turn_deviation * RADIUS) ** 2
        assert covariance[2, 2] > (turn_deviation * RADIUS) ** 2


def test_velocity_in_the_body_is_that_of_base_link():
    """A body that walks a square with a sensor out of its centre: v_b = v_s − ω × r."""
    lever = np.array([0.4, -0.2, 0.1])
    samples, truth = exact('gait', 500.0, 8.0)
    values = {**EXACT, 'frames.mounting_translation': tuple(lever)}
    states, _ = run(samples, values, IMU)
    turned = np.cross(truth.angular_velocity, lever)
    assert np.abs(turned).max() > 0.1
    expected = truth.velocity - np.einsum('nij,nj->ni', truth.rotation, turned)
    places = truth.position - truth.rotation @ lever
    places -= places[0]
    for state, velocity, place in zip(states.values(), expected, places, strict=True):
        assert state.velocity == pytest.approx(tuple(velocity), abs=0.02)
        assert state.position == pytest.approx(tuple(place), abs=0.02)


def test_covariance_with_a_lever_arm_is_larger_and_symmetric():
    samples, _ = exact('turntable', 200.0, 7.5, radius=RADIUS, start=0.5)
    without, _ = run(samples, {**EXACT, 'frames.mounting_translation': (0.0, 0.0, 0.0)}, IMU)
    states, _ = run(samples, EXACT, IMU)
    for part, stamp_ns in product(('position_covariance', 'velocity_covariance'), states):
        covariance = np.reshape(getattr(states[stamp_ns], part), (3, 3))
        added = covariance - np.reshape(getattr(without[stamp_ns], part), (3, 3))
        assert covariance == pytest.approx(covariance.T, rel=1e-9)
        assert (np.linalg.eigvalsh(added) > -1e-12).all()


def test_a_restart_begins_at_the_origin_again():
    samples, _ = exact('turntable', 200.0, 3.5, radius=RADIUS, start=0.5)
    chain = Pipeline(Configuration(EXACT)).chain
    for sample in samples:
        state = dict(chain.push(IMU, sample))[ODOMETRY]
    again = samples[0]
    state = dict(chain.push(IMU, ImuSample(again.stamp_ns - 10**10, *fields(again)[1:])))[ODOMETRY]
    assert state.position == (0.0, 0.0, 0.0)


def test_noisy_sensor_on_a_turning_table_leaves_base_link_where_it_is():
    """The whole chain, all faults of the sensor on: the sensor goes round, base_link does not."""
    samples, truth = simulated(7.0, TURNTABLE)
    went = np.ptp([state.position for state in truth], axis=0)
    assert went[:2] == pytest.approx(2.0 * RADIUS, abs=0.01)
    states, _ = run(samples, TURNTABLE)
    errors = [np.linalg.norm(state.position) for state in states.values()]
    assert max(errors) < 0.15 * RADIUS
    for state in states.values():
        deviation = np.sqrt(state.position_covariance[::4])
        assert (np.abs(state.position) < 3.0 * deviation + 1e-3).all()


def test_the_full_covariance_is_carried_as_errors_are():
    """By the Jacobian of the pose of the body, and of its twist, by those of the sensor."""
    random = np.random.default_rng(7)
    pose, twist = (root @ root.T for root in random.normal(size=(2, 6, 6)))
    turn = Rotation.from_euler('xyz', [0.4, -0.2, 1.3])
    arm, start, rate = random.normal(size=(3, 3))

    def blocks(matrix):
        parts = matrix[:3, :3], matrix[:3, 3:], matrix[3:, 3:]
        return [tuple(part.ravel().tolist()) for part in parts]

    (p, pq, q), (v, vw, w) = blocks(pose), blocks(twist)
    state = NavigationState(
        1, (1.0, 2.0, 3.0), (0.3, 0.2, 0.1), tuple(turn.as_quat()), p, v, q, tuple(rate), w,
        pose_cross_covariance=pq, twist_cross_covariance=vw,
    )  # fmt: skip
    rot_wb = matrix_from_quaternion(state.attitude)
    found = carried(state, rot_wb, tuple(arm), tuple(start), w)

    def cross(a):
        return np.cross(np.eye(3), a)  # [a]×

    def expected(matrix, by):
        jacobian = np.eye(6)
        jacobian[:3, 3:] = by
        return blocks(jacobian @ matrix @ jacobian.T)

    of_pose = expected(pose, -cross(start - turn.apply(arm)))
    of_twist = expected(twist, turn.as_matrix() @ cross(arm))
    np.testing.assert_allclose(found.position_covariance, of_pose[0], atol=1e-12)
    np.testing.assert_allclose(found.pose_cross_covariance, of_pose[1], atol=1e-12)
    np.testing.assert_allclose(found.velocity_covariance, of_twist[0], atol=1e-12)
    np.testing.assert_allclose(found.twist_cross_covariance, of_twist[1], atol=1e-12)
