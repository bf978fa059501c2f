"""States as rows of text."""

import math

import numpy as np
import pytest

from dead_reckoning.core.blocks import StateBlock
from dead_reckoning.core.chain import Chain
from dead_reckoning.core.rotation import quaternion_from_euler
from dead_reckoning.core.samples import LinearAcceleration, NavigationState
from dead_reckoning.core.stages import ACCELERATION, ODOMETRY
from dead_reckoning.tables import (
    LOG_COLUMNS,
    ODOMETRY_COLUMNS,
    LogError,
    OdometryLog,
    digits,
    lines,
    odometry_columns,
    odometry_row,
    stop_after,
)

COVARIANCE = (0.01, 0.0, 0.0, 0.0, 0.04, 0.0, 0.0, 0.0, 0.09)


def state(stamp_ns, **kwargs):
    return NavigationState(
        stamp_ns,
        (1.0, 2.0, 3.0),
        (4.0, 5.0, 6.0),
        quaternion_from_euler(0.0, 0.0, 0.5),
        COVARIANCE,
        **kwargs,
    )


def acceleration(stamp_ns):
    return LinearAcceleration(stamp_ns, 'odom', (7.0, 8.0, 9.0))


def test_columns_are_those_of_the_design():
    assert ','.join(ODOMETRY_COLUMNS) == (
        'stamp_ns,px,py,pz,qx,qy,qz,qw,vx,vy,vz,sx,sy,sz,stationary'
    )
    assert (*ODOMETRY_COLUMNS, 'ax', 'ay', 'az', 'heading') == LOG_COLUMNS


def test_row_follows_the_columns():
    row = dict(zip(ODOMETRY_COLUMNS, odometry_row(state(12, stationary=True)), strict=True))
    assert row['stamp_ns'] == 12
    assert (row['px'], row['vy'], row['stationary']) == (1.0, 5.0, 1)
    assert (row['sx'], row['sy'], row['sz']) == pytest.approx((0.1, 0.2, 0.3))
    assert (row['qz'], row['qw']) == pytest.approx((math.sin(0.25), math.cos(0.25)))


def test_log_has_a_row_for_each_state_with_its_acceleration(tmp_path):
    path = tmp_path / 'log.csv'
    log = OdometryLog(path)
    chain = Chain([log.stage()])
    for stamp_ns in (1, 2, 3):
        assert chain.push(ACCELERATION, acceleration(stamp_ns)) == []
        assert chain.push(ODOMETRY, state(stamp_ns)) == []
    lines = path.read_text(encoding='utf-8').splitlines()
    assert lines[0] == ','.join(LOG_COLUMNS)
    assert [line.split(',')[0] for line in lines[1:]] == ['1', '2', '3']
    row = dict(zip(LOG_COLUMNS, map(float, lines[1].split(',')), strict=True))
    assert (row['ax'], row['ay'], row['az']) == (7.0, 8.0, 9.0)
    assert row['heading'] == pytest.approx(0.5)
    log.close()


def test_log_of_states_without_an_acceleration_has_them_all(tmp_path):
    """An inertial navigator gives none, and what another one gives is of another sample."""
    log = OdometryLog(tmp_path / 'log.csv')
    chain = Chain([log.stage()])
    chain.push(ODOMETRY, state(1))
    chain.push(ACCELERATION, acceleration(3))
    chain.push(ODOMETRY, state(2))
    log.close()
    lines = (tmp_path / 'log.csv').read_text(encoding='utf-8').splitlines()
    assert [line.split(',')[0] for line in lines[1:]] == ['1', '2']
    for line in lines[1:]:
        row = dict(zip(LOG_COLUMNS, map(float, line.split(',')), strict=True))
        assert math.isnan(row['ax'])
        assert row['heading'] == pytest.approx(0.5)


def test_log_keeps_every_digit(tmp_path):
    path = tmp_path / 'log.csv'
    log = OdometryLog(path)
    third = NavigationState(1, (1.0 / 3.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    Chain([log.stage()]).push(ODOMETRY, third)
    log.close()
    assert float(path.read_text(encoding='utf-8').splitlines()[1].split(',')[1]) == 1.0 / 3.0


def test_a_log_that_can_not_be_written_is_said(tmp_path):
    with pytest.raises(LogError, match=r'pipeline\.log_csv: .*nowhere'):
        OdometryLog(tmp_path / 'nowhere' / 'log.csv')


def test_stop_after_counts_from_the_first_state():
    stopped = []
    chain = Chain([stop_after(2.0, lambda: stopped.append(True))])
    for seconds in (100, 101):
        chain.push(ODOMETRY, state(seconds * 10**9))
    assert not stopped
    chain.push(ODOMETRY, state(102 * 10**9))
    assert stopped


def test_stop_after_begins_anew_where_stamps_go_back():
    stopped = []
    chain = Chain([stop_after(2.0, lambda: stopped.append(True))])
    for seconds in (100, 101, 3, 4):
        chain.push(ODOMETRY, state(seconds * 10**9))
    assert not stopped
    chain.push(ODOMETRY, state(5 * 10**9))
    assert stopped


def test_columns_hold_the_rows():
    states = [state(5, stationary=True), state(6), state(-7)]
    columns = odometry_columns(StateBlock.of(states))
    assert lines(columns).splitlines() == [','.join(map(str, odometry_row(s))) for s in states]


@pytest.mark.parametrize(
    'values',
    [
        [],
        [1.0],
        [0.1, 0.1, 0.1],
        [0.0, -0.0, 0.0],
        [1 / 3, 1e-300, 5e-324, 1.7976931348623157e308, 1e22, 123456789.0],
        [1.0, 1.0, 2.0, 2.0, 1.0],
    ],
)
def test_digits_are_those_that_read_back_equal(values):
    table = np.column_stack([values, values])  # whose columns are no contiguous arrays
    assert digits(table[:, 0]) == [repr(value) for value in values]
