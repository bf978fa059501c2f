"""Integrate a block: `Integrator` on columns."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from dead_reckoning.core.batch import NOTHING, Run, first
from dead_reckoning.core.bias_growth import BiasGrowth
from dead_reckoning.core.blocks import Array, LevelledBlock, StateBlock
from dead_reckoning.core.chain import Output
from dead_reckoning.core.integration.open_loop import OpenLoop
from dead_reckoning.core.integrator import Integrator
from dead_reckoning.core.kernels.bias_growth import Growth
from dead_reckoning.core.kernels.columns import imu_columns, in_one_piece
from dead_reckoning.core.kernels.integrator import (
    Motion,
    Rules,
    StateColumns,
    integrate,
)
from dead_reckoning.core.mounting import Mountings, is_turned
from dead_reckoning.core.samples import ZERO, Vector
from dead_reckoning.core.stages import ODOMETRY


def integrator_run(integrator: Integrator, mountings: Mountings) -> Run:
    """Return what integrates a block by trapezoids or Euler's method along two or three axes.

    Left to the stream are: one axis, `kalman`, a calibration, a sensor that is turned on its body
    or off its origin.
    """

    def run(block: LevelledBlock, begin: int) -> tuple[int, list[Output]]:
        last_ns, parts = regular_since(integrator), parts_of(integrator)
        if last_ns is None or parts is None:
            return NOTHING
        frame_id = block.imu.frame_id
        if is_turned(mountings, frame_id) or mountings(frame_id).translation != ZERO:
            return NOTHING
        way, grown = parts
        rules, motion, growth = rules_of(integrator), motion_of(integrator, way), growth_of(grown)
        out = _room(len(block) - begin)
        end = integrate(
            imu_columns(block.imu),
            in_one_piece(block.acceleration.acceleration),
            in_one_piece(block.acceleration.covariance),
            begin,
            last_ns,
            rules,
            motion,
            growth,
            out,
        )
        if end == begin:
            return NOTHING
        integrator._timeline._last_ns = int(block.stamp_ns[end - 1])
        leave_motion(integrator, way, motion)
        leave_growth(grown, growth)
        columns: list[Any] = [first(column, end - begin) for column in out]
        return end - begin, [(ODOMETRY, StateBlock(block.stamp_ns[begin:end], *columns))]

    return run


def _room(count: int) -> StateColumns:
    def rows(width: int) -> Array:
        return np.empty((count, width))

    flags = np.empty(count, np.bool_)
    return StateColumns(
        rows(3), rows(3), rows(4), rows(9), rows(9), rows(9), rows(3), rows(9), flags
    )


def parts_of(integrator: Integrator) -> tuple[OpenLoop, BiasGrowth] | None:
    """Return method and covariance of an integrator, if there are kernels for them."""
    way = integrator._integration
    if isinstance(way, OpenLoop) and isinstance(way._growth, BiasGrowth):
        return way, way._growth
    return None


def regular_since(integrator: Integrator) -> int | None:
    """Return the last stamp [ns] unless it calibrates."""
    many = len(integrator._movement_end._recent) > integrator.settings.movement_end_samples
    return None if many or integrator._window is not None else integrator._timeline._last_ns


def rules_of(integrator: Integrator) -> Rules:
    """Return the settings of an integrator."""
    settings = integrator.settings
    return Rules(
        settings.method == 'euler',
        settings.movement_end != 'off',
        settings.movement_end == 'each',
        np.array([axis in integrator._axes for axis in range(3)]),
        settings.window_minimum,
        settings.window_maximum,
        settings.movement_end_deviation,
        settings.max_gap,
        settings.stationary_deviation,
        settings.scale_deviation,
        integrator._attitude_fallback,
        integrator._noise_fallback,
        integrator._rate_fallback,
    )


def motion_of(integrator: Integrator, way: OpenLoop) -> Motion:
    """Return the state of an integrator."""
    movement_end = integrator._movement_end
    count = len(movement_end._recent)
    recent = np.empty((integrator.settings.movement_end_samples, 3))
    recent[:count] = np.reshape(movement_end._recent, (count, 3))
    return Motion(
        np.array(way.position),
        np.array(way.velocity),
        np.array(way._acceleration),
        np.array(integrator.offset),
        np.array([integrator._stationary]),
        np.array(movement_end._quiet, np.int64),
        recent,
        np.array([count - 1, count, movement_end._age], np.int64),
        np.array(movement_end._sum),
        np.array(movement_end._squares),
    )


def leave_motion(integrator: Integrator, way: OpenLoop, motion: Motion) -> None:
    """Carry the state back."""
    way.position, way.velocity = _tuple(motion.position), _tuple(motion.velocity)
    way._acceleration = _tuple(motion.acceleration)
    integrator._stationary = bool(motion.stationary[0])
    newest, count, age = motion.ring.tolist()
    recent = np.roll(motion.recent, count - 1 - newest, axis=0)[:count]
    movement_end = integrator._movement_end
    movement_end._recent = deque((x, y, z) for x, y, z in recent.tolist())
    movement_end._sum, movement_end._squares = motion.sums.tolist(), motion.squares.tolist()
    movement_end._quiet, movement_end._age = motion.quiet.tolist(), age


def _tuple(array: Array) -> Vector:
    x, y, z = array.tolist()
    return x, y, z


def growth_of(growth: BiasGrowth) -> Growth:
    """Return the state of a covariance."""
    return Growth(
        growth._sensitivity[:3],
        growth._sensitivity[3:],
        growth._sigma[:3, :3].flatten(),
        growth._sigma[3:4, 3].copy(),
        growth._sigma[4:5, 4].copy(),
        np.array([growth._pp, growth._pv, growth._vv]),
        np.ones(3) if growth._mask is None else np.diag(growth._mask).copy(),
        growth._jacobian,
    )


def leave_growth(growth: BiasGrowth, left: Growth) -> None:
    """Carry the state back."""
    growth._sensitivity[:3], growth._sensitivity[3:] = left.position, left.velocity
    growth._pp, growth._pv, growth._vv = left.white.tolist()
    growth._sigma[:3, :3] = left.attitude.reshape(3, 3)
    growth._sigma[3, 3] = left.gravity_variance[0]
    growth._attitude_covariance = None
    growth.forget()
