"""Smoothing stride by stride: late by one, by what is known up to then, in bounded memory."""

from contextlib import suppress
from itertools import cycle
from math import dist

import numpy as np
import pytest
from simulated_walks import START_NS, blocks_of, joined, measured, navigator, walk
from simulated_walks import streamed as to_the_end

from dead_reckoning.core import smoother as smoother_module
from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.errors import NotLevelledError
from dead_reckoning.core.navigation.history import STRETCH
from dead_reckoning.core.smoother import LONGEST_NS, Smoother, StrideSmoother
from dead_reckoning.core.strides import SHORTEST

TRUE = walk(strides=8, turn=0.2, mounted=np.eye(3))
WALK = measured(TRUE, 1)


def streamed(block, found=None, smoother=None):
    """Return states, and the parts that were smoothed with how late each came [ns]."""
    found = found or navigator()
    smoother = smoother or StrideSmoother(found)
    states, parts = [], []
    for index in range(len(block)):
        with suppress(NotLevelledError):
            new = found.update(block.sample(index))
            states += new
            for part in smoother.take(StateBlock.of(new)) if new else []:
                parts.append((part, new[-1].stamp_ns - int(part.stamp_ns[-1])))
    return found, states, parts, smoother


def test_each_state_comes_once_when_the_foot_has_left_its_stance():
    found, states, parts, smoother = streamed(WALK.block())
    stamps = [state.stamp_ns for state in states]
    given = np.concatenate([part.stamp_ns for part, _ in parts])
    np.testing.assert_array_equal(given, stamps[: len(given)])
    assert len(parts) == found.strides.count
    for part, late in parts:
        assert part.stationary[-1]
        assert np.count_nonzero(np.diff(part.stationary.astype(int)) > 0) <= 1
        stood = stamps.index(part.stamp_ns[-1])
        now = stamps.index(part.stamp_ns[-1] + late)
        away = [dist(state.position, states[stood].position) for state in states[stood : now + 1]]
        assert max(away[:-1]) <= SHORTEST < away[-1]
    new = found.flush()
    (rest,) = [*smoother.take(StateBlock.of(new)), *smoother.flush()]
    assert rest.stamp_ns[-1] == new[-1].stamp_ns
    assert len(given) + len(rest) == len(stamps) + len(new)


def test_a_part_is_what_a_smoother_makes_of_all_up_to_its_end():
    part = streamed(WALK.block())[2][4][0]
    end = np.searchsorted(WALK.block().stamp_ns, part.stamp_ns[-1])
    whole = navigator()
    record = Smoother(whole)
    waiting = round(0.045 * 200.0)
    for index in range(end + waiting):
        with suppress(NotLevelledError):
            whole.update(WALK.block().sample(index))
    expected = StateBlock.join(list(record.blocks())[::-1])
    assert expected.stamp_ns[-1] == part.stamp_ns[-1]
    begin = len(expected) - len(part)
    np.testing.assert_allclose(part.position, expected.position[begin:], atol=1e-12)
    np.testing.assert_allclose(
        part.position_covariance, expected.position_covariance[begin:], atol=1e-15
    )


def test_in_blocks_it_is_the_same():
    _, _, parts, _ = streamed(WALK.block())
    streams = StateBlock.join([part for part, _ in parts])
    found = navigator()
    smoother, blocks = StrideSmoother(found), []
    for states in blocks_of(found, WALK.block()):
        blocks += smoother.take(states)
    given = StateBlock.join(blocks)
    np.testing.assert_array_equal(given.stamp_ns, streams.stamp_ns)
    np.testing.assert_array_equal(given.position, streams.position)


def taken(change, sizes):
    """Return the parts of a walk whose rests are changed first, its states in blocks of sizes."""
    found = navigator()
    smoother = StrideSmoother(found)
    states = to_the_end(found, WALK.block())
    change(states.stationary)
    parts, begin = [], 0
    while begin < len(states):
        end = begin + next(sizes)
        parts += smoother.take(states.part(begin, min(end, len(states))))
        begin = end
    return states, [*parts, *smoother.flush()]


