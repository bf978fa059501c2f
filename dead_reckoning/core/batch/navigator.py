"""Navigate by a block: `InertialNavigator` on columns."""

from __future__ import annotations

import numpy as np

from dead_reckoning.core.batch import NOTHING, Run
from dead_reckoning.core.blocks import ImuBlock
from dead_reckoning.core.chain import Output
from dead_reckoning.core.kernels.columns import imu_columns
from dead_reckoning.core.kernels.navigation.filter import regular
from dead_reckoning.core.kernels.navigation.layout import ROW
from dead_reckoning.core.mounting import Mountings, is_turned, unmounted
from dead_reckoning.core.navigator import InertialNavigator
from dead_reckoning.core.navigator_stage import StrideOutputs
from dead_reckoning.core.samples import ZERO
from dead_reckoning.core.stages import ODOMETRY


def navigator_run(
    navigator: InertialNavigator,
    mountings: Mountings = unmounted,
    strides: StrideOutputs | None = None,
) -> Run:
    """Return what navigates by a block.

    Left to the stream are alignment, faults, gaps, a sensor that is turned on its body or off its
    origin.
    """

    def run(block: ImuBlock, begin: int) -> tuple[int, list[Output]]:
        last_ns = regular_since(navigator)
        if last_ns is None:
            return NOTHING
        if is_turned(mountings, block.frame_id) or mountings(block.frame_id).translation != ZERO:
            return NOTHING
        rows = np.empty((len(block) - begin, ROW))
        max_gap, variance = navigator.settings.max_gap, navigator._rate_variance
        count = regular(imu_columns(block), begin, last_ns, max_gap, variance, rows)
        if not count:
            return NOTHING
        stamps = np.asarray(block.stamp_ns[begin : begin + count], np.int64)
        navigator._timeline._last_ns = int(stamps[-1])
        navigator._watch_compass(int(stamps[-1]))
        states = navigator.take(rows[:count], stamps)
        if not navigator.aligned:  # it diverged
            count = int(np.searchsorted(stamps, navigator.newest_ns, side='right'))
        if states is None:
            return count, []
        outputs: list[Output] = [(ODOMETRY, states)]
        if strides is not None:
            outputs += strides.of_block(states)
        return count, outputs

    return run


def regular_since(navigator: InertialNavigator) -> int | None:
    """Return the last stamp [ns] if it is aligned, and looks for no rest."""
    regular = navigator.aligned and not navigator.levelling
    return navigator._timeline._last_ns if regular else None
