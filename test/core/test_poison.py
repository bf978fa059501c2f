"""Whatever numbers an Imu carries: a whole chain refuses it or stays finite, and goes on."""

from dataclasses import fields, is_dataclass, replace
from math import inf, isfinite, nan, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dead_reckoning.configuration import Configuration
from dead_reckoning.core.chain import FAULT
from dead_reckoning.core.errors import NotFiniteError
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.core.samples import NANOSECONDS, ImuSample
from dead_reckoning.core.stages import COMPASS, IMU, ODOMETRY, RAW

STEP_NS = 10_000_000
START_NS = 1_000 * NANOSECONDS
COVARIANCE = (1e-4, 0.0, 0.0, 0.0, 1e-4, 0.0, 0.0, 0.0, 1e-4)
FIELDS = {
    'specific_force': 3,
    'specific_force_covariance': 9,
    'angular_velocity': 3,
    'angular_velocity_covariance': 9,
    'orientation': 4,
    'orientation_covariance': 9,
}
CHAINS = [
    (attitude, method)
    for attitude in ('message', 'rest', 'estimate')
    for method in ('trapezoid', 'kalman')
] + [('rest', 'inertial_navigator')]
NUMBERS = st.one_of(
    st.floats(),
    st.sampled_from([nan, inf, -inf, 1e308, -1e160, 1e12, 1e6, -1.0, 1e-160, 5e-324]),
)


def make_chain(attitude, method):
    if method == 'inertial_navigator':
        return Pipeline(Configuration({'pipeline.estimators': [method]})).chain
    return Pipeline(
        Configuration(
            {
                'gravity.attitude': attitude,
                'integrator.method': method,
                'pipeline.estimators': ['integrator', 'pedometer'],
                'pedometer.input': topic(attitude),
                'pedometer.heading': 'any',
            }
        )
    ).chain


def topic(attitude):
    return IMU if attitude == 'message' else RAW


def sample(step):
    return ImuSample(
        START_NS + step * STEP_NS,
        'imu_link',
        (0.01 * sin(step), 0.0, GRAVITY),
        COVARIANCE,
        (0.0, 0.0, 0.01),
        COVARIANCE,
        (0.0, 0.0, 0.0, 1.0),
        COVARIANCE,
    )


def finite(value):
    if isinstance(value, float):
        return isfinite(value)
    if isinstance(value, tuple):
        return all(map(finite, value))
    if is_dataclass(value):
        return all(finite(getattr(value, field.name)) for field in fields(value))
    return True


def with_number(imu, field, index, number):
    values = list(getattr(imu, field))
    values[index % len(values)] = number
    return replace(imu, **{field: tuple(values)})


@st.composite
def poisons(draw):
    field = draw(st.sampled_from(sorted(FIELDS)))
    return field, draw(st.integers(0, 8)), draw(NUMBERS)


@pytest.mark.parametrize(('attitude', 'method'), CHAINS)
@settings(max_examples=15)
@given(poison=st.lists(poisons(), min_size=1, max_size=3), compass=st.booleans())
def test_any_number_is_refused_or_leaves_all_finite(attitude, method, poison, compass):
    chain = make_chain(attitude, method)
    values = []
    for step in range(90):
        imu = sample(step)
        if 70 <= step < 73:
            for field, index, number in poison:
                imu = with_number(imu, field, index, number)
            if compass:
                values += chain.push(COMPASS, imu)
        values += chain.push(topic(attitude), imu)
    values += chain.end()
    outputs = [(name, value) for name, value in values if name != FAULT]
    assert all(finite(value) for _, value in outputs)
    last = [value for name, value in outputs if name == ODOMETRY][-1]
    assert last.stamp_ns == sample(89).stamp_ns, 'it goes on'
    assert min(last.position_covariance[::4] + last.velocity_covariance[::4]) > 0.0


@pytest.mark.parametrize(('attitude', 'method'), CHAINS)
@pytest.mark.parametrize(
    ('field', 'index', 'number'),
    [
        ('specific_force', 1, nan),
        ('specific_force', 2, -inf),
        ('specific_force', 0, 1e9),
        ('specific_force_covariance', 4, -1.0),
        ('specific_force_covariance', 1, 1.0),
        ('specific_force_covariance', 6, -1.0),
        ('angular_velocity', 0, nan),
        ('angular_velocity', 2, 1e200),
        ('angular_velocity_covariance', 8, inf),
        ('angular_velocity_covariance', 3, nan),
        ('orientation_covariance', 0, 1e13),
    ],
)
def test_refused_sample_leaves_no_trace(attitude, method, field, index, number):
    clean, poisoned = make_chain(attitude, method), make_chain(attitude, method)
    for step in range(80):
        for chain in (clean, poisoned):
            imu = sample(step)
            if step == 70:
                if chain is clean:
                    continue
                imu = with_number(imu, field, index, number)
                outputs = chain.push(topic(attitude), imu)
                faults = [value for name, value in outputs if name == FAULT]
                assert {type(fault) for fault in faults} == {NotFiniteError}
                assert all('check the driver' in str(fault) for fault in faults)
                assert ODOMETRY not in dict(outputs)
                continue
            states = [v for n, v in chain.push(topic(attitude), imu) if n == ODOMETRY]
            if chain is clean:
                expected = states
        if step != 70:
            assert [state.position for state in states] == [s.position for s in expected]
            assert [s.position_covariance for s in states] == [
                s.position_covariance for s in expected
            ]


def test_a_stamp_of_another_age_leaves_the_covariance_one():
    """A gap of decades, then the right time again: a gap, a restart, and nothing absurd."""
    for attitude, method in CHAINS:
        chain = make_chain(attitude, method)
        for step in range(90):
            imu = sample(step)
            if step == 70:
                imu = replace(imu, stamp_ns=-(2**31) * NANOSECONDS)
            for name, value in chain.push(topic(attitude), imu):
                if name == ODOMETRY:
                    assert finite(value)
                    assert min(value.position_covariance[::4]) > 0.0
