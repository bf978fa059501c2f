"""The inertial navigator in a chain: what it gives, of a body it is mounted on, to the end."""

import dataclasses
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from random_recordings import assert_same_columns, recording
from simulated_walks import measured, navigator, walk

from dead_reckoning.configuration import Configuration
from dead_reckoning.core import smoother
from dead_reckoning.core.block_stages import navigator_block_stage
from dead_reckoning.core.blocks import ImuBlock, Stamped, StateBlock
from dead_reckoning.core.chain import FAULT, NOTICE, Chain
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import (
    GapError,
    MissingRateError,
    NotLevelledError,
    RestartError,
)
from dead_reckoning.core.mounting import Mounting
from dead_reckoning.core.navigation.settings import NavigatorSettings
from dead_reckoning.core.navigator_stage import load_kernels, navigator_stage
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import matrix_from_quaternion, quaternion_from_euler
from dead_reckoning.core.samples import UNKNOWN
from dead_reckoning.core.stages import (
    IMU,
    ODOMETRY,
    PATH,
    RAW,
    SMOOTHED,
    STATIONARY,
    STATISTIC,
    THRESHOLD,
)

TURN = quaternion_from_euler(0.4, -0.7, 2.1)
MOUNTED = np.reshape(matrix_from_quaternion(TURN), (3, 3))
LEVER_ARM = (0.05, -0.3, 0.2)
NAVIGATOR = {'pipeline.estimators': ['inertial_navigator']}


def outputs(chain, samples, name=RAW):
    """Return all that comes of samples, to the end, by name."""
    found = {}
    for sample in samples:
        for output, value in chain.push(name, sample):
            found.setdefault(output, []).append(value)
    for output, value in chain.end():
        found.setdefault(output, []).append(value)
    return found


def samples(walk):
    block = walk.block()
    return [block.sample(k) for k in range(len(block))]


def body(walk, mounting):
    """Return the states of a body on which the sensor of a walk is mounted so."""
    chain = Chain([navigator_stage(navigator(), lambda _: mounting)])
    return StateBlock.of(outputs(chain, samples(walk))[ODOMETRY])


@pytest.fixture(scope='module')
def strides():
    return measured(walk(mounted=MOUNTED), seed=1)


@pytest.fixture(scope='module')
def found(strides):
    return outputs(Chain([navigator_stage(navigator())]), samples(strides))


def test_each_imu_gets_an_odometry_with_its_stamp(strides, found):
    stamps = [state.stamp_ns for state in found[ODOMETRY]]
    assert stamps == strides.block().stamp_ns[-len(stamps) :].tolist()
    refused = [error for error in found[FAULT] if isinstance(error, NotLevelledError)]
    assert len(refused) == len(found[FAULT]) == 100  # half a second at 200 Hz
    assert len(stamps) == len(strides.time) - 100


def test_states_are_late_by_the_look_ahead_and_the_end_brings_the_last(strides):
    chain = Chain([navigator_stage(navigator())])
    lags = []
    for sample in samples(strides):
        states = [value for name, value in chain.push(RAW, sample) if name == ODOMETRY]
        lags += [sample.stamp_ns - state.stamp_ns for state in states]
    assert 0.0 < min(lags) == max(lags) <= 0.045e9
    assert len([value for name, value in chain.end() if name == ODOMETRY]) == max(lags) / 5e6
    assert chain.end() == []


def test_rest_is_said_as_it_changes_and_what_the_detector_goes_by(found):
    rests = [state.stationary for state in found[ODOMETRY]]
    changes = [rests[0], *(now for before, now in pairwise(rests) if now != before)]
    assert found[STATIONARY] == changes
    assert len(changes) > 10
    statistic, threshold = np.array(found[STATISTIC]), np.array(found[THRESHOLD])
    low = (statistic < threshold)[: len(rests) - 20]
    assert np.mean(low == rests[: len(low)]) > 0.95


def test_alignment_is_said(found):
    (notice,) = found[NOTICE]
    assert notice.startswith('aligned: gravity is 9.7')


def test_faults_of_the_stream_are_said(strides):
    taken = samples(strides)
    taken[400] = dataclasses.replace(taken[400], angular_velocity=None)
    del taken[500:650]  # 0.75 s
    later = [dataclasses.replace(s, stamp_ns=s.stamp_ns - 60 * 10**9) for s in taken]
    found = outputs(Chain([navigator_stage(navigator())]), [*taken, *later])
    kinds = [type(error) for error in found[FAULT]]
    assert kinds.count(MissingRateError) == kinds.count(GapError) == 2
    assert kinds.count(RestartError) == 1
    assert len(found[NOTICE]) == 2
    assert found[ODOMETRY][-1].stamp_ns == later[-1].stamp_ns


