"""What a pedometer takes and gives in a chain, alone and beside the integrator."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from random_recordings import assert_same, in_blocks, streamed

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.chain import FAULT, Chain
from dead_reckoning.core.common import CommonSettings
from dead_reckoning.core.errors import (
    GapError,
    NotFiniteError,
    RepeatedStampError,
    RestartError,
    SettingsError,
)
from dead_reckoning.core.pedometer import Pedometer, PedometerSettings, Totals
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.rotation import quaternion_from_euler, yaw_from_quaternion
from dead_reckoning.core.samples import ImuSample
from dead_reckoning.core.stages import (
    ACCELERATION,
    CADENCE,
    COMPASS,
    DISTANCE,
    IMU,
    ODOMETRY,
    RAW,
    STEP,
    STEP_LENGTH,
    STEP_ODOMETRY,
    STEPS,
    TOTALS,
    StepOutputs,
    pedometer_inputs,
    pedometer_stage,
)
from dead_reckoning.core.step_odometry import StepOdometry

START_NS = 1_700_000_000_000_000_000
RATE = 100


class Walker:
    """A chain of a pedometer, and what came out of it."""

    def __init__(self, **settings):
        self.settings = PedometerSettings(**settings)
        self.pedometer = Pedometer(self.settings, self.settings.method_part())
        self.odometry = StepOdometry(self.settings, CommonSettings())
        self.chain = Chain([pedometer_stage(self.pedometer, self.odometry)])
        self.outputs = []

    def walk(self, imus):
        for imu in imus:
            self.outputs += self.chain.push(self.settings.input, imu)
        return self

    def values(self, name):
        return [value for given, value in self.outputs if given == name]


def walk(steps=12, orientation=None, start_ns=START_NS, cadence=1.8):
    rest = np.full(3 * RATE, GRAVITY)
    turn = 2.0 * np.pi * cadence * np.arange(round(RATE * steps / cadence)) / RATE
    forces = np.concatenate([rest, GRAVITY - 2.5 * np.sin(turn), rest])
    return [
        ImuSample(
            start_ns + number * 1_000_000_000 // RATE,
            'imu_link',
            (0.0, 0.0, float(force)),
            orientation=orientation,
        )
        for number, force in enumerate(forces)
    ]


def east(stamp_ns, yaw=0.0):
    orientation = quaternion_from_euler(0.0, 0.0, yaw)
    return ImuSample(stamp_ns, 'compass', (0.0,) * 3, (-1.0, *(0.0,) * 8), orientation=orientation)


def test_first_sample_says_that_nothing_was_walked_yet():
    walker = Walker()
    assert walker.chain.push(RAW, walk()[0]) == [
        (STEPS, 0),
        (DISTANCE, 0.0),
        (STEP_LENGTH, 0.0),
        (CADENCE, 0.0),
    ]
    assert walker.chain.push(RAW, walk()[1]) == []


def test_totals_are_said_step_by_step_and_only_on_change():
    walker = Walker().walk(walk())
    assert walker.values(STEPS) == list(range(13))
    distances = walker.values(DISTANCE)
    assert distances == sorted(set(distances))
    for name in (STEP_LENGTH, CADENCE):
        assert all(a != b for a, b in pairwise(walker.values(name)))
    assert walker.values(CADENCE)[-1] == 0.0
    assert walker.values(FAULT) == walker.values(STEP_ODOMETRY) == []


def test_types_are_those_of_the_messages():
    walker = Walker().walk(walk())
    assert {type(value) for value in walker.values(STEPS)} == {int}
    for name in (DISTANCE, STEP_LENGTH, CADENCE):
        assert {type(value) for value in walker.values(name)} == {float}


def test_what_is_said_was_kept_before():
    walker, kept = Walker(), []
    says = StepOutputs(walker.pedometer, walker.odometry)

    def keep(totals):
        kept.append((totals, len(walker.outputs)))
        return lambda: True

    says.keep = keep
    walker.chain = Chain([pedometer_stage(walker.pedometer, walker.odometry, says=says)])
    walker.walk(walk())
    assert [totals.steps for totals, _ in kept][-1] == 12
    said = 0
    for number, (name, value) in enumerate(walker.outputs):
        if name == STEPS and value > 0:
            said += 1
            assert any(t.steps >= value for t, outputs in kept if outputs <= number)
    assert said == 12
    walker.pedometer.reset()
    walker.chain.push(TOTALS, ())
    assert kept[-1][0] == Totals()


def test_what_is_kept_late_is_said_late_and_in_order():
    expected = [each for each in Walker().walk(walk()).outputs if each[0] != STEP]
    walker, written = Walker(), -1
    says = StepOutputs(walker.pedometer, walker.odometry)
    says.keep = lambda totals: lambda: totals.steps <= written
    walker.chain = Chain([pedometer_stage(walker.pedometer, walker.odometry, says=says)])
    walker.walk(walk())
    assert not [name for name, _ in walker.outputs if name in (STEPS, DISTANCE)]
    for written in (-1, 4, 12):
        walker.outputs += says.due()
        assert walker.values(STEPS)[-1:] == ([written] if written >= 0 else [])
    assert [each for each in walker.outputs if each[0] != STEP] == expected
    assert says.due() == []


def test_walk_goes_on_from_totals_as_from_its_own():
    whole = Walker(averaging=4.0).walk(walk(6)).walk(walk(6, start_ns=START_NS + 10**11))
    begun = Walker(averaging=4.0).walk(walk(6))
    resumed = Walker(averaging=4.0)
    resumed.pedometer.resume(begun.pedometer.totals)
    assert dict(resumed.chain.push(TOTALS, ())) == {
        STEPS: 6,
        DISTANCE: begun.pedometer.distance,
        STEP_LENGTH: begun.pedometer.step_length,
        CADENCE: 0.0,
    }
    resumed.walk(walk(6, start_ns=START_NS + 10**11))
    assert resumed.pedometer.totals == whole.pedometer.totals
    assert resumed.values(STEPS) == [7, 8, 9, 10, 11, 12]


def test_steps_lead_along_the_orientation():
    walker = Walker(input=IMU).walk(walk(orientation=quaternion_from_euler(0.0, 0.1, 0.7)))
    states = walker.values(STEP_ODOMETRY)
    assert len(states) == 12
    x, y, z = states[-1].position
    assert math.hypot(x, y) == pytest.approx(walker.pedometer.distance)
    assert math.atan2(y, x) == pytest.approx(0.7)
    assert z == 0.0
    assert [s.stamp_ns for s in states] == sorted({s.stamp_ns for s in states})


def test_steps_that_were_held_back_for_long_are_walked_too():
    """A rhythm that is hardly seen, so that the first steps come together half a minute late."""
    random, time = np.random.default_rng(1), 0.01 * np.arange(6000)
    shaken = 3.0 * np.convolve(random.normal(size=6024), np.full(25, 0.2), 'valid')
    forces = GRAVITY + (time > 3.0) * (shaken - 2.0 * np.sin(2.0 * np.pi * 1.8 * time))
    walker, late = Walker(heading='orientation'), []
    for k, force in enumerate(forces.tolist()):
        stamp_ns = START_NS + 10_000_000 * k
        walker.walk(
            [ImuSample(stamp_ns, 'i', (0.0, 0.0, force), orientation=(0.0, 0.0, 0.0, 1.0))]
        )
        late += [stamp_ns - step.stamp_ns for step in walker.values(STEP)[len(late) :]]
    assert max(late) > 12e9
    assert len(walker.values(STEP_ODOMETRY)) == len(late)
    assert walker.values(STEP_ODOMETRY)[-1].position[0] == pytest.approx(walker.pedometer.distance)


def test_steps_lead_along_the_compass():
    walker = Walker()
    for number, imu in enumerate(walk()):
        if number % 5 == 0:
            assert not list(walker.chain.push(COMPASS, east(imu.stamp_ns, -2.0)))
        walker.walk([imu])
    states = walker.values(STEP_ODOMETRY)
    assert len(states) == 12
    assert {round(yaw_from_quaternion(s.attitude), 6) for s in states} == {-2.0}


@pytest.mark.parametrize(
    ('settings', 'inputs'),
    [
        ({}, (RAW, COMPASS)),
        ({'input': IMU}, (IMU, COMPASS)),
        ({'input': IMU, 'heading': 'orientation'}, (IMU,)),
        ({'heading': 'navigator'}, (RAW, ODOMETRY)),
        ({'heading': 'none'}, (RAW,)),
    ],
)
def test_inputs_are_those_it_needs(settings, inputs):
    assert pedometer_inputs(PedometerSettings(**settings)) == inputs


def test_other_topic_is_not_counted():
    walker = Walker(input=IMU)
    for imu in walk():
        assert walker.chain.push(RAW, imu) == []


def test_refused_sample_is_a_fault_and_the_walk_goes_on():
    imus = walk(orientation=quaternion_from_euler(0.0, 0.0, 0.0))
    nan = math.nan
    bad = ImuSample(imus[500].stamp_ns + 1, 'imu_link', (nan, 0.0, 0.0))
    twisted = ImuSample(
        imus[600].stamp_ns + 40_000_000, 'imu_link', (0.0, 0.0, 9.8), orientation=(nan, 0, 0, 1.0)
    )
    stream = [*imus[:501], bad, *imus[501:601], twisted, imus[600], *imus[601:]]
    walker = Walker(input=IMU).walk(stream)
    kinds = [type(fault) for fault in walker.values(FAULT)]
    assert kinds == [NotFiniteError, NotFiniteError, RepeatedStampError, RepeatedStampError]
    assert walker.values(STEPS)[-1] == 12


def test_gap_and_restart_are_said_once():
    imus = walk()
    walker = Walker().walk([*imus[:400], *imus[560:], *imus])
    assert [type(fault) for fault in walker.values(FAULT)] == [GapError, RestartError]
    assert 'no step is counted over' in str(walker.values(FAULT)[0])


def test_steps_that_a_stop_brings_are_walked_too():
    walker = Walker(heading='orientation')
    walker.walk(walk(orientation=(0.0, 0.0, 0.0, 1.0))[: 3 * RATE + round(9.3 * RATE / 1.8)])
    counted = len(walker.values(STEP_ODOMETRY))
    walker.outputs += walker.chain.push(TOTALS, walker.pedometer.stop())
    assert counted < len(walker.values(STEP_ODOMETRY)) == walker.values(STEPS)[-1]
    assert walker.values(STEP_ODOMETRY)[-1].position[0] == pytest.approx(walker.pedometer.distance)
    assert walker.values(CADENCE)[-1] == 0.0


def test_changes_by_service_come_out_when_asked_for():
    walker = Walker().walk(walk())
    assert walker.chain.push(TOTALS, ()) == []
    walker.pedometer.reset()
    assert walker.chain.push(TOTALS, ()) == [(STEPS, 0), (DISTANCE, 0.0), (STEP_LENGTH, 0.0)]


# In a pipeline --------------------------------------------------------------------------------


def pipeline(*estimators, **values):
    return Pipeline(
        Configuration(
            {
                'pipeline.estimators': list(estimators),
                **{key.replace('__', '.'): value for key, value in values.items()},
            }
        )
    )


@pytest.mark.parametrize(
    ('estimators', 'values', 'inputs'),
    [
        (['integrator'], {}, {RAW}),
        (['integrator'], {'gravity__attitude': 'message'}, {IMU}),
        (['pedometer'], {}, {RAW, COMPASS}),
        (['pedometer'], {'pedometer__input': IMU}, {RAW, COMPASS}),
        (
            ['pedometer'],
            {'pedometer__input': IMU, 'gravity__attitude': 'message'},
            {IMU, COMPASS},
        ),
        (['integrator', 'pedometer'], {}, {RAW, COMPASS}),
        (['integrator', 'pedometer'], {'pedometer__heading': 'none'}, {RAW}),
        (['integrator', 'pedometer'], {'pedometer__input': IMU}, {RAW, COMPASS}),
        (['integrator', 'pedometer'], {'gravity__attitude': 'message'}, {IMU, RAW, COMPASS}),
    ],
)
def test_pipeline_needs_from_outside_what_it_does_not_make(estimators, values, inputs):
    needed = pipeline(*estimators, **values).inputs
    assert set(needed) - {COMPASS} == inputs - {COMPASS}
    assert len(set(needed)) == len(needed)
    assert COMPASS in needed or COMPASS not in inputs


def test_pipeline_holds_what_was_asked_for():
    both = pipeline('integrator', 'pedometer')
    assert None not in (both.gravity, both.integrator, both.pedometer, both.step_odometry)
    one = pipeline('pedometer')
    assert one.pedometer is not None
    assert one.gravity is one.integrator is None
    other = pipeline('integrator')
    assert other.pedometer is other.step_odometry is None


def test_integrator_and_pedometer_share_a_chain():
    chain = pipeline('integrator', 'pedometer', pedometer__input=IMU).chain
    outputs = [output for imu in walk() for output in chain.push(RAW, imu)]
    names = [name for name, _ in outputs]
    assert [value for name, value in outputs if name == STEPS][-1] == 12
    assert names.count(ODOMETRY) == names.count(IMU) == names.count(ACCELERATION) > 800
    assert names.count(STEP_ODOMETRY) == 12, 'along the attitude that gravity removal found'


def test_pedometer_in_a_pipeline_gives_the_same_numbers_as_alone():
    chain = pipeline('integrator', 'pedometer').chain
    wanted = (STEPS, DISTANCE, STEP_LENGTH, CADENCE)
    together = [output for imu in walk() for output in chain.push(RAW, imu) if output[0] in wanted]
    alone = [output for output in Walker().walk(walk()).outputs if output[0] in wanted]
    assert together == alone


# Along the inertial navigator ------------------------------------------------------------------

NAVIGATED = {
    'pipeline.estimators': ['inertial_navigator', 'pedometer'],
    'pedometer.heading': 'navigator',
}


def turning_walk(rate_of_turn=0.4):
    """Return samples of a walk on a circle, after a rest."""
    samples = walk(30)
    still = 3 * RATE
    return [
        replace(
            imu,
            angular_velocity=(
                0.0,
                0.0,
                rate_of_turn if still <= k < len(samples) - still else 0.0,
            ),
            specific_force=(0.0, 0.0, imu.specific_force[2]),
        )
        for k, imu in enumerate(samples)
    ]


def test_steps_lead_along_the_navigator_beside():
    found = streamed(NAVIGATED, RAW, turning_walk())
    assert len(found[STEP_ODOMETRY]) == 30
    stamps = np.array([state.stamp_ns for _, state in found[ODOMETRY]])
    yaws = np.unwrap([yaw_from_quaternion(state.attitude) for _, state in found[ODOMETRY]])
    place = np.zeros(2)
    for (_, step), (_, walked) in zip(found[STEP], found[STEP_ODOMETRY], strict=True):
        yaw = np.interp(step.stamp_ns - 0.5e9 * step.duration, stamps, yaws)
        place += step.step_length * np.array([np.cos(yaw), np.sin(yaw)])
        assert walked.position[:2] == pytest.approx(place, abs=0.01)
    assert yaws[-1] > 2.0 * np.pi


@pytest.mark.parametrize(
    'more', [{}, {'pedometer.input': IMU, 'gravity.attitude': 'estimate'}], ids=['raw', 'levelled']
)
@pytest.mark.parametrize('cuts', [[], [500, 501, 900]])
def test_replay_goes_along_the_navigator_too(more, cuts):
    samples = turning_walk()
    again = [replace(imu, stamp_ns=imu.stamp_ns - 10**12) for imu in samples]  # goes back
    values = {**NAVIGATED, **more}
    stream = streamed(values, RAW, samples + again)
    blocks = in_blocks(values, RAW, samples + again, cuts)
    assert len(stream[STEP_ODOMETRY]) == 60
    for name in (STEPS, DISTANCE, ODOMETRY, STEP_ODOMETRY, FAULT):
        assert_same({name: blocks[name]}, {name: stream[name]})


def test_heading_of_a_navigator_needs_one():
    settings = {**NAVIGATED, 'pipeline.estimators': ['integrator', 'pedometer']}
    with pytest.raises(SettingsError, match='add inertial_navigator there'):
        Pipeline(Configuration(settings))
