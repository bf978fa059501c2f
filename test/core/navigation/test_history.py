"""What is measured late is taken at its stamp: as if it had come at once."""

from contextlib import suppress

import numpy as np
import pytest
from simulated_walks import START_NS, measured, navigator, walk

from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.errors import AidingError, NotLevelledError
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.navigation.aids import LONGEST
from dead_reckoning.core.navigation.history import STRETCH, Stretch
from dead_reckoning.core.smoother import Smoother

WALK = measured(walk(strides=4, turn=0.4, mounted=np.eye(3)), 1)
BLOCK = WALK.block()
TAKEN = layout.COUNTS + layout.AIDED + 2 * layout.BY_TWIST


def velocity(index, deviation=0.05):
    """Return values of a `VECTOR`: the true velocity at a sample, and one that is off."""
    half = np.eye(3)[np.triu_indices(3)] * deviation**2
    off = 0.03 * np.sin(index + np.arange(3))
    return (
        layout.WORLD_VELOCITY, layout.BY_TWIST, 0.1, *(WALK.velocity[index] + off), *half,
        0.0, 0.0, 0.0,
    )  # fmt: skip


def walked(late, every=20, first=None, **settings):
    """Return navigator and states of a walk whose velocity is told ``late`` samples later.

    It keeps what it takes from the start on.
    """
    found = navigator(**settings)
    found.keep()
    states = []
    for index in range(len(BLOCK)):
        with suppress(NotLevelledError):
            states += found.update(BLOCK.sample(index))
        told = index - late
        if told > 150 and told % every == 0:
            found.follow(int(BLOCK.stamp_ns[told]), layout.VECTOR, velocity(told))
    return found, StateBlock.of(states)


@pytest.mark.parametrize('late', [1, 7, 40, 99])
@pytest.mark.parametrize('look_ahead', [0.0, 0.045])
def test_how_late_it_comes_does_not_matter(late, look_ahead):
    prompt, _ = walked(0, look_ahead=look_ahead)
    found, _ = walked(late, look_ahead=look_ahead)
    for told in range(len(BLOCK) - late, len(BLOCK)):
        if told % 20 == 0:
            found.follow(int(BLOCK.stamp_ns[told]), layout.VECTOR, velocity(told))
    for each in (prompt, found):
        each.flush()
        each._state[layout.LOGGED] = 0.0
    assert prompt._state[TAKEN] > 80.0
    np.testing.assert_array_equal(found._state, prompt._state)


def test_what_comes_in_another_order_is_taken_in_that_of_its_stamps():
    ends = []
    for order in ((300, 310, 320), (320, 300, 310)):
        found = navigator()
        found.keep()
        for index in range(360):
            with suppress(NotLevelledError):
                found.update(BLOCK.sample(index))
        for index in order:
            found.follow(int(BLOCK.stamp_ns[index]), layout.VECTOR, velocity(index))
        ends.append(found._state)
    np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize('late', [0, 5, 40])
def test_what_comes_of_one_sample_is_taken_in_the_order_of_its_stamps(late):
    """Whichever transport is faster: some of them wait, are just filtered, or long since."""
    half, unmeasured = (0.01, 0.0, 0.0, 0.01, 0.0, 0.01), (1e6, 0.0, 0.0, 1e6, 0.0, 1e6)
    at, speed = tuple(WALK.position[300]), tuple(WALK.velocity[300])
    place = (*at, *half, 0.0, 0.0, 0.0, 1.0, *unmeasured, 0.0, 0.0, 0.0)
    told = [
        (4, layout.VECTOR, velocity(300)),
        (3, layout.VECTOR, (layout.WORLD_VELOCITY, layout.BY_ODOM, 0.1, *speed, *half, *3 * (0,))),
        (3, layout.VECTOR, (layout.WORLD_POSITION, layout.BY_POSE, 0.1, *at, *half, *3 * (0,))),
        (2, layout.YAW, (0.1, 0.01, 0.1, 0.0, 5.0, layout.BY_POSE_YAW)),
        (1, layout.PLACE, place),
        (0, layout.VECTOR, velocity(300)),
    ]
    ends, random = [], np.random.default_rng(0)
    for order in [range(len(told)), *(random.permutation(len(told)) for _ in range(12))]:
        found = navigator(aiding_gate=1e9, axis_gate=1e9)
        found.keep()
        for index in range(360):
            with suppress(NotLevelledError):
                found.update(BLOCK.sample(index))
            if index == 300 + late:
                for age_ms, kind, values in (told[k] for k in order):
                    found.follow(int(BLOCK.stamp_ns[300]) - age_ms * 1_000_000, kind, values)
        assert found.counts['placed'] == found.counts['aiding_odom'] == 1
        assert found.counts['aiding_twist'] == 2
        found._state[layout.LOGGED] = 0.0
        ends.append(found._state)
    for end in ends[1:]:
        np.testing.assert_array_equal(end, ends[0])


def test_only_what_may_still_be_needed_is_kept():
    found, _ = walked(0)
    rate = 200.0
    assert found.history is not None
    assert sum(s.count for s in found.history.stretches) < 0.5 * rate + 2 * STRETCH


def test_what_is_too_old_is_refused_and_changes_nothing():
    found, _ = walked(0)
    before = found._state.copy()
    stamp_ns = int(BLOCK.stamp_ns[-1]) - 600_000_000
    with pytest.raises(AidingError, match=r'0\.600 s behind the Imu.* navigator\.aiding_delay'):
        found.follow(stamp_ns, layout.VECTOR, velocity(300))
    np.testing.assert_array_equal(found._state, before)
    ahead_ns = int(BLOCK.stamp_ns[-1]) + 1_500_000_000
    with pytest.raises(AidingError, match=r'1\.500 s ahead of the Imu: check the clocks'):
        found.follow(ahead_ns, layout.VECTOR, velocity(300))
    np.testing.assert_array_equal(found._state, before)
    found, _ = walked(0, aiding_delay=2.0)
    found.follow(ahead_ns, layout.VECTOR, velocity(300))


