"""CH Robotics' Table 1: from where its numbers come, and what is odd about them."""

import math
from decimal import Decimal
from pathlib import Path

import pytest

from dead_reckoning.core.reference.attitude_error import ACCELERATIONS, table

PAGE = (Path(__file__).parents[3] / 'docs' / 'reference-algorithms.md').read_text(encoding='utf-8')

GRAVITY = 9.8
"""What the note recommends [m/s²]; 9.80665 would make 0.855 of 5°."""


def exact(angle):
    return GRAVITY * math.sin(math.radians(float(angle)))


@pytest.mark.parametrize('angle', ['0.1', '0.5', '2.0', '3.0', '5.0'])
def test_acceleration_is_rounded_to_thousandths(angle):
    assert f'{exact(angle):.3f}' == str(ACCELERATIONS[Decimal(angle)])


def test_one_degree_has_a_digit_less_than_the_rest():
    assert f'{exact("1.0"):.3f}' == '0.171'
    assert ACCELERATIONS[Decimal('1.0')] == Decimal('0.17')


def test_one_and_a_half_degrees_are_cut_off():
    assert f'{exact("1.5"):.4f}' == '0.2565'
    assert f'{exact("1.5"):.3f}' == '0.257'
    assert ACCELERATIONS[Decimal('1.5')] == Decimal('0.256')


def test_positions_are_twice_what_integration_gives():
    for row, half in zip(table(), table(corrected=True), strict=True):
        assert (row.angle, row.acceleration, row.velocity) == (
            half.angle,
            half.acceleration,
            half.velocity,
        )
        assert row.velocity == 10 * row.acceleration
        times = (10, 60, 600)
        assert row.positions[:3] == tuple(row.acceleration * t * t for t in times)
        assert half.positions[:3] == tuple(row.acceleration * t * t / 2 for t in times)


def test_last_column_is_rounded_to_two_digits():
    assert [float(row.positions[-1]) for row in table()] == [
        *(220e3, 1.1e6, 2.2e6, 3.3e6, 4.4e6, 6.6e6, 11e6)
    ]
    assert [float(row.positions[-1]) for row in table(corrected=True)] == [
        *(110e3, 560e3, 1.1e6, 1.7e6, 2.2e6, 3.3e6, 5.5e6)
    ]


def test_one_degree_after_a_minute_is_no_kilometre():
    """The prose of the note says almost a kilometre."""
    (printed,) = (row for row in table() if row.angle == 1)
    assert printed.positions[1] == 612
    assert exact('1.0') * 60**2 / 2 == pytest.approx(308, abs=0.5)


def test_page_has_the_table_beside_what_is_true():
    for row, half in zip(table(), table(corrected=True), strict=True):
        accel = exact(row.angle)
        minute, ten = accel * 60**2 / 2, accel * 600**2 / 2000
        metres = accel * 10**2 / 2
        (line,) = (line for line in PAGE.splitlines() if line.startswith(f'| {row.angle}° |'))
        _, _, first, printed, true, corrected, twice, *rest, _ = map(str.strip, line.split('|'))
        assert first == f'{accel:.5f}'
        assert (printed, corrected, twice) == (
            str(row.acceleration),
            str(half.positions[0]),
            str(row.positions[0]),
        )
        assert float(true.removesuffix(' m')) == pytest.approx(metres, abs=0.006)
        assert float(rest[0].removesuffix(' m')) == pytest.approx(minute, abs=0.051)
        assert float(rest[1].removesuffix(' km')) == pytest.approx(ten, abs=0.051)
