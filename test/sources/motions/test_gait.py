"""A foot stands still, swings, and lands as feet do."""

import numpy as np
import pytest

from dead_reckoning.core.rest import GRAVITY
from dead_reckoning.sources.motions.gait import LANDING, Gait, GaitSettings

KINDS = [
    {},
    {'turn': 0.4, 'rise': 0.3},
    {'rise': -0.3},
    {'stride_time': 0.7, 'stride_length': 2.4, 'stance': 0.2, 'clearance': 0.3, 'shock': 60.0},
    {'stride_length': 0.0, 'stance': 0.9},
]


def gait(**settings):
    return Gait(GaitSettings(**settings))


@pytest.fixture(params=KINDS, ids=str)
def settings(request):
    return GaitSettings(**{'strides': 6, **request.param})


def stances(settings):
    """Yield the times within each stance, the rests before and after too."""
    swing = (1.0 - settings.stance) * settings.stride_time
    yield np.linspace(0.0, settings.start, 50)
    for stride in range(settings.strides):
        begin = settings.start + stride * settings.stride_time + swing
        yield np.linspace(begin, begin + settings.stance * settings.stride_time, 50)


def test_foot_neither_moves_nor_turns_in_stance(settings):
    body = Gait(settings)
    for time in stances(settings):
        inside = body.at(time[1:-1])
        for part in (inside.velocity, inside.acceleration, inside.angular_velocity):
            assert not part.any()
        assert not np.ptp(inside.position, axis=0).any()
        assert not np.ptp(inside.euler, axis=0).any()
        assert not inside.euler[:, :2].any(), 'it stands flat'
        ends = body.at(time[[0, -1]])
        np.testing.assert_allclose(ends.position, inside.position[:2], atol=1e-12)


def test_stances_are_a_stride_apart(settings):
    body = Gait(settings)
    feet = np.array([body.at(time[25:26]).position[0] for time in stances(settings)])
    apart = np.diff(feet, axis=0)
    np.testing.assert_allclose(np.hypot(*apart.T[:2]), settings.stride_length, atol=1e-12)
    np.testing.assert_allclose(apart[:, 2], settings.rise, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(apart, axis=1), body.steps.lengths, atol=1e-12)


def test_it_turns_with_each_stride():
    settings = GaitSettings(strides=4, turn=0.4)
    yaw = [Gait(settings).at(time[25:26]).euler[0, 2] for time in stances(settings)]
    np.testing.assert_allclose(yaw, 0.4 * np.arange(5))


def test_circle_closes():
    strides = 12
    body = gait(strides=strides, turn=2.0 * np.pi / strides)
    np.testing.assert_allclose(body.at(np.array([1e3])).position, 0.0, atol=1e-12)


def test_strides_are_counted_when_the_heel_lands(settings):
    body = Gait(settings)
    swing = (1.0 - settings.stance) * settings.stride_time
    assert len(body.steps.times) == settings.strides
    np.testing.assert_allclose(np.diff(body.steps.times), settings.stride_time)
    assert body.steps.times[0] == pytest.approx(settings.start + LANDING * swing)


def test_foot_swings_as_high_as_told_and_never_below_the_ground():
    body = gait(strides=1, clearance=0.2)
    height = body.at(np.linspace(0.0, body.duration, 5001)).position[:, 2]
    assert height.max() == pytest.approx(0.2, rel=0.05)
    assert height.min() > -1e-3


@pytest.mark.parametrize('rise', [0.3, -0.3])
def test_on_stairs_it_clears_the_edge(rise):
    body = gait(strides=1, rise=rise)
    truth = body.at(np.linspace(0.0, body.duration, 5001))
    assert truth.position[:, 2].max() > max(rise, 0.0) + 0.05
    assert truth.position[-1, 2] == pytest.approx(rise)


def test_toe_points_down_then_up_before_it_lands():
    body = gait(strides=1, pitch=1.0)
    truth = body.at(np.linspace(0.0, body.duration, 5001))
    pitch = truth.euler[:, 1]
    assert pitch.max() == pytest.approx(1.0, rel=0.05)
    assert -0.45 < pitch.min() < -0.3
    assert pitch.argmax() < pitch.argmin()
    landed = body.at(body.steps.times)
    assert landed.euler[0, 1] < -0.3, 'on its heel'


def test_shock_comes_at_the_landing_and_can_be_left_out():
    jolt = (
        gait(strides=1).at(time := np.linspace(3.0, 4.0, 10_001)).acceleration
        - gait(strides=1, shock=0.0).at(time).acceleration
    )
    size = np.linalg.norm(jolt, axis=1)
    assert time[size.argmax()] == pytest.approx(gait().steps.times[0], abs=1e-4)
    assert size.max() == pytest.approx(20.0, rel=1e-3)
    assert jolt[size.argmax()] == pytest.approx([-12.0, 0.0, 16.0], rel=1e-2, abs=1e-9)
    assert 0.02 < np.count_nonzero(size) * 1e-4 < 0.025


@pytest.mark.parametrize(
    ('kind', 'peak', 'toe_off', 'swing'),
    [
        # gaitmap, 1.4 m in 1.1 s: rates 8.9 and −6.3
        ({}, (35.0, 60.0), (7.0, 10.0), (-8.0, -5.0)),
        # OpenShoe at 5 km/h: 51 m/s², 6.8 and −6.3 rad/s
        ({'stride_time': 1.12, 'stride_length': 1.56}, (40.0, 60.0), (6.0, 10.0), (-8.0, -5.0)),
        # OpenShoe at 7 km/h: 71 m/s², 8.5 and −7.6 rad/s
        (
            {'stride_time': 0.95, 'stride_length': 1.85, 'stance': 0.28},
            (50.0, 80.0), (7.0, 11.0), (-8.5, -5.5),
        ),
        # running at 12 km/h
        (
            {
                'stride_time': 0.7, 'stride_length': 2.4, 'stance': 0.2, 'clearance': 0.3,
                'pitch': 1.4, 'shock': 60.0,
            },
            (80.0, 200.0), (10.0, 25.0), (-20.0, -7.0),
        ),
    ],
)  # fmt: skip
def test_force_and_rate_are_those_of_feet(kind, peak, toe_off, swing):
    """Largest specific force at 250 Hz, and the rates of pitch [rad/s]."""
    body = gait(strides=5, **kind)
    truth = body.at(np.arange(0.0, body.duration, 0.001))
    lifted = truth.acceleration + np.array([0.0, 0.0, GRAVITY])
    force = np.linalg.norm(lifted, axis=1)
    averaged = force[: len(force) // 4 * 4].reshape(-1, 4).mean(axis=1)
    assert peak[0] < averaged.max() < peak[1]
    rate = truth.angular_velocity[:, 1]
    assert toe_off[0] < rate.max() < toe_off[1]
    assert swing[0] < rate.min() < swing[1]
    assert np.abs(truth.angular_velocity[:, [0, 2]]).max() > 1.0, 'it rolls and turns too'


def test_many_strides_cost_no_time_to_set_up():
    body = gait(strides=1_000_000)
    last = body.at(np.array([body.duration]))
    assert last.position[0, 0] == pytest.approx(1.4e6)
