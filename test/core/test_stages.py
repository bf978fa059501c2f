"""What each estimator takes and gives in a chain."""

from dataclasses import astuple

import numpy as np
import pytest

from dead_reckoning.core.chain import FAULT, NOTICE, Chain
from dead_reckoning.core.common import CommonSettings, FrameSettings
from dead_reckoning.core.errors import (
    GapError,
    GravityError,
    MissingAttitudeError,
    MissingRateError,
    NotFiniteError,
    NotLevelledError,
    RepeatedStampError,
    RestartError,
    UnpairedError,
    ZeroStampError,
)
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.gravity_settings import GravitySettings
from dead_reckoning.core.integrator import Integrator, IntegratorSettings
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.samples import (
    IDENTITY_QUATERNION,
    ZERO,
    ImuSample,
    LinearAcceleration,
)
from dead_reckoning.core.stages import (
    ACCELERATION,
    COMPASS,
    IMU,
    LEVELLED,
    ODOMETRY,
    RAW,
    STATIONARY,
    gravity_input,
    gravity_inputs,
    gravity_stage,
    integrator_stage,
    pairing_stage,
)

STEP_NS = 10_000_000


def gravity_chain(attitude='rest'):
    settings = GravitySettings(attitude=attitude)
    return Chain([gravity_stage(GravityRemoval(settings, CommonSettings(), FrameSettings()))])


def integrator_chain():
    integrator = Integrator(IntegratorSettings(), CommonSettings())
    return Chain([pairing_stage(), integrator_stage(integrator)])


def imu(step, force=(0.0, 0.0, GRAVITY), orientation=None):
    return ImuSample((step + 1) * STEP_NS, 'imu_link', force, orientation=orientation)


def acceleration(step, x=0.0):
    return LinearAcceleration((step + 1) * STEP_NS, 'odom', (x, 0.0, 0.0))


def oriented(step):
    return imu(step, orientation=IDENTITY_QUATERNION)


def topics(outputs):
    """Return what comes out on topics, without what only the next stage takes."""
    return [(name, value) for name, value in outputs if name != LEVELLED]


def names(outputs):
    return [name for name, _ in topics(outputs)]


@pytest.mark.parametrize(('attitude', 'topic'), [('rest', RAW), ('message', IMU)])
def test_gravity_removal_takes_the_topic_that_fits_its_attitude(attitude, topic):
    assert gravity_input(attitude) == topic
    other = {RAW: IMU, IMU: RAW}[topic]
    chain = gravity_chain(attitude)
    assert chain.push(topic, oriented(0)) != []
    assert chain.push(other, oriented(1)) == []


@pytest.mark.parametrize('attitude', ['rest', 'estimate'])
def test_compass_is_taken_where_the_attitude_does_not_come_with_the_imu(attitude):
    assert gravity_inputs(attitude) == (RAW, COMPASS)
    chain = gravity_chain(attitude)
    yaw = quaternion_from_euler(0.0, 0.0, 1.0)
    compass = ImuSample(STEP_NS, 'compass_link', ZERO, orientation=yaw)
    assert chain.push(COMPASS, compass) == []
    for step in range(51):
        sample = ImuSample(
            (step + 1) * STEP_NS, 'imu_link', (0.0, 0.0, GRAVITY), angular_velocity=ZERO
        )
        outputs = dict(chain.push(RAW, sample))
    assert outputs[IMU].orientation == pytest.approx(yaw)
    ((name, error),) = chain.push(COMPASS, compass)
    assert name == FAULT
    assert isinstance(error, RepeatedStampError)


def test_message_with_its_attitude_needs_no_compass():
    assert gravity_inputs('message') == (IMU,)
    compass = ImuSample(STEP_NS, 'compass_link', ZERO, orientation=IDENTITY_QUATERNION)
    assert gravity_chain('message').push(COMPASS, compass) == []


def test_imu_without_a_gyro_is_a_fault_where_one_is_needed():
    ((name, error),) = gravity_chain('estimate').push(RAW, imu(0))
    assert name == FAULT
    assert isinstance(error, MissingRateError)


def test_imu_that_came_without_an_attitude_goes_out_with_one():
    chain = gravity_chain()
    for step in range(50):
        ((name, error),) = chain.push(RAW, imu(step))
        assert name == FAULT
        assert isinstance(error, NotLevelledError)
    outputs = chain.push(RAW, imu(50))
    assert names(outputs) == [IMU, ACCELERATION, NOTICE]
    levelled, linear, said = (value for _, value in topics(outputs))
    assert levelled.orientation == IDENTITY_QUATERNION
    assert levelled.stamp_ns == linear.stamp_ns == 51 * STEP_NS
    assert said.startswith('levelled: gravity is 9.8066')
    assert names(chain.push(RAW, imu(51))) == [IMU, ACCELERATION]


