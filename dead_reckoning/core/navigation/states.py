"""Read what the filter gives: its rows as states, and its counts."""

from __future__ import annotations

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


def state_of(stamp_ns: int, values: list[float]) -> NavigationState:
    """Return a row of the kernel, shape (STATE_ROW,), as a state."""
    px, py, pz, vx, vy, vz, qx, qy, qz, qw, *rest = values
    fields: Any = rest
    return NavigationState(
        stamp_ns,
        (px, py, pz),
        (vx, vy, vz),
        (qx, qy, qz, qw),
        tuple(fields[0:9]),
        tuple(fields[9:18]),
        tuple(fields[18:27]),
        tuple(fields[27:30]),
        tuple(fields[30:39]),
        fields[57 + STATIONARY] > 0.0,
        tuple(fields[39:48]),
        tuple(fields[48:57]),
    )


def state_block(stamps: Stamps, rows: Array) -> StateBlock:
    """Return rows of the kernel, shape (n, STATE_ROW), as a block."""
    columns: list[Any] = list(layout.state_columns(rows))
    columns.insert(8, rows[:, 67 + STATIONARY] > 0.0)
    return StateBlock(stamps, *columns)
