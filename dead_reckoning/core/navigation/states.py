"""Read what the filter gives: its rows as states, and its counts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dead_reckoning.core.blocks import Array, Stamps, StateBlock
from dead_reckoning.core.kernels.navigation import layout
from dead_reckoning.core.samples import NavigationState
from dead_reckoning.core.stationarity import STATIONARY

COUNTED = {
    'zero_velocity': layout.ZUPT,
    'zero_velocity_refused': layout.ZUPT_REFUSED,
    'zero_rate': layout.ZARU,
    'zero_rate_refused': layout.ZARU_REFUSED,
    'floor': layout.ON_FLOOR,
    'new_floor': layout.NEW_FLOOR,
    'gravity_direction': layout.BOUNDED,
    'gravity_direction_refused': layout.BOUNDED_REFUSED,
    'nonholonomic': layout.ROLLING,
    'nonholonomic_refused': layout.ROLLING_REFUSED,
    'gap': layout.GAP,
    'saturated': layout.SATURATED,
    'placed': layout.PLACED,
}
WITNESSES = {
    'compass': layout.BY_COMPASS,
    'aiding_twist': layout.BY_TWIST,
    'aiding_odom': layout.BY_ODOM,
    'aiding_pose': layout.BY_POSE,
    'aiding_yaw': layout.BY_POSE_YAW,
}
for _name, _who in WITNESSES.items():
    COUNTED[_name] = layout.AIDED + 2 * _who
    COUNTED[f'{_name}_refused'] = layout.AIDED + 2 * _who + 1
"""What the filter counts, by name."""


def counts_of(state: Array) -> dict[str, int]:
    """Return how often the filter did what; all zero of a state that is empty."""
    first = layout.COUNTS
    return {
        name: int(state[first + index]) if len(state) else 0 for name, index in COUNTED.items()
    }


def state_of(stamp_ns: int, values: Sequence[float]) -> NavigationState:
    """Return a row of the kernel, shape (STATE_ROW,), as a state."""
    row: Any = tuple(values)
    return NavigationState(
        stamp_ns,
        row[0:3],
        row[3:6],
        row[6:10],
        row[10:19],
        row[19:28],
        row[28:37],
        row[37:40],
        row[40:49],
        row[67 + STATIONARY] > 0.0,
        row[49:58],
        row[58:67],
    )


def state_block(stamps: Stamps, rows: Array) -> StateBlock:
    """Return rows of the kernel, shape (n, STATE_ROW), as a block."""
    columns: list[Any] = list(layout.state_columns(rows))
    columns.insert(8, rows[:, 67 + STATIONARY] > 0.0)
    return StateBlock(stamps, *columns)