def test_imu_that_came_with_its_attitude_is_not_repeated():
    assert names(gravity_chain('message').push(IMU, oriented(0))) == [ACCELERATION]


def test_finding_comes_out_once_beside_the_samples():
    chain = gravity_chain('message')
    outputs = []
    for step in range(60):
        outputs += chain.push(
            IMU, imu(step, force=(0.0, 0.0, 1.0), orientation=IDENTITY_QUATERNION)
        )
    assert names(outputs).count(ACCELERATION) == 60
    faults = [value for name, value in outputs if name == FAULT]
    assert [type(fault) for fault in faults] == [GravityError]


@pytest.mark.parametrize('imu_first', [True, False])
def test_integrator_waits_for_both_whichever_comes_first(imu_first):
    chain = integrator_chain()
    for step in range(5):
        both = [(IMU, oriented(step)), (ACCELERATION, acceleration(step))]
        first, second = both if imu_first else both[::-1]
        assert chain.push(*first) == []
        outputs = chain.push(*second)
        assert names(outputs) == [ODOMETRY, STATIONARY][: 1 + (step == 0)]
        assert dict(outputs)[ODOMETRY].stamp_ns == (step + 1) * STEP_NS


def test_stationary_is_said_at_the_start_and_on_change():
    chain = integrator_chain()
    said = []
    for step in range(80):
        chain.push(IMU, oriented(step))
        outputs = chain.push(ACCELERATION, acceleration(step, 1.0 if 40 <= step < 45 else 0.0))
        said += [(step, value) for name, value in outputs if name == STATIONARY]
    assert said == [(0, False), (24, True), (40, False), (69, True)]


def test_sample_without_partner_is_said_once_and_holds_up_nothing():
    chain = integrator_chain()
    chain.push(ACCELERATION, acceleration(0))
    ((name, error),) = chain.push(IMU, oriented(1))
    assert name == FAULT
    assert isinstance(error, UnpairedError)
    assert names(chain.push(ACCELERATION, acceleration(1))) == [ODOMETRY, STATIONARY]
    assert 'imu/linear_acceleration and imu/data' in str(error)
    chain.push(IMU, oriented(2))
    assert names(chain.push(ACCELERATION, acceleration(2))) == [ODOMETRY]


def test_refused_acceleration_is_a_fault_and_the_next_one_passes():
    chain = integrator_chain()
    for step, x, expected in [(0, 0.0, ODOMETRY), (1, float('nan'), FAULT), (2, 0.0, ODOMETRY)]:
        chain.push(IMU, oriented(step))
        name, value = topics(chain.push(ACCELERATION, acceleration(step, x)))[0]
        assert name == expected
        if name == FAULT:
            assert isinstance(value, NotFiniteError)


@pytest.mark.parametrize(
    ('bad', 'expected'),
    [
        (imu(1), MissingAttitudeError),
        (imu(1, orientation=(0.0, 0.0, float('nan'), 1.0)), NotFiniteError),
        (imu(1, (0.0, float('inf'), 0.0), IDENTITY_QUATERNION), NotFiniteError),
        (oriented(0), RepeatedStampError),
        (oriented(-1), ZeroStampError),
    ],
)
def test_imu_that_no_acceleration_will_follow_is_one_fault(bad, expected):
    """Gravity removal refuses it too, so nothing comes that could wait for it."""
    chain = integrator_chain()
    faults = []
    for step, sample in enumerate((oriented(0), bad, oriented(2), oriented(3))):
        outputs = chain.push(IMU, sample)
        if sample is not bad:
            outputs += chain.push(ACCELERATION, acceleration(step))
            assert ODOMETRY in names(outputs)
        faults += [type(value) for name, value in outputs if name == FAULT]
    assert faults == [expected]


def test_streams_whose_stamps_never_meet_are_said_at_once():
    chain = integrator_chain()
    faults = []
    for step in range(10):
        chain.push(IMU, oriented(step))
        late = LinearAcceleration((step + 1) * STEP_NS + 5, 'odom', ZERO)
        faults += [value for name, value in chain.push(ACCELERATION, late) if name == FAULT]
    assert len(faults) == 10
    assert {type(fault) for fault in faults} == {UnpairedError}


