"""What holds for every method that finds steps, and every model of their lengths."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dead_reckoning.core import step_detectors, step_lengths
from dead_reckoning.core.chain import FAULT, Chain
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import GapError, RestartError, SampleError
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import matrix_from_quaternion, quaternion_from_euler
from dead_reckoning.core.samples import ImuSample, NavigationState
from dead_reckoning.core.stages import (
    COMPASS,
    DISTANCE,
    ODOMETRY,
    RAW,
    STEP_ODOMETRY,
    STEPS,
    TOTALS,
    pedometer_stage,
)
from dead_reckoning.core.step_odometry import StepOdometry

START_NS = 1_700_000_000_000_000_000
RATE = 100.0
STEPS_WALKED = 40

METHODS = step_detectors.names()
pytestmark = pytest.mark.parametrize('method', METHODS)


def pedometer(method, **settings):
    own = step_detectors.detector_class(method).Settings()
    return Pedometer(PedometerSettings(method=method, **settings), own)


def walk(rate=RATE, cadence=1.8, amplitude=1.0):
    """Return specific forces, shape (n, 3) [m/s²], of a rest, a walk and a rest."""
    time = np.arange(0.0, STEPS_WALKED / cadence, 1.0 / rate)
    turn = 2.0 * np.pi * cadence * time
    moving = np.column_stack(
        [
            1.2 * np.sin(turn),
            0.5 * np.sin(turn / 2.0),
            2.5 * (-np.sin(turn) + 0.4 * np.sin(2.0 * turn)),
        ]
    )
    quiet = np.zeros((round(3.0 * rate), 3))
    return amplitude * np.concatenate([quiet, moving, quiet]) + [0.0, 0.0, GRAVITY]


def counted(method, forces, rate=RATE, start_ns=START_NS):
    """Return a pedometer that took forces, and the states it gave."""
    counter, states = pedometer(method), []
    for number, force in enumerate(np.asarray(forces).tolist()):
        stamp_ns = start_ns + round(number * 1e9 / rate)
        states += counter.update(ImuSample(stamp_ns, 'imu_link', tuple(force)))
    return counter, states


@given(st.tuples(*[st.floats(-3.1, 3.1)] * 3))
def test_rotation_of_the_device_changes_nothing(method, euler):
    rotation = np.reshape(matrix_from_quaternion(quaternion_from_euler(*euler)), (3, 3))
    expected, _ = counted(method, walk())
    turned, _ = counted(method, walk() @ rotation.T)
    assert turned.steps == expected.steps == STEPS_WALKED
    assert turned.distance == pytest.approx(expected.distance, rel=1e-6)


@pytest.mark.parametrize('scale', [0.4, 0.7, 1.4, 2.0])
def test_amplitude_does_not_matter(method, scale):
    counter, _ = counted(method, walk(amplitude=scale))
    assert counter.steps == STEPS_WALKED


@given(st.integers(1, 10**15))
def test_later_walk_has_later_stamps_and_nothing_else(method, shift_ns):
    _, states = counted(method, walk())
    _, later = counted(method, walk(), start_ns=START_NS + shift_ns)
    moved = [dataclasses.replace(s, stamp_ns=s.stamp_ns + shift_ns) for s in states]
    assert list(map(dataclasses.astuple, later)) == list(map(dataclasses.astuple, moved))


@pytest.mark.parametrize('rate', [12.5, 25.0, 30.0, 50.0, 128.0, 200.0, 405.0, 500.0])
def test_rate_does_not_matter(method, rate):
    counter, _ = counted(method, walk(rate), rate)
    expected, _ = counted(method, walk())
    assert counter.steps == expected.steps == STEPS_WALKED
    if rate >= 50.0:
        assert counter.distance == pytest.approx(expected.distance, rel=0.03)


@pytest.mark.parametrize('noise', [0.0, 0.02])
def test_silence_gives_no_steps(method, noise):
    random = np.random.default_rng(11)
    forces = [0.0, 0.0, GRAVITY] + noise * random.standard_normal((30_000, 3))
    assert counted(method, forces)[1] == []


# Fuzz -----------------------------------------------------------------------------------------

ANY = st.floats() | st.floats(-30.0, 30.0)
VECTORS = st.tuples(ANY, ANY, ANY)
MATRICES = st.tuples(*[ANY] * 9)
TURNS = st.none() | st.tuples(*[ANY] * 4) | st.just((0.0, 0.0, 0.6, 0.8))
STAMPS = st.integers(-(2**62), 2**62) | st.integers(-(2 * 10**9), 2 * 10**9)
SERVICES = ('start', 'stop', 'reset')
EVENTS = st.one_of(
    st.tuples(st.just(RAW), STAMPS, VECTORS, MATRICES, TURNS, MATRICES),
    st.tuples(st.just(COMPASS), STAMPS, VECTORS, MATRICES, TURNS, MATRICES),
    st.tuples(st.just(ODOMETRY), STAMPS, st.tuples(*[ANY] * 4), MATRICES),
    st.tuples(st.sampled_from(SERVICES)),
    # A walk between, so that there is something to lose.
    st.tuples(st.just('walk'), st.floats(0.0, 1e3), st.floats(10.0, 300.0)),
)


def flow(events):
    """Yield names, and samples under them, with stamps that go on from the last or leap."""
    now_ns = START_NS
    for name, *values in events:
        if name == 'walk':
            amplitude, rate = values
            for force in walk(rate, amplitude=amplitude)[: int(15.0 * rate)].tolist():
                now_ns += int(1e9 / rate)
                yield RAW, ImuSample(now_ns, '', tuple(force), orientation=(0.0, 0.0, 0.6, 0.8))
        elif name in SERVICES:
            yield name, None
        else:
            stamp, first, *more = values
            stamp_ns = stamp if abs(stamp) > 2 * 10**9 else now_ns + stamp
            if name == ODOMETRY:
                zero = (0.0, 0.0, 0.0)
                yield (
                    name,
                    NavigationState(stamp_ns, zero, zero, first, attitude_covariance=more[0]),
                )
            else:
                covariance, turn, of_turn = more
                yield name, ImuSample(
                    stamp_ns, '', first, covariance,
                    orientation=turn, orientation_covariance=of_turn,
                )  # fmt: skip


@given(
    st.lists(EVENTS, max_size=12),
    st.sampled_from(step_lengths.names()),
    st.sampled_from(['any', 'orientation', 'navigator']),
)
def test_whatever_comes_raises_nothing_and_totals_only_grow(method, events, model, heading):
    counter = pedometer(method, length_model=model, heading=heading)
    odometry = StepOdometry(counter.settings, CommonSettings())
    chain = Chain([pedometer_stage(counter, odometry)])
    grown = {STEPS: 0, DISTANCE: 0.0}
    for name, sample in flow(events):
        if name in SERVICES:
            sample = getattr(counter, name)() or ()
            name = TOTALS
            if counter.steps == 0:
                grown = {STEPS: 0, DISTANCE: 0.0}
        for given_name, value in chain.push(name, sample):
            if given_name == FAULT:
                assert isinstance(value, SampleError | GapError | RestartError)
            elif given_name in grown:
                assert grown[given_name] <= value < math.inf
                grown[given_name] = value
            elif given_name == STEP_ODOMETRY:
                assert np.isfinite([*value.position, *value.velocity]).all()
                covariance = np.reshape(value.position_covariance, (3, 3))[:2, :2]
                assert np.linalg.eigvalsh(covariance).min() >= -1e-9 * np.trace(covariance)
    assert (counter.steps, counter.distance) == tuple(grown.values())


@given(st.integers(0, 2**32))
def test_shaking_of_any_kind_keeps_totals_finite_and_growing(method, seed):
    random = np.random.default_rng(seed)
    forces = random.normal(0.0, 10.0 ** random.uniform(-3, 4), (500, 3))
    _, states = counted(method, forces, random.uniform(5.0, 300.0))
    totals = [(state.steps, state.distance) for state in states]
    assert totals == sorted(totals)
    assert all(math.isfinite(state.cadence + state.distance) for state in states)