def test_a_stance_broken_in_two_is_one():
    def broken(rests):
        begins = np.flatnonzero(np.diff(rests.astype(int)) > 0) + 1
        rests[begins[:, None] + np.arange(10, 20)] = False

    parts = taken(broken, cycle([100]))[1]
    expected = taken(lambda _: None, cycle([100]))[1]
    assert len(parts) == len(expected)
    for part, whole in zip(parts, expected, strict=True):
        np.testing.assert_array_equal(part.stamp_ns, whole.stamp_ns)


def test_whatever_is_taken_for_rest_each_state_comes_once_and_sizes_of_blocks_do_not_matter(
    monkeypatch,
):
    monkeypatch.setattr(smoother_module, 'LONGEST_NS', 400_000_000)

    def at_random(rests):
        rests[:] = np.repeat(np.random.default_rng(3).random(len(rests)) < 0.5, 15)[: len(rests)]

    states, parts = taken(at_random, cycle([1]))
    given = StateBlock.join(parts)
    np.testing.assert_array_equal(given.stamp_ns, states.stamp_ns)
    lasts = [np.ptp(part.stamp_ns) for part in parts]
    assert max(lasts) <= 400_000_000
    assert len(parts) > 20
    sizes = np.random.default_rng(4).integers(1, 120, len(states))
    _, others = taken(at_random, iter(sizes.tolist()))
    assert [len(part) for part in others] == [len(part) for part in parts]
    np.testing.assert_array_equal(StateBlock.join(others).position, given.position)


def test_height_is_known_better_and_nothing_worse_on_average():
    errors = {'causal': [], 'smoothed': []}
    for seed in range(6):
        moved = measured(TRUE, seed)
        _, states, parts, _ = streamed(moved.block())
        stamps = START_NS + np.round(TRUE.time * 1e9).astype(np.int64)
        for name, block in (
            ('causal', StateBlock.of(states)),
            ('smoothed', StateBlock.join([part for part, _ in parts])),
        ):
            at = np.searchsorted(stamps, block.stamp_ns)
            errors[name].append((block.position[:, 2] - TRUE.position[at, 2]).std())
    assert np.mean(errors['smoothed']) < 0.5 * np.mean(errors['causal'])


def test_without_a_stance_it_comes_all_the_same_and_memory_is_bounded():
    found = navigator(zero_velocity=False, look_ahead=0.0)
    smoother = StrideSmoother(found)
    drive = joined(*[walk(strides=20, turn=0.2, mounted=np.eye(3), end=0.0)] * 2)
    block = measured(drive, 1).block()
    kept = []
    for index in range(len(block)):
        with suppress(NotLevelledError):
            new = found.update(block.sample(index))
            if not new:
                continue
            states = StateBlock.of(new)
            states.stationary[:] = False
            for part in smoother.take(states):
                assert part.stamp_ns[-1] - part.stamp_ns[0] <= LONGEST_NS
                kept.append(part)
            assert found.history is not None
            assert len(found.history.stretches) * STRETCH <= 10.0 * 200.0 + 3 * STRETCH
    assert len(kept) >= 3


@pytest.mark.parametrize('again', ['reset', 'restart'])
def test_after_a_new_start_it_begins_anew(again):
    found, _, _, smoother = streamed(WALK.block())
    if again == 'reset':
        found.reset()
    start_ns = START_NS + (3600_000_000_000 if again == 'reset' else -3600_000_000_000)
    _, states, parts, _ = streamed(WALK.block(start_ns), found, smoother)
    fresh = [part for part, _ in streamed(WALK.block(start_ns))[2]]
    np.testing.assert_array_equal(parts[0][0].stamp_ns, fresh[0].stamp_ns)
    given, expected = StateBlock.join([p for p, _ in parts]), StateBlock.join(fresh)
    np.testing.assert_array_equal(given.position, expected.position)
    assert states
