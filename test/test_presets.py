"""The presets do what they are for: the chain on their own simulated sensor."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conversation import Conversation, readings
from scipy.spatial.transform import Rotation
from simulated_walks import Walk, measured, walk

from benchmarks.accuracy.trunk_walks import MMA7260QT, walked
from dead_reckoning.configuration import Configuration
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.compass import Compass, CompassSettings
from dead_reckoning.core.front_end import Conversions
from dead_reckoning.core.integration.settings import IntegratorSettings
from dead_reckoning.core.pipeline import Pipeline, PipelineSettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import yaw_from_quaternion
from dead_reckoning.core.samples import ZERO, ImuSample
from dead_reckoning.core.stages import COMPASS, IMU, ODOMETRY, RAW, STEP_ODOMETRY, STEPS
from dead_reckoning.sources.driver import front_end, serial_receiver, simulated_sensor
from dead_reckoning.sources.driver_settings import DriverSettings
from dead_reckoning.sources.serial.protocols import Measurement, board_class, decoder_class

CONFIG = Path(__file__).parents[1] / 'config'
START_NS = 1_700_000_000_000_000_000


def run(preset, seconds, compass_every=0):
    """Return states and true positions; a compass speaks with every so many-th message."""
    configuration = Configuration.load(CONFIG / f'{preset}.yaml')
    rate = configuration[DriverSettings].sample_rate
    source = simulated_sensor(configuration, START_NS)
    chain = Pipeline(configuration).chain
    settings = configuration[CompassSettings]
    compass, random = Compass(settings, 'compass_link'), np.random.default_rng(1)
    states = []
    for k, sample in enumerate(front_end(configuration).add(source.read(round(seconds * rate)))):
        if compass_every and k % compass_every == 0:
            yaw = yaw_from_quaternion(source.truth(sample.stamp_ns).attitude)
            heading = math.pi / 2.0 - yaw + random.normal(0.0, settings.noise)
            assert chain.push(COMPASS, compass.sample(sample.stamp_ns, heading)) == []
        states += [value for name, value in chain.push(RAW, sample) if name == ODOMETRY]
    truth = np.array([source.truth(state.stamp_ns).position for state in states])
    return states, truth


def off(states, truth):
    """Return the error in the plane, shape (n,) [m]."""
    positions = np.array([state.position for state in states])
    return np.linalg.norm((positions - truth)[:, :2], axis=1)


def test_mbed_follows_the_heading_of_its_compass_round_an_eight():
    """18 m in curves within the 15 s of the page: 1 % off on the way, 0.5 % at its end."""
    states, truth = run('mbed', 15.0, compass_every=5)
    way = np.linalg.norm(np.diff(truth, axis=0), axis=1).sum()
    assert way == pytest.approx(18.3, abs=0.2)
    error = off(states, truth)
    assert error.max() < 0.02 * way
    assert error[-1] < 0.005 * way
    assert states[-1].stationary
    assert 1400 < len(states) < 1500


def test_mbed_ends_when_the_page_does_and_logs():
    settings = Configuration.load(CONFIG / 'mbed.yaml')[PipelineSettings]
    assert settings.duration == 15.0
    assert settings.log_csv.endswith('.csv')


def test_an3397_comes_back_round_its_square():
    """1.2 m round a square with an 8-bit sensor and the documents' wide window: within 2 cm."""
    states, truth = run('an3397', 9.5)
    assert np.abs(truth).max() == pytest.approx(0.3)
    assert off(states, truth).max() < 0.02
    assert states[-1].stationary


# 1 m within 2 s after a rest of 2 s, x = t/2 − sin(πt)/2π, seen 100 times a second.
TIME = np.arange(0.0, 5.0, 0.01)
SPEEDING = np.where(
    (TIME > 2.0) & (TIME < 4.0), 0.5 * math.pi * np.sin(math.pi * (TIME - 2.0)), 0.0
)


def ends_of_the_wire(preset):
    """Return the configuration of a preset, and the board and the decoder of its protocol."""
    configuration = Configuration.load(CONFIG / f'{preset}.yaml')
    settings = configuration[decoder_class(preset).Settings]
    return configuration, board_class(preset)(settings), decoder_class(preset)(settings)


def test_um7_goes_where_its_own_attitude_points():
    """Nose 10° up and 30° east of north, through the bytes of the board: 1 m within 3 cm."""
    configuration, board, decoder = ends_of_the_wire('um7')
    ahead = np.array([math.sin(math.radians(30.0)), math.cos(math.radians(30.0)), 0.0])
    rotation = Rotation.from_euler('ZY', [math.radians(60.0), -math.radians(10.0)])
    force_w = SPEEDING[:, None] * ahead + [0.0, 0.0, GRAVITY]
    noise = np.random.default_rng(3).normal(0.0, 0.004, force_w.shape)
    forces = rotation.inv().apply(force_w) / GRAVITY + noise
    x, y, z, w = rotation.as_quat().tolist()
    chain, states = Pipeline(configuration).chain, []
    for at, force in zip(TIME.tolist(), forces.tolist(), strict=True):
        (reading,) = decoder.feed(
            board.measure(Measurement({'g': tuple(force)}, at, ZERO, (x, y, z, w), ZERO))
        )
        sample = ImuSample(
            START_NS + round(reading.clock * 1e9),
            'imu_link',
            tuple(GRAVITY * value for value in reading.values),
            angular_velocity=reading.rate,
            orientation=reading.orientation,
        )
        states += [value for name, value in chain.push(IMU, sample) if name == ODOMETRY]
    assert states[-1].stationary
    assert np.linalg.norm(states[-1].position - ahead) < 0.03