def test_turning_the_sensor_on_its_body_changes_nothing(strides):
    """The body walks; how the sensor is turned on it is only known to its mounting."""
    level = dataclasses.replace(
        strides, force=strides.force @ MOUNTED.T, rate=strides.rate @ MOUNTED.T
    )
    turned, straight = body(strides, Mounting(TURN)), body(level, Mounting())
    assert_same_columns(turned, straight, 1e-7)


def test_a_sensor_off_its_body_gives_the_way_of_the_body(strides):
    """p_b = p_s − R r, from the origin on, and v_b = v_s − R (ω × r)."""
    states = body(strides, Mounting(TURN, LEVER_ARM))
    at = np.searchsorted(strides.block().stamp_ns, states.stamp_ns)
    rotation = strides.rotation[at] @ MOUNTED.T
    arm = rotation @ LEVER_ARM
    truth = strides.position[at] - arm + arm[0]
    turning = strides.rate[at] @ MOUNTED.T
    velocity = strides.velocity[at] - np.einsum(
        'nij,nj->ni', rotation, np.cross(turning, LEVER_ARM)
    )
    sensor = body(strides, Mounting(TURN))
    moved = np.abs(truth - strides.position[at]).max()
    error = np.abs(states.position - truth).max()
    assert moved > 0.2
    assert error < np.abs(sensor.position - strides.position[at]).max() + 0.02
    assert np.abs(states.velocity - velocity).max() < 0.1
    assert states.position[0] == pytest.approx(0.0, abs=1e-3)
    np.testing.assert_allclose(
        states.position_covariance[-1], sensor.position_covariance[-1], rtol=0.01, atol=1e-4
    )
    for cross, first, second in (
        ('pose_cross_covariance', 'position_covariance', 'attitude_covariance'),
        ('twist_cross_covariance', 'velocity_covariance', 'angular_velocity_covariance'),
    ):
        a, c, b = (getattr(states, n).reshape(-1, 3, 3) for n in (first, cross, second))
        both = np.block([[a, c], [c.transpose(0, 2, 1), b]])
        assert np.linalg.eigvalsh(both).min() > -1e-12


@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('mounting', [Mounting(), Mounting(TURN, LEVER_ARM)], ids=['on', 'off'])
def test_blocks_give_what_samples_give(seed, mounting):
    taken = recording(seed, 12.0, gyro=True, odd=0.003)
    stream = outputs(Chain([navigator_stage(navigator(), lambda _: mounting)]), taken)
    cuts = [0, *sorted(np.random.default_rng(seed).integers(1, len(taken), 7)), len(taken)]
    blocks = [ImuBlock.of(taken[a:b]) for a, b in pairwise(cuts) if b > a]
    batch = outputs(Chain([navigator_block_stage(navigator(), lambda _: mounting)]), blocks)
    expected = StateBlock.of(stream[ODOMETRY])
    assert len(expected) > 500
    assert_same_columns(StateBlock.join(batch[ODOMETRY]), expected, 1e-9)
    assert [said.value for said in batch[STATIONARY]] == stream[STATIONARY]
    stamps = [said.stamp_ns for said in batch[STATIONARY]]
    assert set(stamps) <= {state.stamp_ns for state in stream[ODOMETRY]}
    assert [repr(said.value) for said in batch[FAULT]] == [repr(e) for e in stream[FAULT]]
    assert all(isinstance(said, Stamped) for said in batch[NOTICE])
    assert {STATISTIC, THRESHOLD}.isdisjoint(batch)


def test_a_chain_of_nothing_but_rest_ends():
    block = walk().block().part(0, 60)
    chain = Pipeline(Configuration(NAVIGATOR), blocks=True).chain
    assert {name for name, _ in chain.push(RAW, block)} == {FAULT}
    assert chain.end() == []


def test_input_is_the_one_that_is_chosen(strides):
    values = {**NAVIGATOR, 'navigator.input': IMU}
    pipeline = Pipeline(Configuration(values))
    assert IMU in pipeline.inputs
    assert RAW not in pipeline.inputs
    assert len(outputs(pipeline.chain, samples(strides), IMU)[ODOMETRY]) > 1000


def test_a_pedometer_beside_it_walks_along_its_own_heading():
    """Where the pedometer counts on imu/data, gravity removal makes that, as without it."""
    values = {
        'pipeline.estimators': ['inertial_navigator', 'pedometer'],
        'pedometer.input': IMU,
        'pedometer.heading': 'orientation',
    }
    pipeline = Pipeline(Configuration(values))
    assert pipeline.inputs[0] == RAW
    assert pipeline.gravity is not None
    found = outputs(pipeline.chain, samples(walk()))
    assert {IMU, ODOMETRY, 'pedometer/steps'} <= found.keys()
    assert UNKNOWN not in [s.angular_velocity_covariance for s in found[ODOMETRY]]


