"""Remove gravity from a block: `GravityRemoval` on columns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dead_reckoning.core.attitude.held import HeldAttitude
from dead_reckoning.core.attitude.message import MessageAttitude
from dead_reckoning.core.batch import NOTHING, Run
from dead_reckoning.core.blocks import AccelerationBlock, ImuBlock, LevelledBlock
from dead_reckoning.core.chain import Output
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.kernels.columns import imu_columns
from dead_reckoning.core.kernels.gravity import LevelledColumns, level_held, level_message
from dead_reckoning.core.mounting import Mountings, is_turned
from dead_reckoning.core.stages import ACCELERATION, IMU, LEVELLED


def level_run(removal: GravityRemoval, mountings: Mountings) -> Run:
    """Return what levels a block with an attitude that is held, or that comes with it.

    Left to the stream are: the search for rest, a compass, a sensor that is turned on its body.
    """
    source = removal._attitude

    def run(block: ImuBlock, begin: int) -> tuple[int, list[Output]]:
        last_ns = removal._timeline._last_ns
        if removal._search is not None or removal._stale or last_ns is None:
            return NOTHING
        if is_turned(mountings, block.frame_id):
            return NOTHING
        imu, out = imu_columns(block), _room(len(block) - begin)
        gravity, end = (removal.gravity, removal._gravity_variance), begin
        if isinstance(source, MessageAttitude):
            end = level_message(
                imu, begin, last_ns, source._fallback, gravity, removal._noise, out
            )
        elif isinstance(source, HeldAttitude) and source.attitude and _unaided(removal, source):
            end = level_held(
                imu,
                begin,
                last_ns,
                source.attitude,
                source.covariance,
                gravity,
                removal._noise,
                out,
            )
        if end == begin:
            return NOTHING
        removal._timeline._last_ns = int(block.stamp_ns[end - 1])
        part = block.part(begin, end)
        out = LevelledColumns(*(column[: end - begin] for column in out))
        acceleration = AccelerationBlock(
            part.stamp_ns, removal._world_frame, out.acceleration, out.covariance
        )
        if isinstance(source, MessageAttitude):
            source.advance(block.sample(end - 1), None)
            return end - begin, _outputs(part, acceleration)
        levelled = replace(
            part,
            specific_force_covariance=out.force_covariance,
            orientation=out.orientation,
            orientation_covariance=out.orientation_covariance,
        )
        return end - begin, [(IMU, levelled), *_outputs(levelled, acceleration)]

    return run


def _unaided(removal: GravityRemoval, source: HeldAttitude) -> bool:
    return source._yaw is None and removal._compass._last is None


def _room(count: int) -> LevelledColumns:
    return LevelledColumns(*(np.empty((count, width)) for width in (3, 9, 9, 4, 9)))


def _outputs(imu: ImuBlock, acceleration: AccelerationBlock) -> list[Output]:
    return [(ACCELERATION, acceleration), (LEVELLED, LevelledBlock(imu, acceleration))]
