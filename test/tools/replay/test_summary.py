"""The time that stamps cover."""

import numpy as np
import pytest

from dead_reckoning.tools.replay.summary import Extent

S = 10**9


@pytest.mark.parametrize(
    ('stamps', 'duration'),
    [
        ([], 0),
        ([5 * S], 0),
        ([5 * S, 7 * S, 9 * S], 4 * S),
        ([5 * S, 9 * S, 9 * S - 1, 9 * S], 4 * S),  # late is no restart
        ([5 * S, 0, 9 * S], 4 * S),  # zero is no time
        ([0, 0], 0),
        ([5 * S, 9 * S, 8 * S, 10 * S], 6 * S),  # back by 1 s is one
        ([5 * S, 9 * S, 2 * S, 3 * S, 1 * S, 4 * S], 8 * S),
        ([-5 * S, -3 * S], 2 * S),
        ([9 * S, 1 * S] * 2000, 1999 * 8 * S),
    ],
)
@pytest.mark.parametrize('size', [1, 2, 10_000])
def test_duration_leaves_out_what_goes_back(stamps, duration, size):
    extent = Extent()
    for begin in range(0, len(stamps), size):
        extent.add(np.array(stamps[begin : begin + size], dtype=np.int64))
    assert extent.duration_ns == duration
