"""Remove gravity from a block: `GravityRemoval` on columns."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np

from dead_reckoning.core.attitude.estimated import EstimatedAttitude
from dead_reckoning.core.attitude.held import HeldAttitude
from dead_reckoning.core.attitude.message import MessageAttitude
from dead_reckoning.core.batch import NOTHING, Run, first
from dead_reckoning.core.blocks import AccelerationBlock, Array, ImuBlock, LevelledBlock
from dead_reckoning.core.chain import Output
from dead_reckoning.core.gravity import GravityRemoval
from dead_reckoning.core.kernels.columns import imu_columns
from dead_reckoning.core.kernels.estimated import Estimate, EstimateRules, level_estimated
from dead_reckoning.core.kernels.gravity import LevelledColumns, level_held, level_message
from dead_reckoning.core.mounting import Mountings, is_turned
from dead_reckoning.core.rest import RestWindow
from dead_reckoning.core.rotation import isotropic
from dead_reckoning.core.samples import Quaternion
from dead_reckoning.core.stages import ACCELERATION, IMU, LEVELLED


def level_run(removal: GravityRemoval, mountings: Mountings) -> Run:
    """Return what removes gravity from a block.

    Left to the stream are: the search for rest, the sample that ends a rest of the gyro, a
    compass, a sensor that is turned on its body.
    """
    source = removal._attitude

    def run(block: ImuBlock, begin: int) -> tuple[int, list[Output]]:
        last_ns = regular_since(removal)
        if last_ns is None or is_turned(mountings, block.frame_id):
            return NOTHING
        if isinstance(source, MessageAttitude):
            levelled = _level_message(removal, source, block, begin, last_ns)
        elif isinstance(source, HeldAttitude):
            levelled = _level_held(removal, source, block, begin, last_ns)
        elif isinstance(source, EstimatedAttitude):
            levelled = _level_estimated(removal, source, block, begin, last_ns)
        if not len(levelled):
            return NOTHING
        removal._timeline._last_ns = int(levelled.stamp_ns[-1])
        outputs = [(ACCELERATION, levelled.acceleration), (LEVELLED, levelled)]
        if not isinstance(source, MessageAttitude):
            outputs.append((IMU, levelled.imu))
        return len(levelled), outputs

    return run


def regular_since(removal: GravityRemoval) -> int | None:
    """Return the last stamp [ns] if it looks for no rest and has no compass."""
    if removal._search is not None or removal._compass._last is not None or removal._stale:
        return None
    return removal._timeline._last_ns


def held(source: HeldAttitude) -> Quaternion | None:
    """Return the attitude that is held, once it is known and as long as it stays."""
    return source.attitude if source._yaw is None else None


def _level_message(
    removal: GravityRemoval, source: MessageAttitude, block: ImuBlock, begin: int, last_ns: int
) -> LevelledBlock:
    out, gravity = _room(block, begin), (removal.gravity, removal._gravity_variance)
    end = level_message(
        imu_columns(block), begin, last_ns, source._fallback, gravity, removal._noise, out
    )
    if end > begin:
        source.advance(block.sample(end - 1), None)
    imu = block.part(begin, end)
    return LevelledBlock(imu, _acceleration(removal, imu, out))


def _level_held(
    removal: GravityRemoval, source: HeldAttitude, block: ImuBlock, begin: int, last_ns: int
) -> LevelledBlock:
    out, gravity = _room(block, begin), (removal.gravity, removal._gravity_variance)
    end, attitude = begin, held(source)
    if attitude is not None:
        end = level_held(
            imu_columns(block),
            begin,
            last_ns,
            attitude,
            source.covariance,
            gravity,
            removal._noise,
            out,
        )
    return _levelled(removal, block.part(begin, end), out)


def _level_estimated(
    removal: GravityRemoval, source: EstimatedAttitude, block: ImuBlock, begin: int, last_ns: int
) -> LevelledBlock:
    search = source.bias._search
    if source.attitude is None or search._rate is None:
        return _levelled(removal, block.part(begin, begin), _room(block, begin))
    out, gravity = _room(block, begin), (removal.gravity, removal._gravity_variance)
    rate, rate_covariance = np.empty((len(block) - begin, 3)), np.empty((len(block) - begin, 9))
    state = _estimate(source)
    rules = _rules(removal, source, search._force, int(block.stamp_ns[begin]))
    end = level_estimated(
        imu_columns(block),
        begin,
        last_ns,
        rules,
        state,
        gravity,
        rate,
        rate_covariance,
        out,
    )
    part = block.part(begin, end)
    if end > begin:
        _leave(source, state)
        search._force.extend(part.stamp_ns, part.specific_force)
        search._rate.extend(part.stamp_ns, part.angular_velocity)
    turned = replace(
        part,
        angular_velocity=first(rate, end - begin),
        angular_velocity_covariance=first(rate_covariance, end - begin),
    )
    return _levelled(removal, turned, out)


def _estimate(source: EstimatedAttitude) -> Estimate:
    figures = (
        source._gravity,
        source._motion,
        source._lost,
        source._shaken,
        source._yaw_variance,
        source._yaw_bias,
        source.bias.variance,
    )
    vectors = (source._rate, source._force, source._turned, figures)
    return Estimate(np.array(source.attitude), *map(np.array, vectors))


def _rules(
    removal: GravityRemoval, source: EstimatedAttitude, window: RestWindow, first_ns: int
) -> EstimateRules:
    settings = removal.settings
    return EstimateRules(
        source.bias.value,
        settings.tilt_time,
        settings.max_gap,
        settings.rate_walk**2,
        settings.rate_scale_deviation,
        source._level_variance,
        source._compass_deviation**2,
        isotropic(sqrt(source._rate_variance)),
        removal._noise,
        window._start_ns if window._values else first_ns,
        len(window._values) // 3,
        window._duration_ns,
    )


def _leave(source: EstimatedAttitude, state: Estimate) -> None:
    x, y, z, w = state.attitude.tolist()
    source._set((x, y, z, w))
    source._rate, source._force, source._turned = (
        (x, y, z) for x, y, z in (a.tolist() for a in (state.rate, state.force, state.turned))
    )
    (
        source._gravity,
        source._motion,
        source._lost,
        source._shaken,
        source._yaw_variance,
        source._yaw_bias,
        source.bias.variance,
    ) = state.figures.tolist()


def _room(block: ImuBlock, begin: int) -> LevelledColumns:
    def rows(width: int) -> Array:
        return np.empty((len(block) - begin, width))

    return LevelledColumns(rows(3), rows(9), rows(9), rows(4), rows(9))


def _levelled(removal: GravityRemoval, part: ImuBlock, out: LevelledColumns) -> LevelledBlock:
    """Put together what comes out where the attitude did not come with the message."""
    imu = replace(
        part,
        specific_force_covariance=first(out.force_covariance, len(part)),
        orientation=first(out.orientation, len(part)),
        orientation_covariance=first(out.orientation_covariance, len(part)),
    )
    return LevelledBlock(imu, _acceleration(removal, imu, out))


def _acceleration(
    removal: GravityRemoval, imu: ImuBlock, out: LevelledColumns
) -> AccelerationBlock:
    return AccelerationBlock(
        imu.stamp_ns,
        removal._world_frame,
        first(out.acceleration, len(imu)),
        first(out.covariance, len(imu)),
    )
