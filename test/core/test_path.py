"""The path: few poses, once a second, the whole way."""

from itertools import pairwise
from math import dist

from dead_reckoning.core.path import MOST, PathKeeper
from dead_reckoning.core.samples import ZERO, NavigationState


def keep(count, step=0.02, period_ns=10_000_000):
    """Return the paths that were given on a straight way, with the stamps at which they were."""
    keeper, given = PathKeeper(), []
    for k in range(count):
        state = NavigationState(1 + k * period_ns, (k * step, 0.0, 0.0), ZERO)
        keeper.take(state)
        path = keeper.path()
        if path is not None:
            given.append((state.stamp_ns, path))
    return given


def test_it_is_given_once_a_second_at_most():
    stamps = [stamp for stamp, _ in keep(1000)]
    assert len(stamps) == 10
    assert min(b - a for a, b in pairwise(stamps)) >= 1_000_000_000


def test_poses_are_a_tenth_of_a_metre_apart():
    path = keep(1000)[-1][1]
    gaps = [dist(a[1], b[1]) for a, b in pairwise(path.poses)]
    assert 0.1 <= min(gaps) <= max(gaps) < 0.125
    assert path.stamp_ns == path.poses[-1][0]


def test_a_body_that_rests_gives_none():
    assert len(keep(5000, step=0.0)) == 1


def test_a_long_way_keeps_its_begin_and_its_length():
    path = keep(40_000, step=0.1)[-1][1]
    assert MOST // 3 < len(path.poses) <= MOST
    assert path.poses[0][1] == (0.0, 0.0, 0.0)
    assert path.poses[-1][1][0] > 3980.0


def test_what_was_given_does_not_change():
    (_, first), *_, (_, last) = keep(1000)
    assert len(first.poses) == 1
    assert len(last.poses) > 100
