"""Take messages through gravity removal and integrator, and count steps beside."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.attitude.held import HeldAttitude
from dead_reckoning.core.attitude.message import MessageAttitude
from dead_reckoning.core.batch import gravity, integrator
from dead_reckoning.core.chain import Output
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.kernels import memory as layout
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.live import IRREGULAR, RESTS, take
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.rotation import NO_ROTATION
from dead_reckoning.core.stages import IMU, gravity_input
from dead_reckoning.live.chain import LiveChain

LEVELLED_WIDTHS = (3, 9, 9, 4, 9)
STATE_WIDTHS = (3, 3, 4, 9, 9, 9, 3, 9, 1)


class IntegratorChain(LiveChain):
    """Do all of it in one call of a kernel."""

    KERNELS = ((take, (layout.nothing(),)),)

    def __init__(self, pipeline: Pipeline, frames: FrameSettings, taken: str) -> None:
        super().__init__(pipeline, frames, taken)
        assert pipeline.gravity is not None
        assert pipeline.integrator is not None
        self._gravity, self._integrator = pipeline.gravity, pipeline.integrator

    @staticmethod
    def taken_of(pipeline: Pipeline) -> str | None:
        """Name the topic that kernels take for a pipeline; None: they can't do what it does."""
        removal, moving, counting = pipeline.gravity, pipeline.integrator, pipeline.pedometer
        if removal is None or moving is None or integrator.parts_of(moving) is None:
            return None
        if not isinstance(removal._attitude, HeldAttitude | MessageAttitude):
            return None
        if len(pipeline.stages) != 2 + (counting is not None):
            return None
        taken = gravity_input(removal.settings.attitude)
        return taken if counting is None or counting.settings.input in (IMU, taken) else None

    def _regular_since(self) -> tuple[int, float] | None:
        last_ns = gravity.regular_since(self._gravity)
        if last_ns is None or last_ns != integrator.regular_since(self._integrator):
            return None
        return last_ns, self._integrator.settings.max_gap

    def _parts(self) -> Mapping[int, NDArray[Any]] | None:
        removal, integrating = self._gravity, self._integrator
        source, moving = removal._attitude, integrator.parts_of(integrating)
        assert moving is not None
        if isinstance(source, HeldAttitude):
            attitude, tilt = gravity.held(source), source.covariance
        else:
            assert isinstance(source, MessageAttitude)
            attitude, tilt = NO_ROTATION, source._fallback
        if attitude is None:
            return None
        return layout.numbered(
            layout.ATTITUDE,
            (
                *map(np.array, (attitude, tilt)),
                np.array((removal.gravity, removal._gravity_variance)),
                np.array(removal._noise),
                *map(np.zeros, LEVELLED_WIDTHS),
                *map(np.zeros, STATE_WIDTHS),
                *layout.rules_in(integrator.rules_of(integrating)),
                *integrator.motion_of(integrating, moving[0]),
                *integrator.growth_of(moving[1]),
            ),
        )

    def _run(self, memory: Array) -> list[Output] | None:
        brought = take(memory)
        if brought == IRREGULAR:
            return None
        return self._steps.of(brought) + self._state(bool(brought & RESTS))

    def _leave(self, memory: Array, last_ns: int) -> None:
        self._gravity._timeline._last_ns = self._integrator._timeline._last_ns = last_ns
        parts = integrator.parts_of(self._integrator)
        assert parts is not None
        integrator.leave_motion(self._integrator, parts[0], layout.motion_of(memory))
        integrator.leave_growth(parts[1], layout.growth_of(memory))