def test_one_bad_imu_is_one_fault_in_a_whole_chain():
    removal = GravityRemoval(
        GravitySettings(attitude='message'), CommonSettings(), FrameSettings()
    )
    integrator = Integrator(IntegratorSettings(), CommonSettings())
    chain = Chain([gravity_stage(removal), integrator_stage(integrator)])
    nan = imu(1, force=(float('nan'), 0.0, 0.0), orientation=IDENTITY_QUATERNION)
    samples = [oriented(0), nan, imu(2), oriented(0), oriented(-1), oriented(3), oriented(4)]
    outputs = [output for sample in samples for output in chain.push(IMU, sample)]
    assert [type(value) for name, value in outputs if name == FAULT] == [
        NotFiniteError,
        MissingAttitudeError,
        RepeatedStampError,
        ZeroStampError,
    ]
    assert names(outputs).count(ODOMETRY) == 3


def test_gap_under_an_estimated_attitude_is_said_with_the_remedy():
    chain = gravity_chain('estimate')
    faults = []
    for step in (*range(60), 200, 201):
        sample = ImuSample(
            (step + 1) * STEP_NS, 'imu_link', (0.0, 0.0, GRAVITY), angular_velocity=ZERO
        )
        outputs = chain.push(RAW, sample)
        faults += [(step, value) for name, value in outputs if name == FAULT]
    ((step, gap),) = [(step, value) for step, value in faults if isinstance(value, GapError)]
    assert step == 200
    assert 'no samples for 1.41 s' in str(gap)
    assert 'gravity.max_gap' in str(gap)


def test_restart_of_gravity_removal_is_said_once_and_so_is_each_levelling():
    chain = gravity_chain()
    said = []
    for round_trip in (200, 0):
        for step in range(60):
            outputs = chain.push(RAW, imu(round_trip + step))
            said += [value for name, value in outputs if name in (FAULT, NOTICE)]
    said = [value for value in said if not isinstance(value, NotLevelledError)]
    first, restart, second = said
    assert isinstance(restart, RestartError)
    assert first == second
    assert first.startswith('levelled: ')


def test_restart_and_gap_of_the_integrator_are_said_once():
    chain = integrator_chain()
    faults = []
    for step in (500, 501, 600, 601, 1, 2):
        chain.push(IMU, oriented(step))
        outputs = chain.push(ACCELERATION, acceleration(step))
        assert ODOMETRY in names(outputs)
        faults += [(step, type(value)) for name, value in outputs if name == FAULT]
    assert faults == [(600, GapError), (1, RestartError)]


def test_over_topics_the_same_comes_out_as_in_one_chain():
    removal = GravityRemoval(GravitySettings(), CommonSettings(), FrameSettings())
    whole = Chain(
        [
            gravity_stage(removal),
            integrator_stage(Integrator(IntegratorSettings(), CommonSettings())),
        ]
    )
    first, second = gravity_chain(), integrator_chain()
    random = np.random.default_rng(1)
    for step, shake in enumerate(random.normal(0.0, 0.2, (200, 3))):
        sample = imu(step, tuple(np.add(shake, [0.3, -0.2, GRAVITY]).tolist()))
        wanted = [value for name, value in whole.push(RAW, sample) if name == ODOMETRY]
        came = [
            value
            for topic, message in topics(first.push(RAW, sample))
            if topic in (IMU, ACCELERATION)
            for name, value in second.push(topic, message)
            if name == ODOMETRY
        ]
        assert [astuple(state) for state in came] == [astuple(state) for state in wanted]
    deviation = np.sqrt(came[0].position_covariance[::4])
    alone = 0.5 * IntegratorSettings().offset_deviation * 1.49**2
    assert deviation[2] > 1.5 * alone, 'the levelling of a rest that trembles shows'


def test_both_in_one_chain_need_nothing_between_them():
    removal = GravityRemoval(GravitySettings(), CommonSettings(), FrameSettings())
    integrator = Integrator(IntegratorSettings(), CommonSettings())
    chain = Chain([gravity_stage(removal), integrator_stage(integrator)])
    for step in range(50):
        chain.push(RAW, imu(step))
    assert names(chain.push(RAW, imu(50))) == [
        IMU,
        ACCELERATION,
        NOTICE,
        ODOMETRY,
        STATIONARY,
    ]
    assert names(chain.push(RAW, imu(51))) == [IMU, ACCELERATION, ODOMETRY]