def test_before_the_alignment_it_is_refused():
    found = navigator()
    with pytest.raises(NotLevelledError, match=r'still for 0\.5 s'):
        found.follow(START_NS, layout.VECTOR, velocity(0))


def test_the_first_ones_are_taken_though_nothing_was_kept_yet():
    found = navigator()
    for index in range(400):
        with suppress(NotLevelledError):
            found.update(BLOCK.sample(index))
    for index in (360, 370):
        found.follow(int(BLOCK.stamp_ns[index]), layout.VECTOR, velocity(index))
    for index in range(400, 420):
        found.update(BLOCK.sample(index))
    assert found._state[TAKEN : TAKEN + 2].sum() == 2.0


@pytest.mark.parametrize('index', [396, 405, 415])
def test_what_is_kept_from_somewhere_on_is_gone_through_as_it_was(index):
    ends = []
    for since in (0, 400):
        found = navigator()
        for k in range(420):
            if k == since:
                found.keep()
            with suppress(NotLevelledError):
                found.update(BLOCK.sample(k))
        found.follow(int(BLOCK.stamp_ns[index]), layout.VECTOR, velocity(index))
        for k in range(420, 440):
            found.update(BLOCK.sample(k))
        found._state[layout.LOGGED] = 0.0
        ends.append(found._state)
    if index < 400:  # one of the samples that waited then
        np.testing.assert_allclose(ends[1][:17], ends[0][:17], atol=5e-3)
    else:
        np.testing.assert_array_equal(*ends)


def test_however_many_there_are_of_a_sample_it_can_be_smoothed():
    """So many with one variance are one with that part of it."""
    ends, count = [], 2000
    for times in (1, count):
        found = navigator(aiding_gate=1e9)
        record = Smoother(found)
        for index in range(400):
            with suppress(NotLevelledError):
                found.update(BLOCK.sample(index))
        told = velocity(370, 0.05 * np.sqrt(times))
        for _ in range(times):
            found.follow(int(BLOCK.stamp_ns[370]), layout.VECTOR, told)
        ends.append(StateBlock.join(list(record.blocks())[::-1]))
    np.testing.assert_allclose(ends[1].position, ends[0].position, atol=1e-7)
    np.testing.assert_allclose(ends[1].velocity, ends[0].velocity, atol=1e-6)


def test_however_many_come_late_between_two_samples_it_is_filtered_once_more(monkeypatch):
    filtered = []
    run = Stretch.run
    monkeypatch.setattr(Stretch, 'run', lambda self, *a: filtered.append(self) or run(self, *a))
    found = navigator()
    found.keep()
    for index in range(399):
        with suppress(NotLevelledError):
            found.update(BLOCK.sample(index))
    for part in range(50):
        stamp_ns = int(BLOCK.stamp_ns[330]) + part * 1_000_000
        found.follow(stamp_ns, layout.VECTOR, velocity(330 + part // 5))
    found.update(BLOCK.sample(399))
    assert found._state[TAKEN : TAKEN + 2].sum() == 50.0
    assert len(filtered) == len({id(stretch) for stretch in filtered})


@pytest.mark.parametrize('again', ['reset', 'restart'])
def test_what_came_late_before_a_new_start_is_not_taken_after_it(again):
    ends = []
    for late in (False, True):
        found = navigator()
        found.keep()
        for index in range(400):
            with suppress(NotLevelledError):
                found.update(BLOCK.sample(index))
        if late:
            found.follow(int(BLOCK.stamp_ns[380]), layout.VECTOR, velocity(380))
        if again == 'reset':
            found.reset()
        block = WALK.block(START_NS - 60_000_000_000)
        for index in range(300):
            with suppress(NotLevelledError):
                found.update(block.sample(index))
            assert found.counts['aiding_twist'] == 0
        ends.append(found._state)
    np.testing.assert_array_equal(*ends)


def test_what_waits_for_its_samples_is_not_lost_however_much_there_is():
    """Wheels that tell their speed a thousand times a second, and a detector that looks ahead."""
    found, told = navigator(look_ahead=0.3), 0
    for index in range(400):
        with suppress(NotLevelledError):
            found.update(BLOCK.sample(index))
        for part in range(5 if index >= 200 else 0):
            stamp_ns = int(BLOCK.stamp_ns[index]) + part * 1_000_000
            found.follow(stamp_ns, layout.VECTOR, velocity(index))
            told += 1
    found.flush()
    assert told - 5 <= found._state[TAKEN : TAKEN + 2].sum() <= told
    ahead_ns = stamp_ns + 500_000_000
    for _ in range(LONGEST - len(found._aids.waiting)):
        found.follow(ahead_ns, layout.VECTOR, velocity(index))
    with pytest.raises(AidingError, match=r'4096 others wait .* is there still an Imu'):
        found.follow(ahead_ns, layout.VECTOR, velocity(index))


def test_a_restart_forgets_what_was_before():
    found = navigator()
    found.keep()
    for block in (BLOCK, WALK.block(START_NS - 60_000_000_000)):
        for index in range(400):
            with suppress(NotLevelledError):
                found.update(block.sample(index))
    found.follow(int(block.stamp_ns[380]), layout.VECTOR, velocity(380))
    with pytest.raises(AidingError, match='ahead of the Imu'):
        found.follow(int(BLOCK.stamp_ns[380]), layout.VECTOR, velocity(380))
    assert found._state[TAKEN : TAKEN + 2].sum() == 1.0