def test_imu6dof4_is_levelled_by_its_gyroscopes():
    """A roll of 20° before the way, which counts of 1°/s show: 1 m within 5 cm."""
    configuration, board, decoder = ends_of_the_wire('imu6dof4')
    model, random = configuration[DriverSettings].model(), np.random.default_rng(6)
    rolling = (TIME >= 1.0) & (TIME < 1.5)
    rolls = np.cumsum(np.where(rolling, 0.01 * math.radians(40.0), 0.0))
    force_w = SPEEDING[:, None] * [1.0, 0.0, 0.0] + [0.0, 0.0, GRAVITY]
    output = model.output(Rotation.from_euler('x', rolls[:, None]).inv().apply(force_w))
    counts = model.counts(output + random.normal(0.0, model.noise, output.shape))
    chain, states = Pipeline(configuration).chain, []
    turns = random.normal(0.0, 0.01, output.shape) + 0.02
    turns[rolling, 0] += math.radians(40.0)
    for row, turn in zip(counts.tolist(), turns.tolist(), strict=True):
        sent = board.measure(Measurement({'counts': row}, 0.0, turn, (0, 0, 0, 1), ZERO))
        for reading in decoder.feed(sent):
            force = model.force(np.array([reading.values]), np.array(model.zero_g))[0]
            sample = ImuSample(
                START_NS + round(reading.clock * 1e7),
                'imu_link',
                tuple(force.tolist()),
                angular_velocity=reading.rate,
            )
            states += [value for name, value in chain.push(RAW, sample) if name == ODOMETRY]
    assert states[-1].stationary
    assert np.linalg.norm(states[-1].position - np.array([1.0, 0.0, 0.0])) < 0.05


def test_adxl345_follows_a_slide_in_counts_of_the_sensor():
    """At ±16 g with a count of noise: 1 m within 5 cm, and then it rests."""
    configuration = Configuration.load(CONFIG / 'adxl345.yaml')
    forces = np.column_stack([SPEEDING / GRAVITY, 0.0 * TIME, np.ones_like(TIME)])
    counts = np.rint(256.0 * forces + np.random.default_rng(3).normal(0.0, 1.0, forces.shape))
    conversions = Conversions(START_NS + np.rint(TIME * 1e9).astype(np.int64), counts)
    chain, states = Pipeline(configuration).chain, []
    for sample in front_end(configuration).add(conversions):
        states += [value for name, value in chain.push(RAW, sample) if name == ODOMETRY]
    assert states[-1].stationary
    assert states[-1].position[0] == pytest.approx(1.0, abs=0.05)
    assert states[-1].position[1] == pytest.approx(0.0, abs=1e-9)


def test_an3397_window_is_three_counts():
    configuration = Configuration.load(CONFIG / 'an3397.yaml')
    count = configuration[DriverSettings].model().force_per_count
    window = configuration[IntegratorSettings].window_maximum
    assert window == pytest.approx(3.0 * count[0], abs=1e-3)
    assert configuration[IntegratorSettings].window_minimum == -window


@pytest.mark.parametrize('preset', ['zstar', 'zstar3', 'witilt3'])
def test_a_board_that_lies_level_reads_one_g(preset):
    """Through the bytes of its protocol, to within a count.

    The window is three of them, or three sigma of the noise where 16 bits are finer than that.
    """
    configuration = Configuration.load(CONFIG / f'{preset}.yaml')
    serial_receiver(configuration)  # takes these settings together
    kind, model = decoder_class(preset), configuration[DriverSettings].model()
    assert configuration[DriverSettings].adc_bits == kind.BITS
    settings = configuration[kind.Settings]
    force = np.array([[0.0, 0.0, GRAVITY]])
    talk = Conversation(kind(settings), board_class(preset)(settings))
    talk.run(3.0, tuple(model.counts(model.output(force))[0].tolist()))
    (values,) = set(readings(talk.events))
    count = model.force_per_count[0]
    assert np.abs(model.force(np.array([values]), np.array(model.zero_g)) - force).max() < count
    noise = model.noise / model.sensitivity[0] * GRAVITY
    window = 3.0 * (noise if preset == 'zstar3' else count)
    assert configuration[IntegratorSettings].window_maximum == pytest.approx(window, abs=1e-3)


