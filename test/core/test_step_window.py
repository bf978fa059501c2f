"""Which landings are steps, by the time between them."""

from dead_reckoning.core.step_window import StepWindow

SECOND = 1_000_000_000


def landings(times, shortest=0.3, longest=1.5):
    window = StepWindow(shortest, longest)
    steps = []
    for time in times:
        stamp = round((100.0 + time) * SECOND)
        if not window.too_soon(stamp):
            steps += [round(proven / SECOND - 100.0, 6) for proven in window.land(stamp)]
    return steps


def test_first_landing_counts_with_the_second():
    assert landings([0.0]) == []
    assert landings([0.0, 0.5]) == [0.0, 0.5]
    assert landings([0.0, 0.5, 1.0]) == [0.0, 0.5, 1.0]


def test_too_soon_is_no_landing():
    assert landings([0.0, 0.29, 0.31]) == [0.0, 0.31]
    assert landings([0.0, 0.2, 0.4, 0.6]) == [0.0, 0.4]


def test_too_late_ends_the_walk():
    assert landings([0.0, 1.5]) == [0.0, 1.5]
    assert landings([0.0, 1.51]) == []
    assert landings([0.0, 0.5, 3.0]) == [0.0, 0.5]
    assert landings([0.0, 0.5, 3.0, 3.5]) == [0.0, 0.5, 3.0, 3.5]


def test_walk_ends_by_itself():
    window = StepWindow(0.3, 1.5)
    window.land(SECOND)
    window.land(2 * SECOND)
    window.expire(3_500_000_000)
    assert window.walking
    window.expire(3_500_000_001)
    assert not window.walking
    assert window.last_ns is None


def test_changed_times_hold_from_then_on():
    window = StepWindow(0.3, 1.5)
    window.land(SECOND)
    window.configure(0.6, 3.0)
    assert window.too_soon(SECOND + 500_000_000)
    assert len(window.land(SECOND * 7 // 2)) == 2