def test_full_scale_is_that_of_an_axis_of_the_sensor(strides):
    """However it is mounted: what clips is counted once, and what only looks like it is not."""
    most = 20.0
    clipped = replace(strides, force=np.clip(strides.force, -most, most))
    counts = []
    for mounting in (Mounting(), Mounting(quaternion_from_euler(0.6, -0.8, 0.7))):
        found = navigator(force_range=most)
        outputs(Chain([navigator_stage(found, lambda _, m=mounting: m)]), samples(clipped))
        counts.append(found.counts['saturated'])
    reached = (np.abs(clipped.force).max(axis=1) >= 0.999 * most).sum()
    assert counts == [reached, reached]
    assert reached > 50


def test_a_sensor_in_g_is_told_from_one_that_moves(strides):
    """As long as it does not align, not only when a rest ends."""
    in_g = replace(strides, force=strides.force / 9.80665)
    found = outputs(Chain([navigator_stage(navigator())]), samples(in_g)[:350])
    said = [str(error) for error in found[FAULT]]
    assert all('keep the device still' in text for text in said[:99])
    assert sum('most likely the unit is g instead of m/s²' in text for text in said[100:]) > 240
    assert not any('keep the device still' in text for text in said[100:])


@pytest.mark.parametrize('smoothing', [False, True])
def test_kernels_are_loaded_before_the_first_stride_needs_them(smoothing, monkeypatch):
    called = []
    monkeypatch.setattr(smoother, 'smooth', lambda *arguments: called.append(arguments))
    load_kernels(NavigatorSettings(smoothing=smoothing), CommonSettings())
    assert bool(called) is smoothing


def test_a_restart_loses_no_state(strides):
    """What the detector had not judged yet comes out before the new start."""
    again = strides.block(strides.block().stamp_ns[0] - 3600 * 10**9)
    chain = Chain([navigator_stage(navigator(), lambda _: Mounting(TURN, LEVER_ARM))])
    values = [*samples(strides)[:900], *[again.sample(k) for k in range(900)]]
    found = outputs(chain, values)
    stamps = [state.stamp_ns for state in found[ODOMETRY]]
    assert stamps == [v.stamp_ns for v in (*values[100:900], *values[1000:])]
    assert sum(isinstance(error, RestartError) for error in found[FAULT]) == 1
    first, second = np.array([s.position for s in found[ODOMETRY]]).reshape(2, 800, 3)
    np.testing.assert_allclose(second, first, atol=1e-9)


@pytest.mark.parametrize('again', ['reset', 'restart', 'gap', 'level'])
@pytest.mark.parametrize('blocks', [False, True])
def test_each_odometry_comes_smoothed_once_whatever_happens(strides, again, blocks):
    """And of a mounted sensor, the smoothed states of the body begin at the origin, too."""
    mounting = Mounting(TURN, LEVER_ARM)
    found = navigator(smoothing=True)
    make = navigator_block_stage if blocks else navigator_stage
    chain = Chain([make(found, lambda _: Mounting() if blocks else mounting)])
    block = strides.block()
    shift_ns = {'restart': -3600, 'gap': 30}.get(again, 9) * 1_000_000_000
    later = replace(block, stamp_ns=block.stamp_ns + shift_ns)
    given = {ODOMETRY: [], SMOOTHED: [], PATH: []}

    def take(outputs):
        for name, value in outputs:
            if name in given:
                given[name] += (
                    [value]
                    if not blocks or name == PATH
                    else [value.sample(k) for k in range(len(value))]
                )

    for part, end in ((block, 700), (later, len(block))):
        for begin in range(0, end, 50):
            if blocks:
                take(chain.push(RAW, part.part(begin, min(begin + 50, end))))
            else:
                for k in range(begin, min(begin + 50, end)):
                    take(chain.push(RAW, part.sample(k)))
        if again == 'reset' and part is block:
            found.reset()
        if again == 'level' and part is block:
            found.level()
    take(chain.end())
    assert len(given[ODOMETRY]) > 1200
    stamps = [[state.stamp_ns for state in given[name]] for name in (ODOMETRY, SMOOTHED)]
    assert stamps[0] == stamps[1]
    if again in ('reset', 'restart'):
        begun = [k for k in range(1, len(stamps[0])) if abs(stamps[0][k] - stamps[0][k - 1]) > 2e9]
        assert len(begun) == 1
        for k in (0, begun[0]):
            np.testing.assert_allclose(given[SMOOTHED][k].position, (0.0, 0.0, 0.0), atol=0.01)
    assert len(given[PATH]) >= 4
    if not blocks:  # with each stride, to its end
        end = given[PATH][-1].poses[-1][1]
        assert np.linalg.norm(np.subtract(end, given[SMOOTHED][-1].position)) < 0.1