def test_the_board_of_an3397_says_where_it_is():
    """At the origin while it rests, then forward, by the preset alone."""
    configuration = Configuration.load(CONFIG / 'an3397_board.yaml')
    receiver = serial_receiver(configuration)
    board = board_class('an3397')(configuration[decoder_class('an3397').Settings])

    def positions(updates, x):
        """Return those that come of so many updates, each of 64 conversions with x counts."""
        taken = Measurement({'counts': (x, 128.0, 190.0)}, 0.0, ZERO, (0.0, 0.0, 0.0, 1.0), ZERO)
        sent = b''.join(board.measure(taken) for _ in range(64 * updates))
        return [state.position for state in receiver.take(sent, START_NS).positions]

    resting = positions(50, 128.0)
    assert len(resting) == 50 - 16
    assert set(resting) == {ZERO}
    x, y, _ = positions(10, 148.0)[-1]
    assert x == pytest.approx(0.5 * 20.0 * 0.158 * 0.1**2, abs=0.0025)
    assert y == 0.0


def navigated(preset, block):
    """Return the states of a preset's chain for a block of samples, to the end."""
    chain = Pipeline(Configuration.load(CONFIG / f'{preset}.yaml'), blocks=True).chain
    outputs = [*chain.push(RAW, block), *chain.end()]
    return StateBlock.join([value for name, value in outputs if name == ODOMETRY])


@pytest.mark.parametrize(
    'gait', [{}, {'stride_time': 0.75, 'stride_length': 2.4, 'stance': 0.25}], ids=['walk', 'run']
)
def test_foot_mounted_follows_a_foot(gait):
    """20 strides on the level: within 2 % of the way, walking and running."""
    path = measured(walk(mounted=np.eye(3), **gait), seed=4)
    states = navigated('foot_mounted', path.block())
    way = np.linalg.norm(np.diff(path.position, axis=0), axis=1).sum()
    end = path.position[-1] - path.position[0]
    assert np.linalg.norm(states.position[-1] - end) < 0.02 * way
    assert states.stationary[-1]
    assert 0.2 < states.stationary.mean() < 0.9


def test_pedestrian_counts_on_a_topic_and_walks_where_its_orientation_points():
    """60 steps to the north-east: counted exactly, and led there."""
    chain = Pipeline(Configuration.load(CONFIG / 'pedestrian.yaml')).chain
    half = math.pi / 8.0
    northeast = (0.0, 0.0, math.sin(half), math.cos(half))
    outputs = []
    for imu in walked(MMA7260QT, 1, cadence=1.8, step_length=0.7, steps=60):
        outputs += chain.push(IMU, replace(imu, orientation=northeast))
    outputs += chain.end()
    assert [value for name, value in outputs if name == STEPS][-1] == 60
    x, y, _ = [value for name, value in outputs if name == STEP_ODOMETRY][-1].position
    assert x == pytest.approx(y) != 0.0
    assert math.hypot(x, y) == pytest.approx(42.0, rel=0.1)


def test_inertial_knows_the_attitude_of_what_a_hand_waves():
    """30 s of turns by half a radian and of 2 m/s²: right to a third of a degree."""
    time = np.arange(0.0, 32.0, 0.005)
    waving = (time > 2.0)[:, None] * (1.0 - np.exp(2.0 - np.maximum(time, 2.0)))[:, None]
    turns = 0.5 * waving * np.sin(time[:, None] * [2.1, 2.9, 1.7])
    moved = 0.06 * waving * np.sin(time[:, None] * [5.0, 4.3, 5.9])
    rotation = Rotation.from_euler('xyz', turns)
    rate = np.vstack([(rotation[:-1].inv() * rotation[1:]).as_rotvec() / 0.005, np.zeros(3)])
    rate[1:-1] = 0.5 * (rate[1:-1] + rate[:-2])
    force_w = np.gradient(np.gradient(moved, 0.005, axis=0), 0.005, axis=0) + np.array(
        [0.0, 0.0, 9.81]
    )
    random = np.random.default_rng(5)
    force = rotation.inv().apply(force_w) + random.normal(0.0, 0.02, force_w.shape)
    rate += random.normal(0.0, 0.002, rate.shape) + np.array([0.005, -0.004, 0.003])
    hand = Walk(time, force, rate, moved, moved, rotation.as_matrix())
    states = navigated('inertial', hand.block())
    at = np.searchsorted(hand.block().stamp_ns, states.stamp_ns)
    up = Rotation.from_quat(states.attitude).inv().apply([0.0, 0.0, 1.0])
    true_up = rotation[at].inv().apply([0.0, 0.0, 1.0])
    wrong = np.degrees(np.arccos(np.clip((up * true_up).sum(axis=1), -1.0, 1.0)))
    moving = time[at] > 5.0
    assert np.degrees(np.abs(turns).max()) > 25.0
    assert np.sqrt(np.mean(wrong[moving] ** 2)) < 0.33
    assert np.linalg.norm(states.position, axis=1).max() < 1.0
