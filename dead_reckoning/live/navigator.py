"""Take messages through the inertial navigator, and count steps beside."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dead_reckoning.core.batch.navigator import regular_since
from dead_reckoning.core.chain import FAULT, Output
from dead_reckoning.core.common import FrameSettings
from dead_reckoning.core.kernels import memory as layout
from dead_reckoning.core.kernels.columns import Array
from dead_reckoning.core.kernels.live import IRREGULAR, read, write
from dead_reckoning.core.kernels.navigation.layout import ROW, STATE_ROW
from dead_reckoning.core.pipeline import Pipeline
from dead_reckoning.core.stages import BESIDE
from dead_reckoning.live.chain import LiveChain


class NavigatorChain(LiveChain):
    """Read, let the navigator filter, and write.

    Its state is an array already, which stays where it is: what it knows beside the samples, as
    the yaw of a compass, it takes at any time.
    """

    KERNELS = (
        (read, (layout.nothing(), np.zeros((1, ROW)))),
        (write, (layout.nothing(), np.zeros((1, STATE_ROW)), 0)),
    )
    BESIDE = BESIDE

    def __init__(self, pipeline: Pipeline, frames: FrameSettings, taken: str) -> None:
        super().__init__(pipeline, frames, taken)
        assert pipeline.navigator is not None
        self._navigator = pipeline.navigator

    @staticmethod
    def taken_of(pipeline: Pipeline) -> str | None:
        """Name the topic that kernels take for a pipeline; None: they can't do what it does."""
        navigator, counting = pipeline.navigator, pipeline.pedometer
        if navigator is None or len(pipeline.stages) != 1 + (counting is not None):
            return None
        if navigator.settings.smoothing:
            return None
        taken = navigator.settings.input
        if counting is None:
            return taken
        asked = counting.settings
        return taken if asked.input == taken and asked.heading != 'navigator' else None

    def _regular_since(self) -> tuple[int, float] | None:
        last_ns = regular_since(self._navigator)
        return None if last_ns is None else (last_ns, self._navigator.settings.max_gap)

    def _parts(self) -> Mapping[int, NDArray[Any]]:
        navigator = self._navigator
        bounds = np.array((navigator.settings.max_gap, navigator._rate_variance))
        return {layout.NAVIGATED: bounds}

    def _run(self, memory: Array) -> list[Output] | None:
        navigator = self._navigator
        brought = read(memory, navigator.row)
        if brought == IRREGULAR:
            return None
        outputs: list[Output] = []
        now_ns = navigator._timeline._last_ns = int(self._clock[layout.STAMP])  # what aids goes by
        stamp_ns = navigator.advance(now_ns)
        if stamp_ns is not None:
            write(memory, navigator.out, stamp_ns)
            outputs = self._state(navigator.stationary)
        if navigator.findings:
            outputs.extend((FAULT, finding) for finding in navigator.findings)
            navigator.findings.clear()
        outputs += self._steps.of(brought)
        if not navigator.aligned:  # it diverged
            self.settle()
        return outputs

    def _leave(self, memory: Array, last_ns: int) -> None:
        """Leave all where it is: the navigator was never behind."""
